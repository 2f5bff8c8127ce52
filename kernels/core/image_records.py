"""What kernels know of images on surfaces: texels, glossy lobes that vary, and relief."""

from typing import NamedTuple

from numba.types import float32, float64, int32, int64, uint8

from photonmap.kernels.core.record_types import by_reference

BYTES, SRGB, FLOATS = 0, 1, 2
"""Kinds of texels: linear bytes, sRGB bytes, linear float32; the first two are rows of a table."""


@by_reference
class Maps(NamedTuple):
    """Images as surfaces use them, one row for each of R uses: see `geometry.texture`."""

    address: int64[::1]
    """(R,) int64, of the first texel"""
    shape: int32[:, ::1]
    """(R, 3) int32, rows, columns, and channels (1 or 3)"""
    kind: uint8[::1]
    """(R,) uint8: BYTES, SRGB or FLOATS"""
    clamp: uint8[::1]
    """(R,) uint8, 1 where edges go on outside the unit square; otherwise the image repeats"""
    placement: float64[:, ::1]
    """(R, 4) float64, scale of u and v, then their offset"""
    factor: float64[:, ::1]
    """(R, 3) float64, of red, green and blue"""
    tables: float32[:, ::1]
    """(2, 256) float32, linear values of bytes"""


@by_reference
class LobeMaps(NamedTuple):
    """Glossy lobes that vary over surfaces; a scene without any has None in its place."""

    maps: Maps
    roughness: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    glossy: int32[::1]
    """(M,) int32, likewise, of the reflectance at normal incidence"""
    base: int32[::1]
    """(M,) int32, likewise, of the diffuse base"""
    anisotropy: int32[::1]
    """(M,) int32, likewise, of direction and strength along the surface"""
    coat: int32[::1]
    """(M,) int32, likewise, of the weight of a clear coat"""
    coat_roughness: int32[::1]
    """(M,) int32, likewise, of its roughness"""
    basis: float32[:, ::1]
    """(3, N) float32, which makes reflectances of linear RGB"""
    first: int32[::1]
    """(M,) int32, row of `Scattering.albedos` where those of even steps of roughness begin"""
    steps: int
    """number of these rows"""
    least: float
    """smallest α"""


@by_reference
class Relief(NamedTuple):
    """What turns shading normals; a scene where nothing does has None in its place."""

    maps: Maps
    image: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    is_height: uint8[::1]
    """(M,) uint8, 1 where it holds derivatives of heights by u and v, 0 where directions"""
    strength: float64[::1]
    """(M,) float64, height of 1, or by what directions along the surface are multiplied"""
    tangents: float32[:, ::1]
    """(V, 4) float32, in which u rises, for directions, 0 where the surface is flat; and the sign
    of tangents that the mesh has, 0 of those that follow from texture coordinates"""
