"""Lambert's law: the diffuse lobe, of reflectance × shading and of the radiosity cache."""

import numpy as np

from photonmap.kernels.bsdf.cover import covered
from photonmap.kernels.bsdf.glossy import Lobe
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.warp import INV_PI

IS_NARROW = False  # See `models`


@jit
def sample_cosine(surface, u, v):
    """Return a direction about the shading normal, distributed by its cosine."""
    return vec.from_frame(warp.cosine_hemisphere(u, v), surface.ns)


@jit
def cosine_pdf(surface, wi):
    """Return the density of `sample_cosine` (per steradian)."""
    return warp.cosine_hemisphere_pdf(vec.dot(surface.ns, wi))


@jit
def lobe_at(geometry, scattering, hit):
    """Return the `Lobe` of a surface that has none: a black one over its base."""
    material = geometry.material[hit.triangle]
    albedo, nothing = scattering.parameters[material, 2], (0.0, 0.0, 0.0)
    row, curve = np.int64(material), (0.0, 0.0)
    return Lobe(material, 1.0, 0.0, albedo, row, 0.0, False, nothing, 1.0, nothing, 0, curve, -1.0)


@jit
def evaluate(scattering, base, surface, wi, cover, values):
    """Turn the albedos in values, (N,), into the BSDF (per steradian) with all that covers it."""
    for band in range(len(values)):
        rho = float(values[band])
        values[band] = covered(cover, 0.0, rho, rho * INV_PI)


@jit
def sample(scattering, base, surface, u, v):
    """Return a direction of density `pdf`."""
    return sample_cosine(surface, u, v)


@jit
def pdf(scattering, base, surface, wi):
    """Return the density of `sample` (per steradian)."""
    return cosine_pdf(surface, wi)
