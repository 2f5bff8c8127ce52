"""Colours of vertices and faces as kernels take them: textures of one tile for each triangle.

A tile has 2 × 2 texels. Between their centres, bilinear interpolation of values that are linear in
the place is linear, so with texels that extrapolate from a triangle's corners, its colour is linear
in barycentrics. The corners lie a quarter of a texel inside, where rounding cannot reach a
neighbouring tile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.images import Image
from photonmap.scene.mesh import Mesh
from photonmap.scene.textures import Texture

_CORNERS = np.array([[0.75, 0.75], [1.25, 0.75], [0.75, 1.25]])
"""Where a triangle's corners lie in its tile, in texels; those of centres are 0.5 and 1.5."""


@dataclass(frozen=True, kw_only=True)
class TriangleColors(Texture):
    """A texture of tiles, whose texels may lie outside the range of the colours that are seen.

    Parameters
    ----------
    colors : (T, 3, 3) float32, the linear RGB of each triangle's corners
    """

    colors: NDArray[np.float32]

    @property
    def values(self) -> NDArray[Any]:
        """The colours of corners, in the place of texels."""
        return self.colors


def paint_meshes(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Turn the colours of meshes into textures; those of one material share one.

    Triangles of coloured meshes have corners of their own in the result.
    """
    result = list(meshes)
    groups: dict[int, list[int]] = {}
    for index, mesh in enumerate(meshes):
        if mesh.colors is not None:
            groups.setdefault(id(mesh.material), []).append(index)
    for members in groups.values():
        split = [meshes[index].split_corners() for index in members]
        colors = [np.asarray(mesh.colors, np.float32) for mesh in split]
        texture, uv = _tile(np.concatenate(colors).reshape(-1, 3, 3))
        material = replace(split[0].material, reflectance=texture)
        parts = np.split(uv.reshape(-1, 2), np.cumsum([len(part) for part in colors[:-1]]))
        for index, mesh, part in zip(members, split, parts, strict=True):
            result[index] = replace(mesh, material=material, uv=part, colors=None)
    return result


def _tile(colors: NDArray[np.float32]) -> tuple[TriangleColors, NDArray[np.float64]]:
    """Return a texture of tiles, and its coordinates at corners, (T, 3, 2), in texels."""
    columns = math.isqrt(len(colors) - 1) + 1
    rows = -(-len(colors) // columns)
    tiles = np.zeros((rows * columns, 2, 2, 3), np.float32)
    a, b, c = colors.swapaxes(0, 1)
    tiles[: len(colors), 0, 0] = 2.0 * a - 0.5 * (b + c)
    tiles[: len(colors), 0, 1] = 1.5 * b - 0.5 * c
    tiles[: len(colors), 1, 0] = 1.5 * c - 0.5 * b
    tiles[: len(colors), 1, 1] = 1.5 * (b + c) - 2.0 * a
    texels = tiles.reshape(rows, columns, 2, 2, 3).swapaxes(1, 2).reshape(2 * rows, 2 * columns, 3)
    row, column = np.divmod(np.arange(len(colors)), columns)
    uv = 2.0 * np.stack([column, row], axis=1)[:, None] + _CORNERS
    scale = (0.5 / columns, -0.5 / rows)
    return TriangleColors(Image(texels, False), scale, (0.0, 1.0), colors=colors), uv
