"""What kernels know of facets that differ along a surface, of clear coats, and of sheen."""

from typing import NamedTuple

from numba.types import float32, float64, int32, uint8

from photonmap.kernels.core.image_records import LobeMaps, Maps, Relief
from photonmap.kernels.core.record_types import by_reference


@by_reference
class Anisotropy(NamedTuple):
    """Facets that are rougher along a tangent than across; a scene without has None instead."""

    stretch: float64[::1]
    """(M,) float64, how far α along the tangent is on the way from what it is across to 1; 0 where
    it is the same"""
    turn: float64[:, ::1]
    """(M, 2) float64, cosine and sine of the angle from where u rises to the tangent"""
    first: int32[::1]
    """(M,) int32, row of `Scattering.albedos` where those of a lobe's azimuths begin, evenly
    in the square of the sine from the tangent; before them stand, where an image gives the
    strength, those of lesser strengths, and before all the means over azimuths of each"""
    azimuths: int
    """number of the rows of one strength"""
    strengths: int
    """number of strengths of an image, evenly from 0 to the largest, which `stretch` is of"""
    tangents: float32[:, ::1]
    """(V, 4) float32, in which u rises, 0 where the surface is flat; and the sign of tangents that
    the mesh has, 0 of others"""


@by_reference
class Coats(NamedTuple):
    """Clear coats over other surfaces: see `bsdf.coated`. A scene without has None instead."""

    weight: float64[::1]
    """(M,) float64, fraction of the surface that is covered; 0 where there is no coat"""
    f0: float64[::1]
    """(M,) float64, reflectance of the coat at normal incidence"""
    refraction: float64[::1]
    """(M,) float64, its index of refraction"""
    mean_rise: float64[::1]
    """(M,) float64, cosine-weighted mean of its `core.fresnel.rise`"""
    alpha: float64[::1]
    """(M,) float64, its α"""
    row: int32[::1]
    """(M,) int32, row of `Scattering.albedos` with those of the coat"""
    stepped: int32[::1]
    """(M,) int32, likewise where those of even steps of its roughness begin, see `LobeMaps`"""
    dielectric: float64[::1]
    """(M,) float64, reflectance at normal incidence of the base's lobe, where it is no metal"""
    first: int32[::1]
    """(M,) int32, row of `through` where those of the coat begin; after them, where an image gives
    its roughness, come those of coats of `LobeMaps.steps` steps of roughness"""
    steps: int32[::1]
    """(M,) int32, number of these rows, of even steps of the roughness of the base"""
    through: float64[:, :, ::1]
    """(R, 2, K) float64, how a coat lets light pass from each of K - 1 angles: to what is no metal,
    and to metal; see `bsdf.coated`"""
    maps: LobeMaps | None
    """None where no image gives the roughness of a coat"""
    own: uint8[::1]
    """(M,) uint8, 1 where the normals of a coat are not those of what lies below"""
    relief: Relief | None
    """what turns these from the interpolated normals; None where all coats lie as their bases do"""


@by_reference
class Sheens(NamedTuple):
    """Sheen over other surfaces: see `bsdf.sheen`. A scene without has None instead."""

    color: float32[:, ::1]
    """(M, N) float32, its reflectance; 0 where there is no sheen"""
    mean: float64[::1]
    """(M,) float64, the mean of that over bands"""
    alpha: float64[::1]
    """(M,) float64, its α"""
    row: int32[::1]
    """(M,) int32, row of the tables"""
    kept: float64[:, ::1]
    """(R, K) float64, how much of its lobe is kept at each of K - 1 angles, lest it make
    light"""
    albedo: float64[:, ::1]
    """(R, K) float64, what it reflects of light from these for a colour of 1, and the
    cosine-weighted mean over all"""
    through: float64[:, :, ::1]
    """(R, C, K) float64, how it lets light pass to the base from each angle, for C even steps of
    its colour from 0 to 1"""
    maps: Maps | None
    """None where no image gives the colour of a sheen"""
    image: int32[::1]
    """(M,) int32, row of `maps`, -1 for none"""
    basis: float32[:, ::1]
    """(3, N) float32, which makes reflectances of linear RGB"""
