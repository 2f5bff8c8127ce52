"""Shapes, as vertices, faces and smooth normals: boxes, surfaces of revolution, rectangles.

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
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


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
    """Return several shapes merged into one."""
    starts = np.cumsum([0] + [len(shape.vertices) for shape in shapes[:-1]])
    faces = [shape.faces + start for shape, start in zip(shapes, starts, strict=True)]
    return Shape(
        np.concatenate([shape.vertices for shape in shapes]),
        np.concatenate(faces),
        np.concatenate([shape.normals for shape in shapes]),
        _joined_uv(shapes),
    )


def _joined_uv(shapes: Sequence[Shape]) -> Floats | None:
    """Return the texture coordinates of shapes one after another; None unless all have them."""
    found = [shape.uv for shape in shapes if shape.uv is not None]
    return np.concatenate(found) if len(found) == len(shapes) else None


def smooth_normals(vertices: Floats, faces: Indices) -> Floats:
    """Return vertex normals weighted by the faces' areas, (V, 3)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    corners = faces.ravel()
    total = [np.bincount(corners, np.repeat(across[:, i], 3), len(vertices)) for i in range(3)]
    return normalised(np.stack(total, axis=1))


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


def without_degenerate(vertices: Floats, faces: Indices) -> Indices:
    """Return the faces without those that have two coincident corners."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    flat = (a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1)
    return faces[~flat]


def parallelogram(corner: Vector, along: Vector, upward: Vector) -> Shape:
    """Return a parallelogram from a corner and two edges; its front is along × upward."""
    a, u, v = (np.array(vector, np.float64) for vector in (corner, along, upward))
    normal = normalised(np.cross(u, v))
    vertices = np.stack([a, a + u, a + u + v, a + v])
    return Shape(vertices, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(normal, (4, 1)))


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
    """Interpolate points by a Catmull–Rom spline (1974), parametrised by chord length.

    Parameters
    ----------
    points : (P, D)
    steps : samples along the curve, the first and the last point among them

    Returns
    -------
    (steps, D) float64
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
    for profile in (
        np.maximum(np.asarray(points, np.float64), (0.0, -np.inf)) for points in curves
    ):
        tangent = np.gradient(profile, axis=0)
        outward = normalised(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1))
        poles = profile[:, 0] == 0.0
        outward[poles] = np.stack([0.0 * outward[poles, 0], np.sign(outward[poles, 1])], axis=1)
        vertices, normals = (
            (pair[:, 0, None, None] * around + pair[:, 1, None, None] * np.array([0.0, 1.0, 0.0]))
            for pair in (profile, outward)
        )
        vertices, normals = vertices.reshape(-1, 3), normals.reshape(-1, 3)
        faces = lattice(len(profile), segments, wrap_columns=True)
        parts.append(Shape(vertices, without_degenerate(vertices, faces), normals))
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
    """Return a torus that lies flat.

    Parameters
    ----------
    radius, thickness : radii of the centre line and of the cross-section, metres
    """
    section = arc((radius, thickness), thickness, -90.0, 270.0, 9 + 2 * (segments // 6))
    section[-1] = section[0]
    return lathe(section, segments=segments)


def box_mapped(shape: Shape) -> Shape:
    """Return a shape with texture coordinates by the coordinate plane that each face is nearest to.

    The first coordinate runs along the longer side of the shape, as the grain of wood does.
    Vertices between faces of different planes are doubled. Shapes in different places and sizes
    show different parts of a texture.
    """
    corners = shape.vertices[shape.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    plane = np.abs(normals).argmax(axis=1)
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
