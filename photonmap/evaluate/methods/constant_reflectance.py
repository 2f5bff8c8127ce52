"""The baseline that all of an image is shading.

Grosse, Johnson, Adelson and Freeman, "Ground truth dataset and baseline evaluations for intrinsic
image algorithms", ICCV 2009: R = 1, S = I.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import Estimate, Method, View


def estimate(view: View) -> Estimate:
    """Return a reflectance of 1, and the image as shading."""
    return Estimate(np.ones_like(view.image), view.image)


METHOD = Method("constant-reflectance", estimate)
