"""The baseline that all of an image is reflectance.

Grosse, Johnson, Adelson and Freeman, "Ground truth dataset and baseline evaluations for intrinsic
image algorithms", ICCV 2009: R = I, S = 1.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import Estimate, Method, View


def estimate(view: View) -> Estimate:
    """Return the image as reflectance, and a shading of 1."""
    return Estimate(view.image, np.ones_like(view.image))


METHOD = Method("constant-shading", estimate)
