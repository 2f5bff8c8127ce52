"""Glossy lobes that differ along a surface, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from photonmap.compile.glossy import AZIMUTHS, azimuth_albedos
from photonmap.compile.surfaces.relief import vertex_tangents
from photonmap.kernels.core import records
from photonmap.scene.material import Material


def with_anisotropy(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    geometry: records.Geometry,
) -> records.Scattering | None:
    """Return BSDFs with what tells how lobes differ along surfaces, where any do.

    Parameters
    ----------
    materials : (M,)
    geometry : with materials, and texture coordinates where there are any
    """
    chosen = [index for index, material in enumerate(materials) if material.is_anisotropic]
    if scattering is None or not chosen:
        return scattering
    stretch = np.array([each.is_anisotropic * each.anisotropy**2 for each in materials])
    angles = 2.0 * np.pi * np.array([material.anisotropy_rotation for material in materials])
    albedos, first = scattering.albedos.copy(), np.full(len(materials), -1, np.int32)
    for index in chosen:
        across = float(scattering.parameters[index, 0])
        rows = azimuth_albedos(across + (1.0 - across) * float(stretch[index]), across)
        first[index], albedos[index] = len(albedos), rows[0]
        albedos = np.concatenate([albedos, rows[1:]])
    tangents = np.zeros_like(geometry.vertices)
    if len(geometry.uv):
        tangents = vertex_tangents(geometry, (stretch > 0.0)[geometry.material])
    anisotropy = records.Anisotropy(
        stretch, np.stack([np.cos(angles), np.sin(angles)], axis=1), first, AZIMUTHS, tangents
    )
    return scattering._replace(albedos=albedos, anisotropy=anisotropy)
