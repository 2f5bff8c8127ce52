"""Weiss's intrinsic images of a sequence: reflectance from medians of differences over lights.

Y. Weiss, "Deriving intrinsic images from image sequences", ICCV 2001, with the two filters f_n that
are differences between neighbours. If filtered log shading is sparse, the estimate of filtered log
reflectance is the median over images t,

    r_n = median_t (i(t) ∗ f_n)

the maximum-likelihood estimate, and r is the least-squares solution of r ∗ f_n = r_n, which the
paper writes by the reversed filters. s(t) = i(t) − r. As in Grosse et al. 2009, on grey values.
"""

from __future__ import annotations

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import differences, integrate
from photonmap.evaluate.metrics.arrays import Floats, to_grey

LEAST_LIGHTS = 2
"""Least number of images of a view."""


def estimate(view: View) -> Estimate:
    """Return the decomposition of one image of a sequence.

    Raises
    ------
    InputError : the scene was rendered in one light only
    """
    if len(view.relit) < LEAST_LIGHTS:
        raise InputError("weiss needs the view in two or more lights; there is one")
    filtered = [differences(np.log(np.maximum(to_grey(image), FLOOR))) for image in view.relit]
    down, right = (_median(np.stack(parts)) for parts in zip(*filtered, strict=True))
    reflectance = np.exp(integrate(down, right, view.mask))
    return with_grey_shading(view, view.grey / reflectance)


def _median(filtered: Floats) -> Floats:
    """Return the median over images that are valid, 0 where none is."""
    known = np.where(np.isnan(filtered).all(axis=0), 0.0, filtered)
    return np.asarray(np.nanmedian(known, axis=0))


METHOD = Method("weiss", estimate)
