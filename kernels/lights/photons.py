"""Photons as they leave emitters."""

from photonmap.kernels.core import warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.emission import emission_of, set_flux
from photonmap.kernels.lights.kinds import emit


@jit
def emit_photon(geometry, lights, position, direction, share, flux):
    """Send a photon from an emitter, by two points of the unit square; fill flux, (N,).

    `share` multiplies its flux. Returns (origin, direction).
    """
    emitter, u = warp.discrete(lights.cdf, position[0])
    start = emit(geometry, lights, emitter, (u, position[1]), direction)
    send(lights, emitter, start, share, flux)
    return start.origin, start.direction


@jit
def send(lights, emitter, start, share, flux):
    """Fill flux, (N,), of a photon that starts from an emitter chosen by `Lights.cdf`."""
    probability = warp.discrete_pdf(lights.cdf, emitter)
    emission = emission_of(lights, emitter, start.position)
    set_flux(flux, lights, emission, start.weight / probability * share)
