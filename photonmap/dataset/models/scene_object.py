"""Scene objects: parts of one material each, and the surfaces that other objects may rest on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from typing import ParamSpec

import numpy as np
from numpy.typing import ArrayLike

from photonmap.dataset.models.materials import Draw, reflectance_of, surface_of
from photonmap.dataset.models.shapes import Floats, Shape, box_mapped, joined
from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh

_MOST_STEPS, _HALVINGS = 7.0, 14
"""The most steps of Munsell value by which all chips become lighter or darker, and halvings of the
interval in which the step is searched."""
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

    def mapped(self, change: Callable[[Part], Part]) -> SceneObject:
        """Return the object with every part changed."""
        return replace(self, parts=[change(part) for part in self.parts])

    def transformed(self, transform: Callable[[Shape], Shape]) -> SceneObject:
        """Return the object with every shape transformed, and without supports."""
        made = self.mapped(lambda p: Part(transform(p.shape), p.material, p.light_group))
        return replace(made, supports=())

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
        return hull(self.boxes)


Place = tuple[float, float, float]
Where = float | Place | list[Place]
"""A height above the origin, (x, y, z), or several of these, metres."""
Row = (
    Part
    | tuple[Shape, Where, Material]
    | tuple[Shape, Where, Material, str]
    | tuple[Iterable["Row"], Place]
)
"""A part; a shape, where it is, its material, and its light group if it emits; or a table within
another, and where it is."""
Table = Iterator[Row | Support]
"""What an object consists of."""
P = ParamSpec("P")


def model(name: str) -> Callable[[Callable[P, Table]], Callable[P, SceneObject]]:
    """Make a function that yields the parts and supports of an object return the object."""

    def decorate(table: Callable[P, Table]) -> Callable[P, SceneObject]:
        @wraps(table)
        def make(*args: P.args, **kwargs: P.kwargs) -> SceneObject:
            parts, supports = list[Part](), list[Support]()
            for row in table(*args, **kwargs):
                if isinstance(row, Support):
                    supports.append(row)
                else:
                    parts += placed([row])
            return SceneObject(name, parts, supports)

        return make

    return decorate


def placed(table: Iterable[Row]) -> list[Part]:
    """Return the parts of a table."""
    parts = list[Part]()
    for row in table:
        if isinstance(row, Part):
            parts.append(row)
        elif len(row) == 2:
            parts += [replace(part, shape=part.shape.moved(row[1])) for part in placed(row[0])]
        elif isinstance(row[1], float):
            shape = row[0].moved((0.0, row[1], 0.0)) if row[1] else row[0]
            parts.append(Part(shape, *row[2:]))
        else:
            places = row[1] if isinstance(row[1], list) else [row[1]]
            parts += [Part(row[0].moved(at), *row[2:]) for at in places]
    return parts


def mirrored(axes: str, x: float, y: float, z: float) -> list[Place]:
    """Return a place and its images on the other side along "x", "z" or "xz", as legs have."""
    return [
        (at_x, y, at_z)
        for at_x in ((-x, x) if "x" in axes else (x,))
        for at_z in ((-z, z) if "z" in axes else (z,))
    ]


def hull(boxes: Floats) -> Floats:
    """Return the box around boxes, (n, 2, 3), as (2, 3)."""
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def bounds_of(objects: Iterable[SceneObject]) -> Floats:
    """Return the lowest and highest coordinates of several objects, (2, 3), metres."""
    return hull(np.stack([obj.bounds for obj in objects]))


def overlap(first: Floats, second: Floats) -> bool:
    """Return whether any box of one set, (n, 2, 3), intersects any of another, (m, 2, 3)."""
    low = np.maximum(first[:, None, 0], second[None, :, 0])
    high = np.minimum(first[:, None, 1], second[None, :, 1])
    return bool((high - low > CONTACT_TOLERANCE).all(axis=2).any())


Maker = Callable[[Draw], SceneObject]
"""Makes an object at the origin."""


def sized(make: Callable[[Draw, float], SceneObject], size: float) -> Maker:
    """Return a maker of objects of one size, metres."""
    return lambda draw: make(draw, size)


def solid(name: str, make: Callable[[Draw], tuple[Shape, Material]]) -> Maker:
    """Return a maker of an object of one part."""
    return lambda draw: SceneObject(name, [Part(*make(draw))])


def dealt(shapes: Iterable[Shape], materials: Sequence[Material]) -> list[Part]:
    """Return the shapes that have faces as parts, with the materials dealt in rotation."""
    return [
        Part(shape, materials[index % len(materials)])
        for index, shape in enumerate(shapes)
        if len(shape.faces)
    ]


def multi_part(name: str, shapes: Iterable[Shape], materials: Sequence[Material]) -> SceneObject:
    """Return an object of one part per shape, with the materials dealt in rotation."""
    return SceneObject(name, dealt(shapes, materials))


def with_unique_names(objects: Iterable[SceneObject]) -> list[SceneObject]:
    """Give each object a unique name: the second vase becomes "vase 2"."""
    seen: dict[str, int] = {}
    named = []
    for obj in objects:
        seen[obj.name] = count = seen.get(obj.name, 0) + 1
        named.append(replace(obj, name=obj.name if count == 1 else f"{obj.name} {count}"))
    return named


def to_meshes(obj: SceneObject, emitter_material: Callable[[Part], Material]) -> list[Mesh]:
    """Return an object as meshes that bear its name, one per material and light group."""
    by_material: dict[tuple[int, str], tuple[Material, list[Shape]]] = {}
    for part in obj.parts:
        material = emitter_material(part) if part.light_group else part.material
        key = id(material), part.light_group
        by_material.setdefault(key, (material, []))[1].append(part.shape)
    merged = ((material, joined(shapes)) for material, shapes in by_material.values())
    return [Mesh(s.vertices, s.faces, m, obj.name, s.normals, s.uv) for m, s in merged]


def with_lightness(objects: Sequence[SceneObject], mean: float | None) -> Sequence[SceneObject]:
    """Return objects whose chips are so much lighter or darker that they reflect a mean.

    It is met as nearly as whole chips allow: closely in rooms, less so where one chip covers most
    of a scene. Chips keep their hue, and their chroma as nearly as there are chips. What is not a
    chip, such as metal, stays as it is, and so do emitters.

    The mean is over all wavelengths and the area of all surfaces; None changes nothing.

    Raises
    ------
    InputError : no chips reflect so much, or so little
    """
    if mean is None:
        return objects
    areas = dict[str, float]()
    known = dict[str, Material]()
    for part in (part for obj in objects for part in obj.parts if not part.light_group):
        known[name := part.material.name] = part.material
        areas[name] = areas.get(name, 0.0) + part.shape.area
    weights = np.array(list(areas.values())) / sum(areas.values())

    def mean_at(step: float) -> float:
        return float(weights @ [reflectance_of(_lighter(m, step)) for m in known.values()])

    low, high = -_MOST_STEPS, _MOST_STEPS
    least, most = mean_at(low), mean_at(high)
    if not least <= mean <= most:
        raise InputError(
            f"lightness {mean:g} is out of reach: with Munsell chips the scene reflects "
            f"{least:.2f} to {most:.2f}"
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if mean_at(middle) < mean else (low, middle)
    step = min((low, high), key=lambda each: abs(mean_at(each) - mean))
    changed = {name: _lighter(m, step) for name, m in known.items()}
    return [
        obj.mapped(lambda p: p if p.light_group else replace(p, material=changed[p.material.name]))
        for obj in objects
    ]


def _lighter(material: Material, step: float) -> Material:
    lighter = surface_of(material.name).lighter(step)
    return material if lighter is None else lighter.material()
