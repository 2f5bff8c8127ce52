"""Chromatic adaptation: what is white under a light becomes white on the screen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.spectra.observer import observer

Floats = NDArray[np.float64]

_CAT16 = np.array(
    [
        [0.401288, 0.650173, -0.051461],
        [-0.250268, 1.204414, 0.045854],
        [-0.002079, 0.048952, 0.953127],
    ]
)
"""From XYZ to the responses of cones."""
_MOST = 5.0
"""Ratio of the responses of two cones, relative to those to D65, above which a light is too
saturated to be anybody's white: of a black body of 2856 K it is 3.1, of a candle 7, of the
primaries of sRGB 5.6 to 13."""


def adapt_to_d65(white: Floats) -> Floats:
    """Return the matrix that turns a white into D65 of the same luminance, for linear sRGB.

    Full adaptation by von Kries' rule, in the cone responses of CAT16: C. Li et al.,
    "Comprehensive color solutions: CAM16, CAT16, and CAM16-UCS", Color Research and Application
    42(6), 2017.

    Parameters
    ----------
    white : (3,) linear sRGB

    Returns
    -------
    (3, 3) float64; the identity if `white` is black, or too saturated to be taken for white
    """
    to_xyz = observer().rgb_to_xyz
    to_cones = _CAT16 @ to_xyz
    luminance = to_xyz[1] @ white
    relative = to_cones @ white / to_cones.sum(axis=1)
    if not 0.0 < relative.max() <= _MOST * relative.min():
        return np.eye(3)
    return np.linalg.solve(to_cones, (luminance / relative)[:, None] * to_cones)
