"""Glass where a ray meets it: its tint, its roughness, and how much of it there is.

And what it absorbs along rays inside, by the Beer–Lambert law.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.facets import brush_at, brush_of, tangent_of
from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import mix
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.interaction import side_of
from photonmap.kernels.geometry.texture import coordinates_at, fraction_at, reflectance_at


class Roughness(NamedTuple):
    """How rough a specular surface is at a point: a lobe for `facets`."""

    along: float  # GGX's α along the tangent
    alpha: float  # across it
    tangent: tuple  # see `facets`


@jit
def alpha_at(geometry, alpha, maps, hit):
    """Return GGX's α of a rough specular surface, of a table (M,) or a texture of roughness."""
    material = geometry.material[hit.triangle]
    if maps is None or maps.roughness[material] < 0:
        return alpha[material]
    roughness = fraction_at(geometry, maps.maps, maps.roughness[material], hit)
    return max(roughness * roughness, maps.least)


@outlined
def roughness_at(scene, hit):
    """Return the `Roughness` of a rough specular surface."""
    geometry, specular, anisotropy = scene.geometry, scene.specular, scene.specular.anisotropy
    alpha = alpha_at(geometry, specular.alpha, specular.maps, hit)
    if anisotropy is None:
        return Roughness(alpha, alpha, (0.0, 0.0, 0.0))
    material, maps = geometry.material[hit.triangle], specular.maps
    if maps is None:
        brush = brush_of(anisotropy, material)
    else:
        s, t = coordinates_at(geometry, hit)
        brush = brush_at(anisotropy, maps, material, s, t)
    tangent = tangent_of(geometry, anisotropy, brush, hit)
    return Roughness(alpha + (1.0 - alpha) * brush.stretch, alpha, tangent)


@jit
def multiply_tint(scene, hit, factor, throughput):
    """Multiply throughput, (N,), by factor · what glass transmits at a crossing."""
    material, factor = scene.geometry.material[hit.triangle], np.float32(factor)
    if scene.specular.maps is None:
        for band in range(len(throughput)):
            throughput[band] *= scene.specular.tint[material, band] * factor
        return
    _multiply_mixed(scene, hit, 0.0, factor, throughput)


@jit
def multiply_remainder(scene, hit, clear, throughput):
    """Multiply throughput, (N,), by what smooth panes transmit of light that they stopped.

    `clear` is what they let pass of all bands; `specular.tint` holds what remains, but for textures
    the whole tint.
    """
    if scene.specular.maps is None:
        multiply_tint(scene, hit, 1.0, throughput)
        return
    _multiply_mixed(scene, hit, clear, np.float32(1.0), throughput)


@jit
def _multiply_mixed(scene, hit, clear, factor, throughput):
    """Multiply throughput by factor · (tint - clear) / (1 - clear), where tint is textured."""
    geometry, maps = scene.geometry, scene.specular.maps
    material = geometry.material[hit.triangle]
    image = maps.tint[material]
    if image < 0:
        for band in range(len(throughput)):
            throughput[band] *= scene.specular.tint[material, band] * factor
        return
    s, t = coordinates_at(geometry, hit)
    rgb, rest = reflectance_at(maps.maps, image, s, t), max(1.0 - clear, 1e-12)
    for band in range(len(throughput)):
        tint = max(mix(rgb, maps.basis, band) - clear, 0.0) / rest
        throughput[band] *= np.float32(tint) * factor


@jit
def glass_fraction(geometry, fraction, hit):
    """Return which fraction of a surface is glass; 1 where no surface is so in part."""
    if fraction is None:
        return 1.0
    material = geometry.material[hit.triangle]
    if fraction.maps is None or fraction.image[material] < 0:
        return fraction.value[material]
    return fraction_at(geometry, fraction.maps, fraction.image[material], hit)


@jit
def take_glass_fraction(geometry, fraction, hit, throughput):
    """Multiply throughput, (N,), by the fraction of a surface that is glass."""
    if fraction is None:
        return
    value = np.float32(glass_fraction(geometry, fraction, hit))
    for band in range(len(throughput)):
        throughput[band] *= value


@jit
def absorb(scene, hit, direction, from_specular, throughput):
    """Multiply throughput, (N,), by what glass around the ray to `hit` transmits."""
    specular = scene.specular
    if specular is None:
        return
    media = specular.media
    if media is None or len(media.absorption) == 0 or hit.triangle < 0:
        return
    if not from_specular and specular.kind[scene.geometry.material[hit.triangle]] == 0:
        return
    medium = media.of_side[hit.triangle, side_of(scene.geometry, hit.triangle, direction)]
    if medium < 0:
        return
    length = hit.distance * math.sqrt(vec.dot(direction, direction))
    for band in range(len(throughput)):
        throughput[band] *= np.float32(math.exp(-media.absorption[medium, band] * length))
