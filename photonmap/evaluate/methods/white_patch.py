"""The illuminant by the assumption that the brightest value of each band is white.

E. H. Land and J. J. McCann, "Lightness and Retinex theory", JOSA 61(1), 1971, in the form of van de
Weijer et al. 2007: max f = k e.
"""

from __future__ import annotations

import math

from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.methods.minkowski import illuminant


def estimate(view: View) -> Estimate:
    """Return the illuminant."""
    return illuminant(view, norm=math.inf)


METHOD = Method("white-patch", estimate)
