"""Colour Retinex: differences in brightness or in colour that are large are reflectance.

Grosse, Johnson, Adelson and Freeman, "Ground truth dataset and baseline evaluations for intrinsic
image algorithms", ICCV 2009. Differences i_x of log I, a vector over bands, are
projected onto the direction of equal bands (brightness, br) and onto its complement (chromaticity,
chr). With i the log of the grey image, those of log reflectance are

    r_x = i_x where |i_x^br| > T^br or |i_x^chr| > T^chr, else 0

and r is their least-squares solution. s = i − r.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import differences, integrate
from photonmap.evaluate.metrics.arrays import Floats, Mask


def estimate(view: View, grey: float, color: float) -> Estimate:
    """Return the decomposition for thresholds T^br, of the mean over bands, and T^chr."""
    edges = reflectance_edges(view.image, grey, color)
    down, right = (
        np.where(edge, difference, 0.0)
        for edge, difference in zip(edges, differences(np.log(view.grey)), strict=True)
    )
    reflectance = np.exp(integrate(down, right, view.mask))
    return with_grey_shading(view, view.grey / reflectance)


def reflectance_edges(image: Floats, grey: float, color: float) -> tuple[Mask, Mask]:
    """Return where differences downwards and to the right are reflectance, for both thresholds."""
    down, right = differences(np.log(np.maximum(image, FLOOR)))
    return _is_reflectance(down, grey, color), _is_reflectance(right, grey, color)


def _is_reflectance(bands: Floats, grey: float, color: float) -> Mask:
    """Return where differences (H, W, C) exceed a threshold."""
    brightness = bands.mean(axis=-1)
    chromaticity = np.linalg.norm(bands - brightness[..., None], axis=-1)
    return (np.abs(brightness) > grey) | (chromaticity > color)


_THRESHOLDS = tuple(float(threshold) for threshold in np.logspace(-1.5, 0.0, 5))
METHOD = Method(
    "color-retinex",
    estimate,
    {"grey": 0.1, "color": 0.1},
    tuple({"grey": grey, "color": color} for grey in _THRESHOLDS for color in _THRESHOLDS),
)
"""The grid is that of the code of Grosse et al."""
