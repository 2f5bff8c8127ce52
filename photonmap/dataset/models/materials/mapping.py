"""Texture coordinates of shapes, in metres."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.shapes import Shape


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
