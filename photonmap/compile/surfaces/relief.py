"""Relief as kernels take it: images of directions or slopes, and the tangents of vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.tangents import vertex_tangents
from photonmap.compile.textures import TextureTable
from photonmap.kernels.core.image_records import Relief
from photonmap.kernels.core.records import Geometry
from photonmap.scene.material import Material
from photonmap.scene.surfaces.relief import BumpMap, NoRelief, NormalMap


@dataclass
class Reliefs:
    """The relief of a scene's surfaces, and of clear coats over them.

    Parameters
    ----------
    geometry : with materials and texture coordinates
    table : of the textures of materials
    size : scene units in a unit of the kernels' length
    tangents : of vertices, see `given_tangents`
    """

    geometry: Geometry
    table: TextureTable
    size: float
    tangents: NDArray[np.float64]

    def of_surfaces(self, materials: Sequence[Material]) -> Relief | None:
        """Return what turns the shading normals of M materials; None where nothing does."""
        if (self.table.relief < 0).all():
            return None
        return self._compile([material.relief for material in materials], self.table.relief)

    def of_coats(self, materials: Sequence[Material]) -> Relief | None:
        """Return what turns the normals of coats that have their own; None where none has."""
        reliefs = [material.own_coat_relief for material in materials]
        if all(relief is None for relief in reliefs):
            return None
        return self._compile(reliefs, self.table.coat_relief)

    def _compile(
        self, reliefs: Sequence[NormalMap | BumpMap | NoRelief | None], rows: NDArray[np.int32]
    ) -> Relief:
        is_height = np.array([relief is not None and relief.is_height for relief in reliefs])
        factor = np.array([0.0 if relief is None else relief.factor for relief in reliefs])
        by_directions = (rows >= 0) & ~is_height
        return Relief(
            self.table.maps,
            rows,
            is_height.astype(np.uint8),
            np.where(is_height, factor / self.size, factor),
            vertex_tangents(self.geometry, by_directions[self.geometry.material], self.tangents),
        )
