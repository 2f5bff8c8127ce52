"""The illuminant between grey world and white patch: the Minkowski norm of p = 6.

G. D. Finlayson and E. Trezzi, "Shades of gray and colour constancy", CIC 12, 2004:
(∫ f^p dx)^(1/p) = k e, best for p = 6.
"""

from __future__ import annotations

from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.methods.minkowski import illuminant


def estimate(view: View) -> Estimate:
    """Return the illuminant."""
    return illuminant(view, norm=6.0)


METHOD = Method("shades-of-grey", estimate)
