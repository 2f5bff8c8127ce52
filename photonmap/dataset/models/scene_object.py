"""Scene objects: parts of one material each, and the surfaces that other objects may rest on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from photonmap.dataset.models.shapes import Floats, Shape, box_mapped, joined
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh

CONTACT_TOLERANCE = 1e-6
"""Overlap of bounding boxes, metres, up to which objects count as touching."""


@dataclass(frozen=True, eq=False)
class Part:
    """A surface of one material.

    Parameters
    ----------
    shape : in metres
    material : of the whole part; of an emitter, while it is off
    light_group : name of the light group that the part belongs to; "" if it does not emit
    """

    shape: Shape
    material: Material
    light_group: str = ""

    def __post_init__(self) -> None:
        """Lay a texture onto the shape, as it stands before the object is placed."""
        if self.material.uses_uv and self.shape.uv is None:
            object.__setattr__(self, "shape", box_mapped(self.shape))


@dataclass(frozen=True)
class Support:
    """A horizontal rectangle that objects may rest on.

    Parameters
    ----------
    x, z : lowest and highest coordinate, metres
    y : height of the rectangle, metres
    room : free height above it, metres
    """

    x: tuple[float, float]
    z: tuple[float, float]
    y: float
    room: float = 10.0


@dataclass(frozen=True, eq=False)
class SceneObject:
    """An object: parts around the y axis that rest on y = 0 until the object is placed.

    Parameters
    ----------
    name : what kind of object it is
    parts : its surfaces
    supports : where other objects may rest; lost when the object is moved or turned
    """

    name: str
    parts: Sequence[Part]
    supports: Sequence[Support] = field(default_factory=tuple)

    def transformed(self, transform: Callable[[Shape], Shape]) -> SceneObject:
        """Return the object with every shape transformed, and without supports."""
        parts = [Part(transform(p.shape), p.material, p.light_group) for p in self.parts]
        return SceneObject(self.name, parts)

    def moved(self, offset: ArrayLike) -> SceneObject:
        """Return the object moved by (x, y, z), metres."""
        return self.transformed(lambda shape: shape.moved(offset))

    def turned(self, degrees: float) -> SceneObject:
        """Return the object rotated about the y axis."""
        return self.transformed(lambda shape: shape.turned(degrees))

    @cached_property
    def boxes(self) -> Floats:
        """Bounding boxes of its parts, (P, 2, 3), metres."""
        return np.stack([part.shape.bounds for part in self.parts])

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates, (2, 3), metres."""
        boxes = self.boxes
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def part_at(shape: Shape, x: float, y: float, z: float, material: Material) -> Part:
    """Return a part that is moved to (x, y, z), metres."""
    return Part(shape.moved((x, y, z)), material)


Place = tuple[float, float, float]
Row = tuple[Shape, Place, Material] | tuple[Shape, Place, Material, str]
"""A shape, its place, its material, and perhaps along which axes it is repeated on both sides."""


def assembled(
    name: str, rows: Iterable[Part | Row], supports: Sequence[Support] = ()
) -> SceneObject:
    """Return an object from a table of its parts.

    Parameters
    ----------
    rows : parts that are in place, or shapes with their place (x, y, z), metres, and material; with
        "x", "z" or "xz" a shape is repeated at the opposite place along these axes, as legs are
    """
    parts = list[Part]()
    for row in rows:
        if isinstance(row, Part):
            parts.append(row)
            continue
        shape, (x, y, z), material = row[:3]
        axes = row[3] if len(row) == 4 else ""
        parts += [
            part_at(shape, at_x, y, at_z, material)
            for at_x in ((-x, x) if "x" in axes else (x,))
            for at_z in ((-z, z) if "z" in axes else (z,))
        ]
    return SceneObject(name, parts, supports)


def bounds_of(objects: Iterable[SceneObject]) -> Floats:
    """Return the lowest and highest coordinates of several objects, (2, 3), metres."""
    bounds = np.stack([obj.bounds for obj in objects])
    return np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])


def overlap(first: Floats, second: Floats) -> bool:
    """Return whether any box of one set, (n, 2, 3), intersects any of another, (m, 2, 3)."""
    low = np.maximum(first[:, None, 0], second[None, :, 0])
    high = np.minimum(first[:, None, 1], second[None, :, 1])
    return bool((high - low > CONTACT_TOLERANCE).all(axis=2).any())


def single_part(name: str, shape: Shape, material: Material) -> SceneObject:
    """Return an object of one part."""
    return SceneObject(name, [Part(shape, material)])


def multi_part(name: str, shapes: Sequence[Shape], materials: Sequence[Material]) -> SceneObject:
    """Return an object of one part per shape, with the materials assigned in rotation."""
    parts = [
        Part(shape, materials[index % len(materials)])
        for index, shape in enumerate(shapes)
        if len(shape.faces)
    ]
    return SceneObject(name, parts)


def with_unique_names(objects: Iterable[SceneObject]) -> list[SceneObject]:
    """Give each object a unique name: the second vase becomes "vase 2"."""
    seen: dict[str, int] = {}
    named = []
    for obj in objects:
        seen[obj.name] = count = seen.get(obj.name, 0) + 1
        named.append(replace(obj, name=obj.name if count == 1 else f"{obj.name} {count}"))
    return named


def to_meshes(obj: SceneObject, emitter_material: Callable[[Part], Material]) -> list[Mesh]:
    """Return an object as meshes that bear its name, one per material and light group.

    Parameters
    ----------
    emitter_material : returns the material of a part that belongs to a light group
    """
    by_material: dict[tuple[int, str], tuple[Material, list[Shape]]] = {}
    for part in obj.parts:
        material = emitter_material(part) if part.light_group else part.material
        key = id(material), part.light_group
        by_material.setdefault(key, (material, []))[1].append(part.shape)
    meshes = []
    for material, shapes in by_material.values():
        shape = joined(shapes)
        meshes.append(
            Mesh(shape.vertices, shape.faces, material, obj.name, shape.normals, shape.uv)
        )
    return meshes
