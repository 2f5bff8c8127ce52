"""What cameras and rays see of a scene, without rendering it."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.buffers import DEFAULT
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import only_heard
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.kernels.core.passes import Film
from photonmap.kernels.geometry.embree import EmbreeScene
from photonmap.kernels.geometry.ray import find_clear, first_hits
from photonmap.runtime.workers import Workers
from photonmap.scene.camera import Camera
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands


class Onlooker:
    """Looks at a scene with any camera; what is to be said of the scene, its render says.

    A scene that cannot be rendered is an `InputError`. None stands for as many threads as
    processors.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        with only_heard():
            self._compiled = compile_scene(scene, Bands.parse(1))
        self._threads = threads

    def see(
        self, camera: Camera, size: tuple[int, int], kept: Container[str] = DEFAULT
    ) -> dict[str, NDArray[Any]]:
        """Return kept buffers at the pixels' centres, (H, W) or (H, W, 3), as a render has them."""
        compiled = replace(self._compiled, camera=camera)
        with Workers(self._threads) as workers:
            rows = first_hit_buffers(compiled, Film(*size, False), workers, kept)
        return {name: row.reshape(size[1], size[0], *row.shape[1:]) for name, row in rows.items()}


Floats = NDArray[np.float64]


class RayCaster:
    """Casts rays among triangles, (T, 3) rows of vertices, (V, 3) metres."""

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self._scene = EmbreeScene(
            np.asarray(vertices, np.float32), np.asarray(triangles, np.uint32)
        )

    def first_hits(self, origins: Floats, directions: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Return the triangle that each ray (P, 3) hits first, and the distance to it, (P,) both.

        A triangle is -1 where there is none; distances are in lengths of the directions.
        """
        triangles, distances = np.empty(len(origins), np.int64), np.empty(len(origins))
        first_hits(self._scene.address, origins, directions, triangles, distances)
        return triangles, distances

    def is_clear(self, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
        """Return whether nothing lies between points, (P, M), except close to the ends.

        Starts, (P, 3), lie off any surface. Ends, (M, 3), may lie on one: the last thousandth of
        the way does not count.
        """
        clear = np.empty((len(starts), len(ends)), np.bool_)
        find_clear(self._scene.address, starts, ends, clear)
        return clear
