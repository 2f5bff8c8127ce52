"""Material look-up: the diffuse albedo where a ray meets a surface, of a table or a texture."""

import numpy as np

from photonmap.kernels.core.bands import mix
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.texture import coordinates_at, look_up_indices, reflectance_at

_NO_ROWS = ((-1, -1, -1, -1), (0.0, 0.0, 0.0, 0.0))
_BLACK = ((0.0, 0.0, 0.0), _NO_ROWS)


@jit
def look_up_material(scene, hit):
    """Return (material, colour) of a hit; the colour means something where it is textured."""
    material = scene.geometry.material[hit.triangle]
    if scene.textures is None:
        return material, _BLACK
    return material, _look_up(scene.geometry, scene.textures, hit)


@outlined
def _look_up(geometry, textures, hit):
    """Return (r, g, b) and four rows of palettes with their weights; rows of -1 for a colour."""
    palettes = textures.palettes
    image = textures.reflectance[geometry.material[hit.triangle]]
    if image < 0:
        return _BLACK
    s, t = coordinates_at(geometry, hit)
    if palettes is not None and palettes.address[image] != 0:
        return _BLACK[0], look_up_indices(textures.maps, palettes, image, s, t)
    return reflectance_at(textures.maps, image, s, t), _NO_ROWS


@jit
def albedo(scene, color, band):
    """Return the diffuse albedo in one band of what `look_up_material` gave."""
    textures = scene.textures
    if textures is None or textures.reflectance[color[0]] < 0:
        return scene.materials.reflectance[color[0], band]
    return _mix(textures, color[1], band)


@jit
def _mix(textures, color, band):
    """Return one band of what `_look_up` gave."""
    rgb, rows = color
    if textures.palettes is not None:
        (a, b, c, d), (p, q, r, s) = rows
        if a >= 0:
            spectra = textures.palettes.spectra
            above = p * spectra[a, band] + q * spectra[b, band]
            return np.float32(above + r * spectra[c, band] + s * spectra[d, band])
    return np.float32(mix(rgb, textures.basis, band))


@jit
def multiply_albedo(scene, color, factor, throughput):
    """Multiply throughput, (N,), by factor · albedo; return its largest, (old, new)."""
    factor = np.float32(factor)
    before = after = np.float32(0.0)
    for band in range(len(throughput)):
        before = max(before, throughput[band])
        throughput[band] *= albedo(scene, color, band) * factor
        after = max(after, throughput[band])
    return before, after
