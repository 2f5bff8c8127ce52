"""The kinds of emitters, and the calls to each: how likely, towards a point, and as photons.

A kind is a module of functions beside each other: `importance` estimates the irradiance at a point
from an emitter of power 1, by which emitters are chosen; `sample_towards` returns a `LightSample`,
`emit` a `PhotonStart`, and `emitted` what leaves for another direction. Its `Parameters`, a
NamedTuple of numbers, are what describes an emitter beside its place and axis.
"""

from types import ModuleType
from typing import NamedTuple

from photonmap.kernels.core.jit import by_number
from photonmap.kernels.lights import dome, photometric, point, spot, sun, triangle


class Kind(NamedTuple):
    """A kind of emitters."""

    functions: ModuleType
    has_place: bool  # whether it shines from a place, not from infinitely far away
    has_area: bool  # whether camera rays and scattered rays can hit it, and its shadows are soft


KINDS = {
    "triangle": Kind(triangle, has_place=True, has_area=True),
    "point": Kind(point, has_place=True, has_area=False),
    "dome": Kind(dome, has_place=False, has_area=True),
    "spot": Kind(spot, has_place=True, has_area=False),
    "directional": Kind(sun, has_place=False, has_area=False),
    "photometric": Kind(photometric, has_place=True, has_area=False),
}  # By the names that lights give them
NUMBERS = {name: number for number, name in enumerate(KINDS)}  # Values of `Lights.kind`
TRIANGLE, DOME, DIRECTIONAL = (NUMBERS[name] for name in ("triangle", "dome", "directional"))


def numbers_where(**traits: bool) -> list[int]:
    """Return the values of `Lights.kind` of the kinds that have some traits."""
    return [
        NUMBERS[name]
        for name, kind in KINDS.items()
        if all(getattr(kind, trait) == value for trait, value in traits.items())
    ]


WITHOUT_AREA = numbers_where(has_area=False)
"""Values of `Lights.kind` of emitters whose light arrives from one direction, or from a few"""

_modules = [kind.functions for kind in KINDS.values()]
_kind = "lights.kind[emitter]"
importance = by_number(_modules, "importance", "geometry, lights, emitter, at, ns", _kind)
"""Estimate the unoccluded irradiance at a point from an emitter of power 1"""
sample_towards = by_number(
    _modules, "sample_towards", "geometry, lights, emitter, surface, u, v", _kind
)  # Return the `LightSample` of an emitter for a surface point
emit = by_number(_modules, "emit", "geometry, lights, emitter, position, direction", _kind)
"""Return the `PhotonStart` of an emitter, by two points of the unit square"""
emitted = by_number(_modules, "emitted", "geometry, lights, emitter, start, direction", _kind)
"""Return what a `PhotonStart` of an emitter sends in another direction.  As (flux per steradian for
an emission of 1, density of `emit` per steradian); of emitters that are infinitely far, nothing."""
