"""The illuminant from Minkowski norms of an image or of its derivatives.

J. van de Weijer, T. Gevers and A. Gijsenij, "Edge-based color constancy", IEEE TIP 16(9), 2007:

    (∫ |∂ⁿ f_σ / ∂xⁿ|^p dx)^(1/p) = k e

for images f_σ smoothed by a Gaussian, of which n = 0 or 1 derivatives are taken; e is the
illuminant, k any factor.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.metrics.arrays import Floats, blurred_within


def illuminant(view: View, norm: float, sigma: float = 0.0, order: int = 0) -> Estimate:
    """Return the illuminant for a norm p, a smoothing σ in pixels and a number n of derivatives.

    Pixels that are not valid are not counted, and filled with what surrounds them before σ is
    applied.
    """
    values = np.maximum(view.image, 0.0)
    if order:
        means = blurred_within(values, view.mask, sigma, mode="nearest")
        filled = np.where(view.mask[..., None], values, means)
        values = _gradient_length(filled, sigma)
    counted = values[view.mask]
    largest = counted.max(axis=0)
    if math.isinf(norm):
        return Estimate(illuminant=largest)
    scaled = counted / np.where(largest > 0.0, largest, 1.0)
    return Estimate(illuminant=largest * np.mean(scaled**norm, axis=0) ** (1.0 / norm))


def _gradient_length(values: Floats, sigma: float) -> Floats:
    """Return the length of the gradient of each band of a smoothed image."""
    from scipy.ndimage import gaussian_filter

    down, right = (
        gaussian_filter(values, sigma, order=order, axes=(0, 1), mode="nearest")
        for order in ((1, 0), (0, 1))
    )
    return np.hypot(down, right)


METHODS = (
    Method("grey-world", partial(illuminant, norm=1.0)),
    Method("white-patch", partial(illuminant, norm=math.inf)),
    Method("shades-of-grey", partial(illuminant, norm=6.0)),
    Method("grey-edge", partial(illuminant, norm=5.0, sigma=2.0, order=1)),
)
"""What each assumes:

- grey-world: scenes are grey on average. G. Buchsbaum, "A spatial processor model for object colour
  perception", Journal of the Franklin Institute 310(1), 1980: ∫ f dx = k e
- white-patch: the brightest value of each band is white. E. H. Land and J. J. McCann, "Lightness
  and Retinex theory", JOSA 61(1), 1971, in the form of van de Weijer et al. 2007: max f = k e
- shades-of-grey: between these two. G. D. Finlayson and E. Trezzi, "Shades of gray and colour
  constancy", CIC 12, 2004: (∫ f^p dx)^(1/p) = k e, best for p = 6
- grey-edge: differences in a scene are grey on average. Van de Weijer et al. 2007: n = 1, with the
  p = 5 and σ = 2 pixels of the code they released
"""
