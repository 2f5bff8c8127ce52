"""The illuminant from Minkowski norms of an image or its derivatives, common to four methods.

J. van de Weijer, T. Gevers and A. Gijsenij, "Edge-based color constancy", IEEE TIP 16(9), 2007:

    (∫ |∂ⁿ f_σ / ∂xⁿ|^p dx)^(1/p) = k e

for images f_σ smoothed by a Gaussian, of which n = 0 or 1 derivatives are taken; e is the
illuminant, k any factor.
"""

from __future__ import annotations

import math

import numpy as np

from photonmap.evaluate.methods.method import Estimate, View
from photonmap.evaluate.metrics.arrays import Floats, Mask


def illuminant(view: View, norm: float, sigma: float = 0.0, order: int = 0) -> Estimate:
    """Return the illuminant for a norm p, a smoothing σ in pixels and a number n of derivatives.

    Pixels that are not valid are not counted, and filled with what surrounds them before σ is
    applied.
    """
    values = np.maximum(view.image, 0.0)
    if order:
        values = _gradient_length(_filled(values, view.mask, sigma), sigma)
    counted = values[view.mask]
    largest = counted.max(axis=0)
    if math.isinf(norm):
        return Estimate(illuminant=largest)
    scaled = counted / np.where(largest > 0.0, largest, 1.0)
    return Estimate(illuminant=largest * np.mean(scaled**norm, axis=0) ** (1.0 / norm))


def _filled(values: Floats, mask: Mask, sigma: float) -> Floats:
    """Return an image whose invalid pixels have the Gaussian mean of valid ones around them."""
    if mask.all():
        return values
    from scipy.ndimage import gaussian_filter

    inside = mask[..., None].astype(np.float64)
    near = gaussian_filter(values * inside, sigma, axes=(0, 1), mode="nearest")
    weight = gaussian_filter(inside, sigma, axes=(0, 1), mode="nearest")
    means = np.divide(near, weight, where=weight > 0.0, out=np.zeros_like(near))
    return np.where(mask[..., None], values, means)


def _gradient_length(values: Floats, sigma: float) -> Floats:
    """Return the length of the gradient of each band of a smoothed image."""
    from scipy.ndimage import gaussian_filter

    down, right = (
        gaussian_filter(values, sigma, order=order, axes=(0, 1), mode="nearest")
        for order in ((1, 0), (0, 1))
    )
    return np.hypot(down, right)
