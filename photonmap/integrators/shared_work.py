"""What the views of a scene share: done for the first of them, and used by the others."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.geometry import without_strays
from photonmap.compile.scene_arrays import CompiledScene, compile_scene, seen_by
from photonmap.errors import listening, repeat
from photonmap.io.scene_source import SceneSource
from photonmap.runtime.storage import free_memory
from photonmap.runtime.workers import Workers
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands

T = TypeVar("T")

KINDS = 2
"""Kinds of views, with different photons, whose work is kept: the last ones."""
MOST_BYTES = 512e6
"""Of photon maps that are kept for further views of a kind."""
PART = 1 / 4
"""Of the free memory, and of the memory that a render may use, that they fill at most."""


class Room:
    """Bytes that are left for what is kept."""

    def __init__(self, size: float) -> None:
        self._left = size
        self._counted: dict[int, Any] = {}

    def take(self, record: Any) -> bool:
        """Return whether the arrays of a record fit in; those that are there already take none."""
        new = {id(each): each for each in _arrays(record) if id(each) not in self._counted}
        size = sum(each.nbytes for each in new.values())
        if size > self._left or size > PART * free_memory():
            return False
        self._left -= size
        self._counted |= new
        return True


NO_ROOM = Room(-1.0)


def _arrays(record: Any) -> Iterator[np.ndarray]:
    """Yield the arrays in a record and its records."""
    if isinstance(record, np.ndarray):
        yield record
    elif isinstance(record, tuple):
        for part in record:
            yield from _arrays(part)


@dataclass(frozen=True)
class _Compiled:
    """A scene that was compiled, and the warnings on the way."""

    scene: Scene
    bands: Bands
    compiled: CompiledScene
    messages: list[str]

    def is_of(self, scene: Scene, bands: Bands) -> bool:
        """Return whether a scene has the same meshes and lights, in the same bands."""
        pairs = (self.scene.meshes, scene.meshes), (self.scene.lights, scene.lights)
        same = all([*map(id, own)] == [*map(id, others)] for own, others in pairs)
        return same and self.bands == bands

    @cached_property
    def vertices(self) -> NDArray[np.float64]:
        """The vertices of all faces, (V, 3)."""
        meshes = [mesh for mesh in self.scene.meshes if len(mesh.faces)]
        return np.concatenate([without_strays(mesh).vertices for mesh in meshes])


class SharedScene:
    """Reads and compiles a scene once for renders that follow each other.

    Scenes are taken to be the same if they have the same meshes and lights, which do not change.
    """

    def __init__(self) -> None:
        self._loaded: tuple[SceneSource, Scene, list[str]] | None = None
        self._compiled: _Compiled | None = None

    def load(self, source: SceneSource) -> Scene:
        """Return `source.load()`; the file of views that follow each other is read once."""
        whole = replace(source, view=None)
        if self._loaded is not None and self._loaded[0] == whole:
            repeat(self._loaded[2])
        else:
            with listening() as messages:
                self._loaded = whole, source.read(), messages
        return source.choose(self._loaded[1])

    def compile(self, scene: Scene, bands: Bands, aspect: float) -> CompiledScene:
        """Return `compile_scene(…)`; a scene that differs in its camera alone is compiled once."""
        before = self._compiled
        if before is not None and before.is_of(scene, bands):
            seen = seen_by(before.compiled, scene, before.vertices)
            if seen is not None:
                repeat(before.messages)
                return seen
        with listening() as messages:
            compiled = compile_scene(scene, bands, aspect)
        self._compiled = _Compiled(scene, bands, compiled, messages)
        return compiled


class SharedWork(SharedScene):
    """What the views of a scene share: also the threads that render them, and photons."""

    def __init__(self, threads: int | None = None, memory: float | None = None) -> None:
        super().__init__()
        self._threads = threads
        self._most = min(MOST_BYTES, np.inf if memory is None else PART * memory / KINDS)
        self._made: dict[Hashable, Any] = {}

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """End the threads, if there are any yet."""
        if "workers" in vars(self):
            self.workers.__exit__(*exception)

    @cached_property
    def workers(self) -> Workers:
        """The threads that render."""
        return Workers(self._threads)

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what was made for an equal key, if that is among the last `KINDS`, or make it."""
        made: T = self._made.pop(key) if key in self._made else make()
        self._made[key] = made
        if len(self._made) > KINDS:
            del self._made[next(iter(self._made))]
        return made

    def make_room(self) -> Room:
        """Return the room for the photon maps of one kind of views."""
        return Room(self._most)
