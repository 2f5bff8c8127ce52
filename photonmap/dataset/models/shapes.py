"""Shapes, as vertices, faces and smooth normals: boxes, surfaces of revolution, tubes, lumps.

All are in metres with y up, and rest on y = 0 around the y axis unless stated. Closed ones are
wound outwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.scene.parameters import Vector

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Random = np.random.Generator

SEGMENTS = 64
"""Segments around the axis of surfaces of revolution, unless stated."""
_BASE = 0.07  # fraction of a lump's height that is flattened into its base


@dataclass(frozen=True, eq=False)
class Shape:
    """A triangulated surface.

    Parameters
    ----------
    vertices : (V, 3) float64, metres
    faces : (F, 3) int64, counter-clockwise seen from outside
    normals : (V, 3) float64, of length 1
    uv : (V, 2) float64 texture coordinates, metres on the surface; None without a texture
    """

    vertices: Floats
    faces: Indices
    normals: Floats
    uv: Floats | None = None

    @classmethod
    def smooth(cls, vertices: Floats, faces: Indices) -> Shape:
        """Return a shape with normals weighted by the areas of faces."""
        weights = np.repeat(area_vectors(vertices, faces), 3, axis=0)
        total = [np.bincount(faces.ravel(), each, len(vertices)) for each in weights.T]
        return cls(vertices, faces, normalised(np.stack(total, axis=1)))

    def moved(self, offset: ArrayLike) -> Shape:
        """Return the shape moved by (x, y, z)."""
        offset = np.asarray(offset, np.float64)
        moved = Shape(self.vertices + offset, self.faces, self.normals, self.uv)
        if "bounds" in vars(self):  # exact, as rounding keeps the order of numbers
            vars(moved)["bounds"] = self.bounds + offset
        return moved

    def turned(self, degrees: float, axis: int = 1) -> Shape:
        """Return the shape rotated about a coordinate axis by the right-hand rule.

        Multiples of 90 degrees are exact.
        """
        matrix = rotation(degrees, axis)
        return Shape(self.vertices @ matrix.T, self.faces, self.normals @ matrix.T, self.uv)

    def scaled(self, factors: ArrayLike) -> Shape:
        """Return the shape scaled along x, y and z by positive factors."""
        factors = np.broadcast_to(np.asarray(factors, np.float64), 3)
        normals = normalised(self.normals / factors)
        return Shape(self.vertices * factors, self.faces, normals, self.uv)

    def resting(self) -> Shape:
        """Return the shape with its lowest vertex at y = 0."""
        return self.moved((0.0, -self.vertices[:, 1].min(), 0.0))

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates, (2, 3)."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def area(self) -> float:
        """Area of all faces, m²."""
        return float(0.5 * np.linalg.norm(area_vectors(self.vertices, self.faces), axis=1).sum())


def area_vectors(vertices: Floats, faces: Indices) -> Floats:
    """Return the normals of faces, (F, 3), as long as twice their areas."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def rotation(degrees: float, axis: int) -> Floats:
    """Return the (3, 3) rotation about a coordinate axis; exact for multiples of 90 degrees."""
    quarters = degrees / 90.0
    if quarters == round(quarters):
        cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    else:
        cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = cosine
    matrix[first, second], matrix[second, first] = -sine, sine
    return matrix


