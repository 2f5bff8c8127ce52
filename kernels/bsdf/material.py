"""Material look-up: the diffuse albedo where a ray meets a surface, of a table or a texture.

Textures are an argument of their own, None in a scene without any: then none of their code is
compiled.
"""

import numpy as np

from photonmap.kernels.core.bands import attenuate, mix
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.texture import coordinates, look_up


@jit
def look_up_material(geometry, textures, hit):
    """Return (material, r, g, b) of a hit; the colour means something where it is textured."""
    material = geometry.material[hit.triangle]
    if textures is None:
        return material, 0.0, 0.0, 0.0
    image = textures.reflectance[material]
    if image < 0:
        return material, 0.0, 0.0, 0.0
    s, t = coordinates(geometry.uv, geometry.triangles, hit.triangle, hit.u, hit.v)
    r, g, b = look_up(textures.maps, image, s, t)
    return material, min(r, 1.0), min(g, 1.0), min(b, 1.0)


@jit
def albedo(materials, textures, color, band):
    """Return the diffuse albedo in one band of what `look_up_material` gave."""
    if textures is None:
        return materials.reflectance[color[0], band]
    if textures.reflectance[color[0]] < 0:
        return materials.reflectance[color[0], band]
    return np.float32(mix((color[1], color[2], color[3]), textures.basis, band))


@jit
def multiply_albedo(throughput, materials, textures, color, factor):
    """Multiply throughput, (N,), by factor · albedo; return its largest, (old, new)."""
    if textures is None:
        return attenuate(throughput, materials.reflectance, color[0], factor)
    factor = np.float32(factor)
    before = after = np.float32(0.0)
    for band in range(len(throughput)):
        before = max(before, throughput[band])
        throughput[band] *= albedo(materials, textures, color, band) * factor
        after = max(after, throughput[band])
    return before, after
