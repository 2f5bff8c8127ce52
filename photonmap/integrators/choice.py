"""The integrators by the names of their methods; a new one is entered here.

Nothing is imported until a render needs it, so that help and checks of options are fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

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
    "path": Method("path", "PathIntegrator", "plain path tracing, its reference"),
}


def make_integrator(method: str, setup: PassSetup) -> Integrator:
    """Make the integrator of a method."""
    chosen = METHODS[method]
    module = import_module(f"photonmap.integrators.{chosen.module}")
    integrator: Integrator = getattr(module, chosen.integrator)(setup)
    return integrator
