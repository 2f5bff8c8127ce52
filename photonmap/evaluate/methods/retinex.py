"""Retinex on grey values: large differences are reflectance, small ones shading.

Grosse, Johnson, Adelson and Freeman, "Ground truth dataset and baseline evaluations for intrinsic
image algorithms", ICCV 2009, after B. K. P. Horn, "Determining lightness from an image",
1974. With i = log I, the differences of log reflectance r are

    r_x = i_x where |i_x| > T, else 0

in both directions, and r is their least-squares solution, a Poisson equation. s = i − r.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import differences, integrate


def estimate(view: View, threshold: float) -> Estimate:
    """Return the decomposition for a threshold T of differences in log grey values."""
    down, right = (
        np.where(np.abs(difference) > threshold, difference, 0.0)
        for difference in differences(np.log(view.grey))
    )
    reflectance = np.exp(integrate(down, right, view.mask))
    return with_grey_shading(view, view.grey / reflectance)


METHOD = Method(
    "retinex",
    estimate,
    {"threshold": 0.1},
    tuple({"threshold": float(threshold)} for threshold in np.logspace(-3.0, 1.0, 15)),
)
"""The grid is that of the code of Grosse et al."""
