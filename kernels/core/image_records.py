"""What kernels know of images on surfaces: texels, glossy lobes that vary, and relief."""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.core.record_types import by_reference

BYTES, SRGB, FLOATS = 0, 1, 2
"""Kinds of texels: linear bytes, sRGB bytes, linear float32; the first two are rows of a table."""


@by_reference
class Maps(NamedTuple):
    """Images as surfaces use them, one row for each of R uses: see `geometry.texture`."""

    address: np.ndarray
    """(R,) int64, of the first texel"""
    shape: np.ndarray
    """(R, 3) int32, rows, columns, and channels (1 or 3)"""
    kind: np.ndarray
    """(R,) uint8: BYTES, SRGB or FLOATS"""
    clamp: np.ndarray
    """(R,) uint8, 1 where edges go on outside the unit square; otherwise the image repeats"""
    placement: np.ndarray
    """(R, 4) float64, scale of u and v, then their offset"""
    factor: np.ndarray
    """(R, 3) float64, of red, green and blue"""
    tables: np.ndarray
    """(2, 256) float32, linear values of bytes"""


@by_reference
class LobeMaps(NamedTuple):
    """Glossy lobes that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    roughness: np.ndarray
    """(M,) int32, row of `maps`, -1 for none"""
    glossy: np.ndarray
    """(M,) int32, likewise, of the reflectance at normal incidence"""
    base: np.ndarray
    """(M,) int32, likewise, of the diffuse base"""
    anisotropy: np.ndarray
    """(M,) int32, likewise, of direction and strength along the surface"""
    coat: np.ndarray
    """(M,) int32, likewise, of the weight of a clear coat"""
    coat_roughness: np.ndarray
    """(M,) int32, likewise, of its roughness"""
    basis: np.ndarray
    """(3, N) float32, which makes reflectances of linear RGB"""
    first: np.ndarray
    """(M,) int32, row of `Scattering.albedos` where those of even steps of roughness begin"""
    steps: int
    """number of these rows"""
    least: float
    """smallest α"""


@by_reference
class Relief(NamedTuple):
    """What turns shading normals; a scene where nothing does has None in its place."""

    maps: Maps
    image: np.ndarray
    """(M,) int32, row of `maps`, -1 for none"""
    is_height: np.ndarray
    """(M,) uint8, 1 where it holds derivatives of heights by u and v, 0 where directions"""
    strength: np.ndarray
    """(M,) float64, height of 1, or by what directions along the surface are multiplied"""
    tangents: np.ndarray
    """(V, 4) float32, in which u rises, for directions, 0 where the surface is flat; and the sign
    of tangents that the mesh has, 0 of those that follow from texture coordinates"""
