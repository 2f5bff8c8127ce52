"""The probabilities of emitters, for light samples and for photons."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.cdf import make_cdf, probabilities_of
from photonmap.compile.lights.light_tree import reweigh

if TYPE_CHECKING:
    from photonmap.kernels.core.records import Lights

Floats = NDArray[np.float64]

EVEN = 0.1
"""Share of the probability that lights get evenly: a weak one may be all that lights the view."""
SELDOM = 0.01
"""Factor on the probability of a light that seems to send nothing into the view."""


def mix_uniform(flux: Floats, names: Sequence[str]) -> Floats:
    """Return the probabilities of K emitters, (K,): mostly by power, evenly for the rest.

    Parameters
    ----------
    flux : (K,) above 0
    names : of the light that each emitter belongs to
    """
    _, light = np.unique(np.array(names), return_inverse=True)
    of_light = np.bincount(light, flux)
    return (1.0 - EVEN) * flux / flux.sum() + EVEN * flux / of_light[light] / len(of_light)


def downweight_hidden(lights: Lights, names: Sequence[str], hidden: Collection[str]) -> Lights:
    """Return lights among which those that seem hidden have a low probability.

    Not 0: a light may reach the view by paths that were not found.
    """
    rare = np.array([name in hidden for name in names])
    if not rare.any() or rare.all():
        return lights
    weights = np.where(rare, SELDOM, 1.0)
    cdf = make_cdf(weights * probabilities_of(lights.cdf))
    tree = reweigh(lights.tree, weights, cdf) if lights.tree else None
    return lights._replace(cdf=cdf, tree=tree)
