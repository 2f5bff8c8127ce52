"""From an image to its descriptors and the decomposition that they lead to."""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import neighbours
from photonmap.evaluate.methods.serra.field import Descriptors, log_reflectance
from photonmap.evaluate.methods.serra.names import memberships
from photonmap.evaluate.methods.serra.ridges import ridge_numbers
from photonmap.evaluate.metrics.arrays import Floats

_WHITE = 99.0
"""Percentile of grey values that names take for white."""


def estimate(view: View, tie: float) -> Estimate:
    """Return the decomposition for the weight λ of ties between pixels anywhere."""
    mask = view.mask
    grey = view.grey[mask]
    colors = _as_rgb(np.maximum(view.image[mask], FLOOR)) / np.percentile(grey, _WHITE)
    descriptors = Descriptors(ridge_numbers(colors), memberships(colors))
    log_image = np.log(grey)
    reflectance = log_reflectance(log_image, descriptors, neighbours(mask), tie)
    shading = np.ones(mask.shape)
    shading[mask] = np.exp(log_image - reflectance)
    return with_grey_shading(view, shading)


def _as_rgb(colors: Floats) -> Floats:
    """Return RGB (P, 3) of bands (P, C), which go from blue to red unless there are three."""
    bands = colors.shape[1]
    if bands == 3:
        return colors
    thirds = np.array_split(colors, 3, axis=1) if bands > 3 else [colors] * 3
    return np.stack([third.mean(axis=1) for third in reversed(thirds)], axis=1)


METHOD = Method("serra", estimate, {"tie": 0.3})
