"""Rough diffuse surfaces: energy-preserving Oren–Nayar (EON).

J. Portsmouth, P. Kutz and S. Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF",
JCGT 14(1), 2025. `parameters[0]` is the roughness, from 0 (Lambertian) to 1. Directions are those
of Lambert's law, from which the BSDF departs little.
"""

import math

from photonmap.kernels.bsdf.lambert import lobe_at, pdf, sample
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import departure

__all__ = ("directional_albedo", "evaluate", "lobe_at", "pdf", "sample")

IS_NARROW = False  # See `models`

DARKENING = 0.5 - 2.0 / (3.0 * math.pi)  # Of a grazing view at roughness 1: the first constant
MEAN_DARKENING = 2.0 / 3.0 - 28.0 / (15.0 * math.pi)  # Its weighted mean: the second
TINY = 1e-7


@jit
def directional_albedo(cosine, roughness):
    """Return the single-scattering albedo (of a white surface) for light at an angle (eq. 12)."""
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    g = sine * (math.acos(min(cosine, 1.0)) - sine * cosine)
    g += 2.0 / 3.0 * (sine / max(cosine, TINY) * (1.0 - sine * sine * sine) - sine)
    return (1.0 + roughness * g * warp.INV_PI) / (1.0 + DARKENING * roughness)


@jit
def evaluate(scattering, base, surface, wi, cover, values):
    """Turn the albedos in values, (N,), into the BSDF (per steradian); nothing may cover it."""
    roughness, wo, n = scattering.parameters[base.material, 0], departure(surface), surface.ns
    cos_i, cos_o = vec.dot(wi, n), vec.dot(wo, n)
    if cos_i <= 0.0 or cos_o <= 0.0:
        for band in range(len(values)):
            values[band] = 0.0
        return
    s = vec.dot(wi, wo) - cos_i * cos_o
    shape = s / max(cos_i, cos_o) if s > 0.0 else s
    level = 1.0 / (1.0 + DARKENING * roughness)
    mean = level * (1.0 + MEAN_DARKENING * roughness)
    single = warp.INV_PI * level * (1.0 + roughness * shape)
    missing = max(1.0 - directional_albedo(cos_i, roughness), TINY)
    missing *= max(1.0 - directional_albedo(cos_o, roughness), TINY)
    multiple = warp.INV_PI * missing / max(1.0 - mean, TINY)
    for band in range(len(values)):
        rho = values[band]
        values[band] = rho * single + rho * rho * mean / (1.0 - rho * (1.0 - mean)) * multiple
