"""The illuminant by the assumption that differences in a scene are grey on average.

J. van de Weijer, T. Gevers and A. Gijsenij, "Edge-based color constancy", IEEE TIP 16(9), 2007:
n = 1, with the p = 5 and σ = 2 pixels of the code they released.
"""

from __future__ import annotations

from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.methods.minkowski import illuminant


def estimate(view: View) -> Estimate:
    """Return the illuminant."""
    return illuminant(view, norm=5.0, sigma=2.0, order=1)


METHOD = Method("grey-edge", estimate)