def normalised(vectors: Floats) -> Floats:
    """Scale rows to length 1; rows of zeros stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


def joined(shapes: Sequence[Shape]) -> Shape:
    """Return several shapes merged into one; with texture coordinates if all have them."""
    starts = np.cumsum([0] + [len(shape.vertices) for shape in shapes[:-1]])
    uv = [shape.uv for shape in shapes if shape.uv is not None]
    return Shape(
        np.concatenate([shape.vertices for shape in shapes]),
        np.concatenate([shape.faces + n for shape, n in zip(shapes, starts, strict=True)]),
        np.concatenate([shape.normals for shape in shapes]),
        np.concatenate(uv) if len(uv) == len(shapes) else None,
    )


@cache
def lattice(
    rows: int, columns: int, wrap_rows: bool = False, wrap_columns: bool = False
) -> Indices:
    """Return the triangles of a grid of vertices, row by row, (F, 3).

    They are counter-clockwise where columns lead to the right and rows upwards.
    """
    row, column = np.meshgrid(
        np.arange(rows - (not wrap_rows)), np.arange(columns - (not wrap_columns)), indexing="ij"
    )
    up, right = (row + 1) % rows, (column + 1) % columns
    a, b = row * columns + column, row * columns + right
    c, d = up * columns + right, up * columns + column
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def grid(
    points: Floats,
    normals: Floats | None = None,
    wrap_rows: bool = False,
    wrap_columns: bool = False,
) -> Shape:
    """Return the surface over a grid of points, (rows, columns, 3), without collapsed triangles.

    Parameters
    ----------
    points : columns lead to the right and rows upwards, seen from outside
    normals : as the points; None for smooth ones
    wrap_rows, wrap_columns : join the last row or column to the first
    """
    vertices = points.reshape(-1, 3)
    faces = lattice(*points.shape[:2], wrap_rows, wrap_columns)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    faces = faces[~((a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1))]
    if normals is None:
        return Shape.smooth(vertices, faces)
    return Shape(vertices, faces, normals.reshape(-1, 3))


def parallelogram(corner: Vector, along: Vector, upward: Vector) -> Shape:
    """Return a parallelogram from a corner and two edges; its front is along × upward."""
    a, u, v = (np.array(vector, np.float64) for vector in (corner, along, upward))
    normal = normalised(np.cross(u, v))
    vertices = np.stack([a, a + u, a + u + v, a + v])
    return Shape(vertices, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(normal, (4, 1)))


def upright(x: float, y: float, width: float, height: float) -> Shape:
    """Return a rectangle from a corner (x, y) at z = 0, facing +z."""
    return parallelogram((x, y, 0.0), (width, 0.0, 0.0), (0.0, height, 0.0))


def level(x: float, z: float, width: float, depth: float) -> Shape:
    """Return a rectangle at y = 0, facing up, from its corner at the least x and greatest z."""
    return parallelogram((x, 0.0, z), (width, 0.0, 0.0), (0.0, 0.0, -depth))


def box(
    width: float, height: float, depth: float, rounding: float = 0.004, steps: int = 2
) -> Shape:
    """Return a box with rounded edges.

    Parameters
    ----------
    width, height, depth : along x, y and z, metres
    rounding : radius of the edges, metres; limited to half the shortest side
    steps : subdivisions across half a rounded edge
    """
    half = 0.5 * np.array([width, height, depth])
    radius = min(rounding, 0.999 * float(half.min()))
    corners, faces, normals = _box_template(steps)
    vertices = corners * (half - radius) + radius * normals
    vertices[:, 1] += half[1]
    return Shape(vertices, faces, normals)


@cache
def _box_template(steps: int) -> tuple[Floats, Indices, Floats]:
    """Return for each vertex the signs of its corner; the faces; and the normals."""
    line = np.tan(np.linspace(0.0, np.pi / 4, steps + 1))
    line[-1] = 1.0
    line, sign = np.append(-line[::-1], line), np.repeat((-1.0, 1.0), steps + 1)
    sides = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for front in (1.0, -1.0):
            corners, offsets = np.empty((2, len(line) ** 2, 3))
            for array, values in ((corners, sign), (offsets, line)):
                v, u = np.meshgrid(values, values * front, indexing="ij")
                array[:, axis], array[:, first], array[:, second] = front, u.flat, v.flat
            sides.append(Shape(corners, lattice(len(line), len(line)), normalised(offsets)))
    box = joined(sides)
    return box.vertices, box.faces, box.normals


def smooth_curve(points: ArrayLike, steps: int = 48) -> Floats:
    """Interpolate points, (P, D), by a Catmull–Rom spline (1974), parametrised by chord length.

    Returns
    -------
    (steps, D) float64, the first and the last point among them
    """
    knots = np.asarray(points, np.float64)
    length = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(length)])
    slope = np.gradient(knots, at, axis=0, edge_order=1)
    where = np.linspace(0.0, at[-1], steps)
    left = np.clip(np.searchsorted(at, where, "right") - 1, 0, len(knots) - 2)
    width = length[left][:, None]
    t = (where - at[left])[:, None] / width
    rise = knots[left + 1] - knots[left]
    bend = width * (slope[left] * (1.0 - t) - slope[left + 1] * t) - rise * (1.0 - 2.0 * t)
    result = knots[left] + t * rise + t * (1.0 - t) * bend
    result[0], result[-1] = knots[0], knots[-1]
    return result


def lathe(*curves: ArrayLike, segments: int = SEGMENTS) -> Shape:
    """Return the surface of revolution of curves about y; there is a hard edge where two meet.

    Parameters
    ----------
    curves : (P, 2) radius and height, metres, with the outside on their right: from the foot
        outwards, up, and back to the axis. Each begins where the one before ends
    segments : number of segments around the axis
    """
    angle = 2.0 * np.pi * np.arange(segments) / segments
    around = np.stack([np.cos(angle), np.zeros(segments), -np.sin(angle)], axis=1)
    parts = []
    for points in curves:
        profile = np.maximum(np.asarray(points, np.float64), (0.0, -np.inf))
        tangent = np.gradient(profile, axis=0)
        outward = normalised(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1))
        poles = profile[:, 0] == 0.0
        outward[poles] = np.stack([0.0 * outward[poles, 0], np.sign(outward[poles, 1])], axis=1)
        vertices, normals = (
            pair[:, 0, None, None] * around + pair[:, 1, None, None] * np.array([0.0, 1.0, 0.0])
            for pair in (profile, outward)
        )
        parts.append(grid(vertices, normals, wrap_columns=True))
    return joined(parts)


def arc(
    center: tuple[float, float], radius: float, begin: float, end: float, steps: int = 12
) -> Floats:
    """Return points of a circular arc between two angles, degrees, as (steps, 2)."""
    angle = np.radians(np.linspace(begin, end, steps))
    return np.array(center) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def cylinder(
    radius: float, height: float, rounding: float = 0.003, segments: int = SEGMENTS
) -> Shape:
    """Return a cylinder with rounded edges."""
    return cone(radius, radius, height, rounding, segments)


def cone(
    bottom: float, top: float, height: float, rounding: float = 0.003, segments: int = SEGMENTS
) -> Shape:
    """Return a truncated cone of given bottom and top radius, with rounded edges."""
    r = min(rounding, 0.4 * bottom, 0.4 * top, 0.4 * height)
    lean = math.degrees(math.atan2(bottom - top, height))
    low = arc((bottom - r, r), r, -90.0, lean, 5)
    high = arc((top - r, height - r), r, lean, 90.0, 5)
    foot, cap = [(0.0, 0.0), (bottom - r, 0.0)], [high[-1], (0.0, height)]
    return lathe(foot, low, [low[-1], high[0]], high, cap, segments=segments)


def torus(radius: float, thickness: float, segments: int = SEGMENTS) -> Shape:
    """Return a torus that lies flat, by the radii of its centre line and of its cross-section."""
    section = arc((radius, thickness), thickness, -90.0, 270.0, 9 + 2 * (segments // 6))
    section[-1] = section[0]
    return lathe(section, segments=segments)


class Noise:
    """A smooth random field: a sum of plane waves of random directions.

    Its mean is 0 and its variance about 1; each octave is half as strong as the one before.

    The frequency of the first octave is in cycles a unit of length; each further one has twice the
    frequency. All have the same number of waves.
    """

    def __init__(self, rng: Random, frequency: float, octaves: int = 3, waves: int = 12) -> None:
        scales = np.repeat(2.0 ** np.arange(octaves), waves)
        directions = normalised(rng.normal(size=(len(scales), 3)))
        self._waves = 2.0 * np.pi * frequency * scales[:, None] * directions
        self._phases = rng.uniform(0.0, 2.0 * np.pi, len(scales))
        amplitudes = 1.0 / scales
        self._amplitudes = amplitudes * np.sqrt(2.0 / (amplitudes**2).sum())

    def __call__(self, points: Floats) -> Floats:
        """Return the field at points (V, 3) as (V,)."""
        return np.sin(points @ self._waves.T + self._phases) @ self._amplitudes


@cache
def _icosphere(subdivisions: int) -> tuple[Floats, Indices]:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=subdivisions)
    return np.array(ball.vertices), np.array(ball.faces, np.int64)


def sphere(radius: float, subdivisions: int = 4) -> Shape:
    """Return a ball that rests on y = 0."""
    vertices, faces = _icosphere(subdivisions)
    return Shape(radius * vertices, faces, vertices).resting()


def lump(rng: Random, radius: float, roughness: float = 0.12, frequency: float = 0.45) -> Shape:
    """Return a ball displaced by smooth noise, on a flat base.

    The standard deviation of the displacement is in radii, the lowest frequency in cycles a radius.
    """
    vertices, faces = _icosphere(5)
    field = np.clip(Noise(rng, frequency)(vertices), -2.5, 2.5)
    moved = radius * vertices * (1.0 + roughness * field[:, None])
    low, high = moved[:, 1].min(), moved[:, 1].max()
    moved[:, 1] = np.maximum(moved[:, 1], low + _BASE * (high - low))
    return Shape.smooth(moved, faces).resting()


def superquadric(
    size: ArrayLike, north: float, east: float, rows: int = 96, columns: int = 128
) -> Shape:
    """Return a superquadric (Barr 1981).

    Parameters
    ----------
    size : extents along x, y and z, metres
    north, east : exponents: 1 is an ellipsoid, towards 0 a box, 2 an octahedron
    """
    latitude = _eased(np.linspace(-np.pi / 2, np.pi / 2, rows))
    longitude = _eased(np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False))
    ring, rise = _power(np.cos(latitude), north), _power(np.sin(latitude), north)
    ring[[0, -1]] = 0.0
    x = np.outer(ring, _power(np.cos(longitude), east))
    z = -np.outer(ring, _power(np.sin(longitude), east))
    points = np.stack([x, np.broadcast_to(rise[:, None], x.shape), z], axis=-1)
    shape = grid(0.5 * np.asarray(size, np.float64) * points, wrap_columns=True)
    shape.normals[:columns], shape.normals[-columns:] = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)
    return shape.resting()


def _power(values: Floats, exponent: float) -> Floats:
    """Raise magnitudes to a power and keep signs; values within rounding of 0 become 0."""
    values = np.where(np.abs(values) < 1e-12, 0.0, values)
    return np.sign(values) * np.abs(values) ** exponent


def _eased(angles: Floats) -> Floats:
    """Concentrate angles where superquadrics bend most, halfway between the axes."""
    return angles - 0.2 * np.sin(4.0 * angles)


def tube(path: ArrayLike, radius: float, sides: int = 32, closed: bool = False) -> Shape:
    """Sweep a circle along a path; an open path gets hemispherical caps.

    The path is (P, 3), metres; the first point of a closed one is not repeated at its end. The
    circle has so many sides.
    """
    line = np.asarray(path, np.float64)
    before, after = np.roll(line, 1, axis=0), np.roll(line, -1, axis=0)
    tangent = normalised(after - before if closed else np.gradient(line, axis=0))
    radii = np.full(len(line), radius)
    if not closed:
        line, tangent, radii = _capped(line, tangent, radius)
    right, up = _frames(tangent, closed)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    outward = np.cos(angle)[:, None] * right[:, None] + np.sin(angle)[:, None] * up[:, None]
    return grid(line[:, None] + radii[:, None, None] * outward, None, closed, wrap_columns=True)


def _capped(line: Floats, tangent: Floats, radius: float) -> tuple[Floats, Floats, Floats]:
    """Add a hemisphere of rings to either end."""
    angle = np.linspace(0.0, np.pi / 2, 7)[1:]
    out, radii = radius * np.sin(angle)[:, None], radius * np.cos(angle)
    radii[-1] = 0.0
    first = (line[0] - out * tangent[0])[::-1]
    last = line[-1] + out * tangent[-1]
    directions = [np.tile(tangent[0], (6, 1)), tangent, np.tile(tangent[-1], (6, 1))]
    return (
        np.concatenate([first, line, last]),
        np.concatenate(directions),
        np.concatenate([radii[::-1], np.full(len(line), radius), radii]),
    )


def _frames(tangent: Floats, closed: bool) -> tuple[Floats, Floats]:
    """Return a rotation-minimising frame along a path; on a closed one its twist is spread out."""
    start = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    right = [normalised(start - tangent[0] * (start @ tangent[0]))]
    for direction in tangent[1:]:
        right.append(normalised(right[-1] - direction * (right[-1] @ direction)))
    rights = np.stack(right)
    ups = np.cross(tangent, rights)
    if closed:
        back = normalised(rights[-1] - tangent[0] * (rights[-1] @ tangent[0]))
        twist = np.arctan2(back @ ups[0], back @ rights[0])
        turn = -twist * np.arange(len(rights)) / len(rights)
        cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
        rights, ups = cosine * rights + sine * ups, cosine * ups - sine * rights
    return rights, ups


def knot(radius: float, thickness: float, p: int = 2, q: int = 3, steps: int = 320) -> Shape:
    """Return an upright torus knot: p times around the axis, q times around the ring."""
    t = 2.0 * np.pi * np.arange(steps) / steps
    ring = 1.0 + 0.42 * np.cos(q * t)
    path = [ring * np.cos(p * t), ring * np.sin(p * t), 0.42 * np.sin(q * t)]
    return tube(radius * np.stack(path, axis=1), thickness, closed=True).resting()


def box_mapped(shape: Shape) -> Shape:
    """Return a shape with texture coordinates by the coordinate plane that each face is nearest to.

    The first coordinate runs along the longer side of the shape, as the grain of wood does.
    Vertices between faces of different planes are doubled. Shapes in different places and sizes
    show different parts of a texture.
    """
    plane = np.abs(area_vectors(shape.vertices, shape.faces)).argmax(axis=1)
    used, faces = np.unique(shape.faces + len(shape.vertices) * plane[:, None], return_inverse=True)
    planes, rows = np.divmod(used, len(shape.vertices))
    vertices, extent = shape.vertices[rows], np.ptp(shape.bounds, axis=0)
    uv = np.empty((len(rows), 2))
    for axis in range(3):
        along, across = sorted(({0, 1, 2} - {axis}), key=lambda side: -extent[side])
        uv[planes == axis] = vertices[planes == axis][:, (along, across)]
    # Any number that differs between shapes, but not between runs.
    shift = np.modf(
        shape.bounds.sum(axis=0) @ np.array([[7.31, 3.77], [5.13, 9.91], [2.37, 6.53]])
    )[0]
    return Shape(vertices, faces.reshape(-1, 3), shape.normals[rows], uv + shift)
