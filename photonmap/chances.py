"""How often each emitter is chosen, for light samples and for photons."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from photonmap.kernels.records import Lights
from photonmap.light_tree import reweigh

Floats = NDArray[np.float64]

EVEN = 0.1
"""Share of all choices that lights get evenly: a weak one may be all that lights what is seen."""
SELDOM = 0.01
"""Of its share, what a light gets that seems to send nothing into the view."""


def even_out(flux: Floats, names: Sequence[str]) -> Floats:
    """Return the chances of K emitters, (K,): by power for the most part, evenly for the rest.

    Parameters
    ----------
    flux : (K,) above 0
    names : of the light that each emitter belongs to
    """
    _, light = np.unique(np.array(names), return_inverse=True)
    of_light = np.bincount(light, flux)
    return (1.0 - EVEN) * flux / flux.sum() + EVEN * flux / of_light[light] / len(of_light)


def rise(chances: Floats) -> Floats:
    """Return running sums of chances, from above 0 to exactly 1."""
    sums = np.cumsum(chances)
    cumulative = np.minimum(sums / sums[-1], 1.0)
    cumulative[-1] = 1.0
    return cumulative


def choose_seldom(lights: Lights, names: Sequence[str], hidden: Collection[str]) -> Lights:
    """Return lights among which those that seem hidden are chosen seldom.

    Never is not enough: a light may reach the view on ways that were not found.
    """
    rare = np.array([name in hidden for name in names])
    if not rare.any() or rare.all():
        return lights
    weights = np.where(rare, SELDOM, 1.0)
    cumulative = rise(weights * np.diff(lights.cumulative, prepend=0.0))
    tree = reweigh(lights.tree, weights, cumulative) if lights.tree else None
    return lights._replace(cumulative=cumulative, tree=tree)
