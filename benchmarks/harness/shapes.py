"""Meshes with any number of triangles, and a lit room around them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import photonmap as pm


def bumpy_sphere(triangles: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices and faces of a bumpy sphere of radius about 1, wound outwards.

    It is an inflated cube with n² squares of two triangles on each side, which gives the number of
    `triangles` to within about 12 n.
    """
    n = max(round((triangles / 12.0) ** 0.5), 1)
    s, t = np.meshgrid(*[np.linspace(-1.0, 1.0, n + 1)] * 2, indexing="ij")
    s, t = np.tan(s.ravel() * np.pi / 4.0), np.tan(t.ravel() * np.pi / 4.0)
    one = np.ones_like(s)
    sides = [
        np.roll(np.stack([sign * s, t, sign * one], axis=1), axis, axis=1)
        for axis in range(3)
        for sign in (1.0, -1.0)
    ]
    vertices = np.concatenate(sides)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    x, y, z = 9.0 * vertices.T
    vertices *= (1.0 + 0.04 * np.sin(x) * np.sin(y + 1.0) * np.sin(z + 2.0))[:, None]

    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = corner, corner + n + 1, corner + n + 2, corner + 1
    square = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    starts = np.arange(6)[:, None, None] * (n + 1) ** 2
    return vertices, (square[None] + starts).reshape(-1, 3)


def room_with_sphere(triangles: int) -> pm.Scene:
    """Return the Cornell box with a bumpy sphere of `triangles` triangles instead of its boxes."""
    room = pm.scenes.cornell_box()
    walls = [mesh for mesh in room.meshes if not mesh.name.endswith("_box")]
    vertices, faces = bumpy_sphere(triangles)
    white = pm.Material("grey", (0.6, 0.6, 0.6))
    sphere = pm.Mesh(0.6 * vertices + (0.0, -0.35, 0.0), faces, white, "sphere")
    return pm.Scene([*walls, sphere], camera=room.camera, name=f"{len(faces)} triangles")
