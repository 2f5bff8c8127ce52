"""The integrators by the names of their methods; a new one is entered here.

Nothing is imported until a render needs it, so that help and checks of options are fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from photonmap.errors import InputError

if TYPE_CHECKING:
    from photonmap.integrators.base import Integrator, PassSetup


class Method(NamedTuple):
    """What is known of an integrator before it is imported."""

    module: str
    """in photonmap.integrators"""
    integrator: str
    """the name of the class"""
    meaning: str
    """for help texts"""


METHODS = {
    "photon": Method("photon_mapping.integrator", "PhotonIntegrator", "photon mapping"),
    "path": Method(
        "path",
        "PathIntegrator",
        "plain path tracing, its reference, which finds no caustics of points, spots and suns",
    ),
}
_UNBIASED = "unbiased"
_INTEGRATORS = METHODS | {
    _UNBIASED: Method(
        "photon_mapping.unbiased", "UnbiasedIntegrator", "photon mapping without bias"
    )
}


def choose_integrator(method: str, unbiased: bool) -> str:
    """Return the name of a method's integrator; `InputError` if it has no bias to be without."""
    if unbiased and method != "photon":
        raise InputError(f"unbiased: method {method} has no bias; leave one of the two out")
    return _UNBIASED if unbiased else method


def check_unbiased(unbiased: bool, in_scene: bool, simulated: bool) -> None:
    """Refuse to render without bias where specular surfaces are in the scene, or simulated anyhow.

    That is an `InputError`.
    """
    if unbiased and in_scene:
        raise InputError(
            "unbiased: mirrors and glass make caustics, which are counted over disks; leave it "
            "out, or use method path, which has no bias"
        )
    if unbiased and simulated:
        raise InputError(
            "unbiased: the effects of mirrors and glass have a bias, and there are none; leave out "
            "effects"
        )


def make_integrator(method: str, setup: PassSetup) -> Integrator:
    """Make an integrator by the name that `choose_integrator` returns."""
    chosen = _INTEGRATORS[method]
    module = import_module(f"photonmap.integrators.{chosen.module}")
    integrator: Integrator = getattr(module, chosen.integrator)(setup)
    return integrator
