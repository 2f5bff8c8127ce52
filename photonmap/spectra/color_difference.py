"""CIE Lab and differences in it, ΔE2000, as colour-science computes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.spectra.curves import Floats
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer

_WHITE = 99.0  # Percentile of the true luminance that is taken as white


def lab_of_xyz(xyz: Floats, white: Floats | None = None) -> Floats:
    """Return CIE Lab (..., 3) of XYZ (..., 3) relative to a white (3,); None for D65 of Y = 1."""
    with colour_science() as colour:
        if white is None:
            return np.asarray(colour.XYZ_to_Lab(xyz))
        return np.asarray(colour.XYZ_to_Lab(xyz / white[1], colour.XYZ_to_xy(white)))


def lab_difference(first: Floats, second: Floats) -> Floats:
    """Return ΔE2000 of two colours in CIE Lab, (..., 3) each (Sharma, Wu and Dalal 2005)."""
    with colour_science() as colour:
        return np.asarray(colour.delta_E(first, second, method="CIE 2000"))


def delta_e_2000(
    image: NDArray[np.floating], truth: NDArray[np.floating], white: float | None = None
) -> Floats:
    """Return ΔE2000 of each pixel of linear sRGB, (..., 3); white is D65 of a luminance.

    None takes the 99th percentile of the true luminance. If the truth is black, all differences are
    0.
    """
    to_xyz = observer().rgb_to_xyz
    if white is None:
        white = float(np.percentile(truth @ to_xyz[1], _WHITE))
    if white <= 0.0:
        return np.zeros(truth.shape[:-1])
    return lab_difference(*(lab_of_xyz(rgb / white @ to_xyz.T) for rgb in (image, truth)))
