"""The kinds of emitters, and the calls to each: how likely, towards a point, and as photons.

A kind is a file of functions beside each other: `importance` estimates the irradiance at a point
from an emitter of power 1, by which emitters are chosen; `sample_towards` returns a `LightSample`,
`pdf` its density where scattered rays can hit the emitter, `emit` a `PhotonStart`, and `emitted`
what leaves for another direction, where emitters are not infinitely far.
"""

from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights import infinite, photometric, point, portal, spot, triangle

TRIANGLE, POINT, DOME, SPOT, DIRECTIONAL, PHOTOMETRIC = 0, 1, 2, 3, 4, 5
"""Values of `Lights.kind`; the dome is even, or an environment map."""
KINDS = {
    "triangle": TRIANGLE,
    "point": POINT,
    "dome": DOME,
    "spot": SPOT,
    "directional": DIRECTIONAL,
    "photometric": PHOTOMETRIC,
}
"""By the names that lights give them."""
HITTABLE_KINDS = (TRIANGLE, DOME)
"""Those that camera rays and scattered rays can hit."""
EXTENDED_KINDS = (TRIANGLE, DOME)
"""Those that cast soft shadows, for which many light samples are taken."""
POSITION_KINDS = (POINT, SPOT, PHOTOMETRIC)
"""Those that shine from a point."""
INFINITE_KINDS = (DOME, DIRECTIONAL)
"""Those that are infinitely far."""


@jit
def importance(geometry, lights, emitter, at, ns):
    """Estimate the unoccluded irradiance at a point from an emitter of power 1."""
    kind = lights.kind[emitter]
    if kind == TRIANGLE:
        return triangle.importance(geometry, lights, emitter, at, ns)
    if kind == DOME:
        return infinite.dome_importance(lights)
    if kind == DIRECTIONAL:
        return infinite.sun_importance(lights, lights.portals, emitter, ns)
    if kind == SPOT:
        return spot.importance(lights, emitter, at, ns)
    return _importance_of_point(lights, lights.profiles, emitter, at, ns)


@jit
def _importance_of_point(lights, profiles, emitter, at, ns):
    if profiles is not None and lights.kind[emitter] == PHOTOMETRIC:
        return photometric.importance(lights, emitter, at, ns)
    return point.importance(lights, emitter, at, ns)


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Return the `LightSample` of an emitter for a surface point."""
    kind = lights.kind[emitter]
    if kind == TRIANGLE:
        return triangle.sample_towards(geometry, lights, emitter, surface, u, v)
    if kind == DOME:
        return infinite.sample_dome(lights.environment, surface, u, v)
    if kind == DIRECTIONAL:
        return infinite.sample_sun(lights, emitter, u, v)
    if kind == SPOT:
        return spot.sample_towards(lights, emitter, surface)
    return _sample_point(lights, lights.profiles, emitter, surface)


@jit
def _sample_point(lights, profiles, emitter, surface):
    if profiles is not None and lights.kind[emitter] == PHOTOMETRIC:
        return photometric.sample_towards(lights, emitter, surface)
    return point.sample_towards(lights, emitter, surface)


@jit
def emit(geometry, lights, emitter, position, direction):
    """Return the `PhotonStart` of an emitter, by two points of the unit square."""
    kind = lights.kind[emitter]
    if kind == TRIANGLE:
        return triangle.emit(geometry, lights, emitter, position, direction)
    if kind == DOME:
        return infinite.emit_from_dome(lights, lights.environment, position, direction)
    if kind == DIRECTIONAL:
        return _emit_from_sun(geometry, lights, lights.portals, emitter, position, direction)
    if kind == SPOT:
        return spot.emit(lights, emitter, direction)
    return _emit_from_point(lights, lights.profiles, emitter, direction)


@jit
def _emit_from_sun(geometry, lights, portals, emitter, position, direction):
    if portals is not None:
        towards = infinite.direction_of_sun(lights, emitter, direction[0], direction[1])
        return portal.emit_through(geometry, portals, emitter, position, towards)
    return infinite.emit_from_sun(lights, emitter, position, direction)


@jit
def _emit_from_point(lights, profiles, emitter, direction):
    if profiles is not None and lights.kind[emitter] == PHOTOMETRIC:
        return photometric.emit(lights, emitter, direction)
    return point.emit(lights, emitter, direction)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return what a `PhotonStart` of an emitter sends in another direction.

    As (flux per steradian for an emission of 1, density of `emit` per steradian).
    """
    kind = lights.kind[emitter]
    if kind == TRIANGLE:
        return triangle.emitted(geometry, lights, emitter, start, direction)
    if kind == SPOT:
        return spot.emitted(lights, emitter, direction)
    return _emitted_from_point(lights, lights.profiles, emitter, direction)


@jit
def _emitted_from_point(lights, profiles, emitter, direction):
    if profiles is not None and lights.kind[emitter] == PHOTOMETRIC:
        return photometric.emitted(lights, emitter, direction)
    return point.emitted()
