"""Photometric lights: a position whose intensity is a table over directions, as in IES files."""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.lights.point import importance_at, sample_position
from photonmap.kernels.lights.samples import NOWHERE, LightSample, PhotonStart
from photonmap.kernels.lights.samples import NoParameters as Parameters  # noqa: F401


@outlined
def intensity(lights, emitter, direction):
    """Return the relative intensity in a unit direction, bilinear between a table's angles."""
    profiles = lights.profiles
    if profiles is None:
        return 0.0  # no light is of this kind
    row = profiles.row[emitter]
    table, frame = profiles.intensity[row], profiles.frame[row]
    x = vec.dot(vec.row(frame, 0), direction)
    y = vec.dot(vec.row(frame, 1), direction)
    z = vec.dot(vec.row(frame, 2), direction)
    polar = math.acos(min(max(z, -1.0), 1.0)) / math.pi * (table.shape[0] - 1)
    azimuth = math.atan2(y, x) / (2.0 * math.pi)
    azimuth = (azimuth - math.floor(azimuth)) * (table.shape[1] - 1)
    i = min(int(polar), table.shape[0] - 2)
    j = min(int(azimuth), table.shape[1] - 2)
    s, t = polar - i, azimuth - j
    near = (1.0 - t) * table[i, j] + t * table[i, j + 1]
    return (1.0 - s) * near + s * ((1.0 - t) * table[i + 1, j] + t * table[i + 1, j + 1])


@jit
def importance(geometry, lights, emitter, at, ns):
    """Estimate the irradiance at a point from a light of power 1, unless it is occluded."""
    position = vec.row(lights.position, emitter)
    step = vec.sub(at, position)
    if vec.dot(step, step) == 0.0:
        return 0.0
    relative = intensity(lights, emitter, vec.normalize(step))
    return relative * importance_at(position, at, ns) * warp.uniform_sphere_pdf()


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Return the only `LightSample` there is."""
    sample = sample_position(vec.row(lights.position, emitter), surface)
    relative = intensity(lights, emitter, vec.scale(sample.direction, -1.0))
    return LightSample(
        sample.segment, 1.0, sample.direction, sample.weight * relative, 0.0, NOWHERE
    )


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by a point of the unit square; a `PhotonStart`."""
    towards = warp.uniform_sphere(direction[0], direction[1])
    weight = intensity(lights, emitter, towards) / warp.uniform_sphere_pdf()
    return PhotonStart(weight, NOWHERE, vec.row(lights.position, emitter), towards)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return what is sent in a direction, per steradian, and the density of `emit`."""
    return intensity(lights, emitter, direction), warp.uniform_sphere_pdf()
