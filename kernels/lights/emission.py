"""What emitters send, band by band, and the photons that carry it.

Emission is a row of a table, or the colour of a texture or map.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.core import warp
from photonmap.kernels.core.bands import mix
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import side_of
from photonmap.kernels.geometry.texture import coordinates, look_up
from photonmap.kernels.lights.environment import radiance_of, texel_at
from photonmap.kernels.lights.kinds import emit
from photonmap.kernels.lights.portal import position_on
from photonmap.kernels.lights.samples import NOWHERE


class Emission(NamedTuple):
    """What a position on an emitter sends; `emission_in` returns it by bands."""

    row: int  # of `Lights.spectra`
    texture: int  # which emission texture it is, -1 for none, MAP for the environment map
    color: tuple  # linear RGB of the texture or map


MAP = -2


@jit
def visible_emitter(geometry, lights, hit, direction):
    """Return (emitter, position on it) of what a ray hits, (-1, …) for none."""
    if hit.triangle < 0:
        environment = lights.environment
        return lights.dome, NOWHERE if environment is None else texel_at(environment, direction)
    emitter = geometry.emitter[hit.triangle]
    if emitter < 0 or side_of(geometry, hit.triangle, direction) != 0:
        return -1, (hit.u, hit.v)
    return emitter, position_on(lights, emitter, (hit.u, hit.v), direction)


@jit
def emission_of(lights, emitter, position):
    """Return the `Emission` of an emitter at a position on it, as in `LightSample`."""
    environment, textures = lights.environment, lights.emission_textures
    row = lights.spectrum[emitter]
    if environment is not None and row == environment.row:
        r, g, b = radiance_of(environment, position)
        return Emission(row, np.int64(MAP), (np.float64(r), np.float64(g), np.float64(b)))
    if textures is None or textures.slot[row] < 0:
        return Emission(row, np.int64(-1), (0.0, 0.0, 0.0))
    slot = np.int64(textures.slot[row])
    triangle = lights.triangle[emitter]
    s, t = coordinates(textures.uv, textures.triangles, triangle, position[0], position[1])
    return Emission(row, slot, look_up(textures.maps, textures.image[slot], s, t))


@jit
def emission_in(lights, emission, band):
    """Return an emission in one band, float32."""
    environment, textures = lights.environment, lights.emission_textures
    if environment is not None and emission.texture == MAP:
        return np.float32(mix(emission.color, environment.basis, band))
    if textures is not None and emission.texture >= 0:
        slot = emission.texture
        return np.float32(mix(emission.color, textures.basis[3 * slot : 3 * slot + 3], band))
    return lights.spectra[emission.row, band]


@jit
def add_emission(target, i, lights, emission, factor):
    """Add factor · emission to row i of target."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * emission_in(lights, emission, band)


@jit
def add_attenuated(target, i, lights, emission, throughput, factor):
    """Add factor · throughput, (N,), · emission to row i of target."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * throughput[band] * emission_in(lights, emission, band)


@jit
def emit_photon(geometry, lights, position, direction, weight, flux):
    """Send a photon from an emitter, by two points of the unit square; fill flux, (N,).

    `weight` multiplies its flux. Returns (origin, direction).
    """
    emitter, u = warp.discrete(lights.cdf, position[0])
    start = emit(geometry, lights, emitter, (u, position[1]), direction)
    send(lights, emitter, start, weight, flux)
    return start.origin, start.direction


@jit
def send(lights, emitter, start, weight, flux):
    """Fill flux, (N,), of a photon that starts from an emitter chosen by `Lights.cdf`."""
    probability = warp.discrete_pdf(lights.cdf, emitter)
    emission = emission_of(lights, emitter, start.position)
    factor = np.float32(start.weight / probability * weight)
    for band in range(len(flux)):
        flux[band] = emission_in(lights, emission, band) * factor
