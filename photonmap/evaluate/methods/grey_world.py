"""The illuminant by the assumption that scenes are grey on average.

G. Buchsbaum, "A spatial processor model for object colour perception", Journal of the Franklin
Institute 310(1), 1980: ∫ f dx = k e.
"""

from __future__ import annotations

from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.methods.minkowski import illuminant


def estimate(view: View) -> Estimate:
    """Return the illuminant."""
    return illuminant(view, norm=1.0)


METHOD = Method("grey-world", estimate)
