"""Retinex, by which large differences are reflectance, and the baselines that all or nothing is.

R. Grosse, M. K. Johnson, E. H. Adelson and W. T. Freeman, "Ground truth dataset and baseline
evaluations for intrinsic image algorithms", ICCV 2009:

- constant-reflectance: R = 1, S = I; constant-shading: R = I, S = 1
- retinex, after B. K. P. Horn, "Determining lightness from an image", 1974. With i = log I of grey
  values, the differences of log reflectance r are, in both directions,

      r_x = i_x where |i_x| > T, else 0

- color-retinex: i_x, a vector over bands, is projected onto the direction of equal bands
  (brightness, br) and onto its complement (chromaticity, chr). With i the log of the grey image,

      r_x = i_x where |i_x^br| > T^br or |i_x^chr| > T^chr, else 0

- weiss, on grey values as in Grosse et al.: Y. Weiss, "Deriving intrinsic images from image
  sequences", ICCV 2001, with the two filters f_n that are differences between neighbours. If
  filtered log shading is sparse, the maximum-likelihood estimate of filtered log reflectance is the
  median over images t, r_n = median_t (i(t) ∗ f_n). The paper writes the solution by the reversed
  filters

r is the least-squares solution of these differences, a Poisson equation, and s = i − r.
"""

from __future__ import annotations

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import differences, integrate
from photonmap.evaluate.metrics.arrays import Floats, to_grey

LEAST_LIGHTS = 2  # Least number of images of a view that weiss needs
_THRESHOLDS = tuple(float(threshold) for threshold in np.logspace(-1.5, 0.0, 5))


def retinex(view: View, threshold: float) -> Estimate:
    """Return the decomposition for a threshold T of differences in log grey values."""
    steps = differences(np.log(view.grey))
    return _integrated(view, *(np.where(np.abs(step) > threshold, step, 0.0) for step in steps))


def color_retinex(view: View, grey: float, color: float) -> Estimate:
    """Return the decomposition for thresholds T^br, of the mean over bands, and T^chr."""
    return _integrated(view, *edge_steps(view.image, np.log(view.grey), grey, color))


def edge_steps(image: Floats, log_grey: Floats, grey: float, color: float) -> list[Floats]:
    """Return the differences of log grey values downwards and to the right, 0 but at edges.

    There, the differences of the image (H, W, C) exceed T^br or T^chr; log grey values are (H, W).
    """
    steps = []
    bands = differences(np.log(np.maximum(image, FLOOR)))
    for band, step in zip(bands, differences(log_grey), strict=True):
        brightness = band.mean(axis=-1)
        chromaticity = np.linalg.norm(band - brightness[..., None], axis=-1)
        is_edge = (np.abs(brightness) > grey) | (chromaticity > color)
        steps.append(np.where(is_edge, step, 0.0))
    return steps


def weiss(view: View) -> Estimate:
    """Return the decomposition of one image of a sequence; of a single one, an `InputError`."""
    if len(view.relit) < LEAST_LIGHTS:
        raise InputError("weiss needs the view in two or more lights; there is one")
    filtered = [differences(np.log(np.maximum(to_grey(image), FLOOR))) for image in view.relit]
    return _integrated(view, *(_median(np.stack(parts)) for parts in zip(*filtered, strict=True)))


def _median(filtered: Floats) -> Floats:
    """Return the median over images that are valid, 0 where none is."""
    known = np.where(np.isnan(filtered).all(axis=0), 0.0, filtered)
    return np.asarray(np.nanmedian(known, axis=0))


def _integrated(view: View, down: Floats, right: Floats) -> Estimate:
    """Return the decomposition whose log reflectance has these differences."""
    return with_grey_shading(view, view.grey / np.exp(integrate(down, right, view.mask)))


METHODS = (
    Method("constant-reflectance", lambda view: Estimate(np.ones_like(view.image), view.image)),
    Method("constant-shading", lambda view: Estimate(view.image, np.ones_like(view.image))),
    Method(
        "retinex",
        retinex,
        {"threshold": 0.1},
        tuple({"threshold": float(threshold)} for threshold in np.logspace(-3.0, 1.0, 15)),
    ),
    Method(
        "color-retinex",
        color_retinex,
        {"grey": 0.1, "color": 0.1},
        tuple({"grey": grey, "color": color} for grey in _THRESHOLDS for color in _THRESHOLDS),
    ),
    Method("weiss", weiss),
)
"""The grids are those of the code of Grosse et al."""
