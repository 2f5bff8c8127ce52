"""Things that stand in a scene: painted parts, and the places where others may rest on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from photonmap.dataset.shapes import Floats, Shape, joined
from photonmap.scene import Material, Mesh

TOUCH = 1e-6
"""Metres that boxes may overlap where things touch."""


@dataclass(frozen=True, eq=False)
class Part:
    """A surface of one material.

    Parameters
    ----------
    shape : in metres
    material : of all of it; of a lamp, when it is off
    lamp : "main" or "second" for the groups of lights that make it glow; "" for none
    """

    shape: Shape
    material: Material
    lamp: str = ""


@dataclass(frozen=True)
class Support:
    """A level rectangle to put things on.

    Parameters
    ----------
    x, z : lowest and highest coordinate, metres
    y : its height, metres
    room : above it, metres
    """

    x: tuple[float, float]
    z: tuple[float, float]
    y: float
    room: float = 10.0


@dataclass(frozen=True, eq=False)
class Thing:
    """An object: parts around the y axis that rest on y = 0 until they are placed.

    Parameters
    ----------
    name : of its kind
    parts : of which it consists
    supports : where things may rest, as long as it is not turned
    """

    name: str
    parts: Sequence[Part]
    supports: Sequence[Support] = field(default_factory=tuple)

    def changed(self, change: Callable[[Shape], Shape]) -> Thing:
        """Return the thing with all its shapes changed, and without supports."""
        parts = [replace(part, shape=change(part.shape)) for part in self.parts]
        return Thing(self.name, parts)

    def moved(self, offset: ArrayLike) -> Thing:
        """Return the thing moved by (x, y, z)."""
        return self.changed(lambda shape: shape.moved(offset))

    def turned(self, degrees: float) -> Thing:
        """Return the thing turned about the y axis."""
        return self.changed(lambda shape: shape.turned(degrees))

    @cached_property
    def boxes(self) -> Floats:
        """Bounds of its parts, (P, 2, 3)."""
        return np.stack([part.shape.bounds for part in self.parts])

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates, (2, 3)."""
        boxes = self.boxes
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def bounds_of(things: Iterable[Thing]) -> Floats:
    """Return lowest and highest coordinates of several things, (2, 3)."""
    bounds = np.stack([thing.bounds for thing in things])
    return np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


def overlap(first: Floats, second: Floats) -> bool:
    """Tell whether any box of one set, (n, 2, 3), cuts into one of another, (m, 2, 3)."""
    low = np.maximum(first[:, None, 0], second[None, :, 0])
    high = np.minimum(first[:, None, 1], second[None, :, 1])
    return bool((high - low > TOUCH).all(axis=2).any())


def solid(name: str, shape: Shape, material: Material) -> Thing:
    """Return a thing of one part."""
    return Thing(name, [Part(shape, material)])


def painted(name: str, shapes: Sequence[Shape], materials: Sequence[Material]) -> Thing:
    """Return a thing whose parts take the materials in turn."""
    parts = [
        Part(shape, materials[index % len(materials)])
        for index, shape in enumerate(shapes)
        if len(shape.faces)
    ]
    return Thing(name, parts)


def count_names(things: Iterable[Thing]) -> list[Thing]:
    """Give every thing a name of its own: the second vase is "vase 2"."""
    seen: dict[str, int] = {}
    named = []
    for thing in things:
        seen[thing.name] = count = seen.get(thing.name, 0) + 1
        named.append(replace(thing, name=thing.name if count == 1 else f"{thing.name} {count}"))
    return named


def meshes_of(thing: Thing, glow: Callable[[Part], Material]) -> list[Mesh]:
    """Return a thing as meshes of its name, one for each material.

    Parameters
    ----------
    glow : gives the material of a part that is a lamp
    """
    by_material: dict[int, tuple[Material, list[Shape]]] = {}
    for part in thing.parts:
        material = glow(part) if part.lamp else part.material
        by_material.setdefault(id(material), (material, []))[1].append(part.shape)
    meshes = []
    for material, shapes in by_material.values():
        shape = joined(shapes)
        meshes.append(Mesh(shape.vertices, shape.faces, material, thing.name, shape.normals))
    return meshes
