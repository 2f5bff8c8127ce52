"""Facets of gloss and of rough glass that differ along a surface, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.glossy import AZIMUTHS, COARSE, GRID, azimuth_albedos
from photonmap.compile.surfaces.tangents import vertex_tangents
from photonmap.kernels.core import records
from photonmap.kernels.core.lobe_records import Anisotropy
from photonmap.scene.material import Material

STRENGTHS = 9
"""Of an image: those between are interpolated."""


def with_anisotropy(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    geometry: records.Geometry,
    given: NDArray[np.float64],
) -> records.Scattering | None:
    """Return BSDFs with what tells how lobes differ along surfaces, where any do.

    Parameters
    ----------
    materials : (M,)
    geometry : with materials, and texture coordinates where there are any
    given : tangents of vertices, see `given_tangents`
    """
    chosen = np.array([each.is_glossy and each.is_anisotropic for each in materials])
    if scattering is None or not chosen.any():
        return scattering
    anisotropy = _anisotropy(materials, chosen, geometry, given)
    albedos, first = scattering.albedos.copy(), anisotropy.first
    for index in np.flatnonzero(chosen).tolist():
        across, refraction = scattering.parameters[index, [0, 3]].tolist()
        rows = _rows(materials[index], across, refraction)
        albedos[index] = rows[-1, 0]
        if len(rows) > 1:
            albedos = np.concatenate([albedos, rows[:, 0]])
        albedos = np.concatenate([albedos, *rows[:, 1:]])
        first[index] = len(albedos) - AZIMUTHS
    return scattering._replace(albedos=albedos, anisotropy=anisotropy)


def with_anisotropic_chains(
    specular: records.Specular | None,
    materials: Sequence[Material],
    geometry: records.Geometry,
    given: NDArray[np.float64],
) -> records.Specular | None:
    """Return specular lobes with what tells how rough ones differ along surfaces, where any do.

    Parameters
    ----------
    materials, geometry, given : as of `with_anisotropy`
    """
    chosen = np.array([each.is_anisotropic and each.chain_alpha > 0.0 for each in materials])
    if specular is None or not chosen.any():
        return specular
    return specular._replace(anisotropy=_anisotropy(materials, chosen, geometry, given))


def _anisotropy(
    materials: Sequence[Material],
    chosen: NDArray[np.bool_],
    geometry: records.Geometry,
    given: NDArray[np.float64],
) -> Anisotropy:
    """Return how the chosen materials, (M,), differ along surfaces, with no rows of albedos."""
    stretch = np.array([_largest(material) ** 2 for material in materials]) * chosen
    angles = 2.0 * np.pi * np.array([material.anisotropy_rotation for material in materials])
    turn = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    tangents = vertex_tangents(geometry, (stretch > 0.0)[geometry.material], given)
    first = np.full(len(materials), -1, np.int32)
    return Anisotropy(stretch, turn, first, AZIMUTHS, STRENGTHS, tangents)


def _largest(material: Material) -> float:
    """Return the largest anisotropy of a material; 0 where it is alike in all directions."""
    if not material.is_brushed:
        return material.is_anisotropic * material.anisotropy
    assert material.anisotropy_map is not None
    return material.anisotropy * material.anisotropy_map.strengths[1]


def _rows(material: Material, across: float, refraction: float) -> NDArray[np.float64]:
    """Return `azimuth_albedos` of one strength, or of an image's from 0 to the largest, (S, …).

    Where an image has one strength all over, no others are looked up.

    Parameters
    ----------
    across, refraction : α across the tangent, and index of refraction
    """
    largest = _largest(material)

    def rows(strength: float, grid: int = COARSE) -> NDArray[np.float64]:
        along = across + (1.0 - across) * strength**2
        return azimuth_albedos(along, across, refraction, grid)

    if not material.is_brushed:
        return rows(largest, GRID)[None]
    assert material.anisotropy_map is not None
    low, high = material.anisotropy_map.strengths
    places = np.linspace(0.0, largest, STRENGTHS) if low < high else np.full(STRENGTHS, largest)
    return np.array([rows(strength) for strength in places.tolist()])
