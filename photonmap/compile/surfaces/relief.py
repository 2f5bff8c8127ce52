"""Relief as kernels take it: images of directions or slopes, and the tangents of vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.tangents import vertex_tangents
from photonmap.compile.textures import TextureTable
from photonmap.kernels.core import records
from photonmap.scene.material import Material


def compile_relief(
    geometry: records.Geometry,
    materials: list[Material],
    table: TextureTable,
    size: float,
    given: NDArray[np.float64],
) -> records.Relief | None:
    """Return what turns shading normals; None where nothing does.

    Parameters
    ----------
    geometry : with materials and texture coordinates
    materials : (M,)
    table : of their textures
    size : scene units in a unit of the kernels' length
    given : tangents of vertices, see `given_tangents`
    """
    if (table.relief < 0).all():
        return None
    reliefs = [material.relief for material in materials]
    is_height = np.array([relief is not None and relief.is_height for relief in reliefs])
    factor = np.array([0.0 if relief is None else relief.factor for relief in reliefs])
    by_directions = (table.relief >= 0) & ~is_height
    return records.Relief(
        table.maps,
        table.relief,
        is_height.astype(np.uint8),
        np.where(is_height, factor / size, factor),
        vertex_tangents(geometry, by_directions[geometry.material], given),
    )
