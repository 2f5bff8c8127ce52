"""Normals and areas of many triangles."""

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.records import Geometry
from photonmap.runtime.storage import strips


def winding_normals(
    vertices: NDArray[np.float32], triangles: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Return the normals of triangles' windings, (T, 3), as long as twice their areas."""
    normals = np.empty((len(triangles), 3))
    for part in strips(len(triangles)):
        a, b, c = vertices[triangles[part]].astype(np.float64).swapaxes(0, 1)
        normals[part] = np.cross(b - a, c - a)
    return normals


def triangle_areas(
    geometry: Geometry, triangles: NDArray[np.int64] | slice = slice(None)
) -> NDArray[np.float64]:
    """Return the areas of triangles, float64, in the geometry's units."""
    normals = winding_normals(geometry.vertices, geometry.triangles[triangles])
    return 0.5 * np.linalg.norm(normals, axis=1)
