"""Shapes that have a formula, as triangles whose vertices lie on them.

Spheres and cylinders have the normals of the true shape there. The area of a sphere is 0.05% too
small, that of a cylinder or a disk less than 0.003%. Coordinates u and v are those of Mitsuba, but
v counts upwards.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.meshes import Part

Floats = NDArray[np.float64]
SPHERE_EDGES = 128  # Edges of a sphere along its equator; half as many from pole to pole
CIRCLE_EDGES = 512  # Edges of a disk and of a cylinder along a full turn
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_CUBE = (  # for each face its normal, and the axis along which u grows
    ((0, -1, 0), (0, 0, 1)),
    ((0, 1, 0), (-1, 0, 0)),
    ((1, 0, 0), (0, 1, 0)),
    ((0, 0, 1), (0, 1, 0)),
    ((-1, 0, 0), (0, 1, 0)),
    ((0, 0, -1), (0, -1, 0)),
)


def rectangle() -> Part:
    """Return the square from -1 to 1 in x and y, which faces +z."""
    square = _square(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    return replace(square, uv=_CORNERS * [1.0, -1.0] + [0.0, 1.0])


def cube() -> Part:
    """Return the cube from -1 to 1."""
    faces = [
        _square(normal, along, np.cross(normal, along))
        for normal, along in np.array(_CUBE, np.float64)
    ]
    triangles = [face.faces + len(_CORNERS) * index for index, face in enumerate(faces)]
    vertices = np.concatenate([face.vertices for face in faces])
    return Part(vertices, np.concatenate(triangles), None, np.tile(_CORNERS, (len(faces), 1)))


def _square(center: Floats, along: Floats, across: Floats) -> Part:
    """Return a square of side 2 that faces along × across."""
    places = 2.0 * _CORNERS - 1.0
    vertices = center + places[:, :1] * along + places[:, 1:] * across
    return Part(vertices, np.array([[0, 1, 2], [0, 2, 3]]), None, _CORNERS)


def sphere(center: Floats, radius: float) -> Part:
    """Return a sphere; u runs about z, from +x towards +y, and v from +z to -z."""
    around, down, faces = _lattice(SPHERE_EDGES, SPHERE_EDGES // 2)
    azimuth, polar = 2.0 * np.pi * around, np.pi * down
    across = np.sin(polar)
    normals = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)], axis=1)
    uv = np.stack([around, 1.0 - down], axis=1)
    return _solid(Part(center + radius * normals, faces, normals, uv))


def disk() -> Part:
    """Return the disk of radius 1 about z, which faces +z; u is the radius, v runs about z."""
    around, radius, faces = _lattice(CIRCLE_EDGES, 1)
    azimuth = 2.0 * np.pi * around
    x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
    uv = np.stack([radius, 1.0 - around], axis=1)
    return _solid(Part(np.stack([x, y, np.zeros(len(x))], axis=1), faces, None, uv))


def cylinder(start: Floats, end: Floats, radius: float) -> Part:
    """Return a cylinder without caps, which faces outwards; u runs about it, v along it.

    Its ends are two points that differ.
    """
    around, along, faces = _lattice(CIRCLE_EDGES, 1)
    axis = end - start
    x, y = side_axes(axis / np.linalg.norm(axis))
    azimuth = 2.0 * np.pi * around
    normals = np.outer(np.cos(azimuth), x) + np.outer(np.sin(azimuth), y)
    vertices = start + radius * normals + np.outer(along, axis)
    return Part(vertices, faces[:, ::-1], normals, np.stack([around, 1.0 - along], axis=1))


def _lattice(columns: int, rows: int) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return a unit square, cut into triangles: x and y of its vertices, and corners, (F, 3).

    They are counter-clockwise where y counts downwards.
    """
    y, x = np.mgrid[0 : rows + 1, 0 : columns + 1].reshape(2, -1).astype(np.float64)
    cells = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    below = columns + 1
    halves = [[0, below, below + 1], [0, below + 1, 1]]
    faces = np.concatenate([cells + half for half in halves])
    return x / columns, y / rows, faces


def _solid(part: Part) -> Part:
    """Leave out triangles without area: those at poles."""
    a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return replace(part, faces=part.faces[doubled > 1e-9 * doubled.max()])


def side_axes(z: Floats) -> tuple[Floats, Floats]:
    """Return x and y of a right-handed frame about a unit vector z.

    T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
    """
    sign = math.copysign(1.0, z[2])
    a = -1.0 / (sign + z[2])
    b = z[0] * z[1] * a
    x = np.array([1.0 + sign * z[0] ** 2 * a, sign * b, -sign * z[0]])
    return x, np.array([b, sign + z[1] ** 2 * a, -z[1]])
