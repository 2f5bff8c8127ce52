"""Rays among triangles, before there is a scene to render."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.kernels.geometry.embree import EmbreeScene
from photonmap.kernels.geometry.ray import find_clear, first_hits

Floats = NDArray[np.float64]


class RayCaster:
    """Casts rays among triangles.

    Parameters
    ----------
    vertices : (V, 3), metres
    triangles : (T, 3) rows of vertices
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self._scene = EmbreeScene(
            np.asarray(vertices, np.float32), np.asarray(triangles, np.uint32)
        )

    def first_hits(self, origins: Floats, directions: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Return the triangle that each ray hits first, and the distance to it.

        Parameters
        ----------
        origins, directions : (P, 3)

        Returns
        -------
        (P,) rows of triangles, -1 where there is none; (P,) distances, in lengths of the directions
        """
        triangles, distances = np.empty(len(origins), np.int64), np.empty(len(origins))
        first_hits(self._scene.address, origins, directions, triangles, distances)
        return triangles, distances

    def is_clear(self, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
        """Return whether nothing lies between points, (P, M), except close to the ends.

        Parameters
        ----------
        starts : (P, 3), off any surface
        ends : (M, 3), perhaps on a surface: the last thousandth of the way does not count
        """
        clear = np.empty((len(starts), len(ends)), np.bool_)
        find_clear(self._scene.address, starts, ends, clear)
        return clear
