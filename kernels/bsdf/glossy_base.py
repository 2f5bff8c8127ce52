"""What a glossy lobe lets through to its diffuse base, and what it returns to it."""

import numpy as np

from photonmap.kernels.bsdf import facets, glossy
from photonmap.kernels.core import vec
from photonmap.kernels.core.fresnel import dip_of
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.metals import DIP_MEANS


@jit
def _terms_of(scattering, maps, lobe, w, n):
    """Return the albedos of the lobe for light to or from w, as `Reflection.incoming`."""
    uneven, cosine = scattering.anisotropy, vec.dot(w, n)
    share = facets.azimuth(uneven, lobe, w, n)
    single = glossy.look_up_albedo(scattering.albedos, maps, uneven, lobe, 0, cosine, share)
    grazing = glossy.look_up_albedo(scattering.albedos, maps, uneven, lobe, 1, cosine, share)
    dip = glossy.dip_albedos(scattering, scattering.dip, maps, uneven, lobe, (cosine, share))
    return single, grazing, dip


@jit
def pass_lobe(scattering, maps, lobe, w, n, values):
    """Multiply values, (N,), by the part of light to or from w that passes the lobe."""
    if vec.dot(w, n) <= 0.0:
        values[:] = 0.0
        return
    terms = _terms_of(scattering, maps, lobe, w, n)
    mean = glossy.mean_albedo(scattering.albedos, maps, lobe, 0)
    weights = scattering.dip, lobe.material
    for band in range(len(values)):
        f0 = glossy.normal_reflectance(scattering, maps, lobe, band)
        multiple = glossy.multiple_fresnel(lobe, f0, dip_of(weights, DIP_MEANS, band), mean)
        own = glossy.lobe_albedo(terms, f0, dip_of(weights, terms[2], band), multiple)
        values[band] *= np.float32(1.0 - own)


@jit
def return_to_base(scattering, maps, lobe, values):
    """Turn the base's albedos in values, (N,), into what it sends in all, reflected back to it."""
    albedos, dips = scattering.albedos, scattering.dip
    means = glossy.mean_albedo(albedos, maps, lobe, 0), glossy.mean_albedo(albedos, maps, lobe, 1)
    dip, weights = glossy.mean_dips(scattering, dips, maps, lobe), (dips, lobe.material)
    for band in range(len(values)):
        f0, rho = glossy.normal_reflectance(scattering, maps, lobe, band), float(values[band])
        multiple = glossy.multiple_fresnel(lobe, f0, dip_of(weights, DIP_MEANS, band), means[0])
        back = glossy.lobe_albedo(means, f0, dip_of(weights, dip, band), multiple)
        values[band] = np.float32(rho / max(1.0 - rho * back, glossy.TINY))


@jit
def share_of_lobe(scattering, maps, lobe, wo, n):
    """Return which part of the light to wo the lobe reflects, about."""
    cosine = vec.dot(wo, n)
    if cosine <= 0.0:
        return 0.0
    share = facets.azimuth(scattering.anisotropy, lobe, wo, n)
    return glossy.lobe_probability(scattering, maps, lobe, cosine, share)
