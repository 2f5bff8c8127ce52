"""What too few bands cost: an image of N bands against the same of many, seen by the eye.

Both are projected to XYZ or linear sRGB as the renderer does it. With the same seed and passes they
share their noise, so that what is left is the bands'.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.result import Result
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer
from photonmap.study.metrics import Floats, Mask, relative_distance

MANY = "81"
"""Bands that are taken for the truth."""

_WHITE = 99.0  # percentile of the truth's luminance that is shown as white


@dataclass(frozen=True)
class ColorError:
    """How far an image of N bands is from the truth of many.

    Parameters
    ----------
    delta_mean, delta_p95 : ΔE2000 of radiance, mean and 95th percentile over pixels
    indirect_mean, indirect_p95 : the same of indirect light alone
    luminance : relative error of radiance's Y
    radiance, shading, indirect : distances of XYZ, relative to its length
    """

    delta_mean: float
    delta_p95: float
    indirect_mean: float
    indirect_p95: float
    luminance: float
    radiance: float
    shading: float
    indirect: float


def color_error(result: Result, truth: Result, mask: Mask) -> ColorError:
    """Compare a result with one of more bands and the same seed and passes, where pixels count."""
    seen, lit = (
        _summary(differences(result.rgb(buffer), truth.rgb(buffer))[mask])
        for buffer in ("radiance", "indirect")
    )
    off = {
        buffer: relative_distance(result.xyz(buffer)[mask], truth.xyz(buffer)[mask])
        for buffer in ("radiance", "shading", "indirect")
    }
    luminance = relative_distance(result.xyz()[mask][:, 1:2], truth.xyz()[mask][:, 1:2])
    return ColorError(*seen, *lit, luminance, **off)


def differences(image: NDArray[np.floating], truth: NDArray[np.floating]) -> Floats:
    """Return ΔE2000 of each pixel: the brightest 1% of the truth's luminance is white, D65.

    Parameters
    ----------
    image, truth : (..., 3) linear sRGB; nothing differs from a truth that is black
    """
    to_xyz = observer().rgb_to_xyz
    white = np.percentile(truth @ to_xyz[1], _WHITE)
    if white <= 0.0:
        return np.zeros(truth.shape[:-1])
    with colour_science() as colour:
        labs = [colour.XYZ_to_Lab(seen / white @ to_xyz.T) for seen in (image, truth)]
        return np.asarray(colour.delta_E(*labs, method="CIE 2000"))


def _summary(deltas: Floats) -> tuple[float, float]:
    return float(deltas.mean()), float(np.percentile(deltas, 95.0))
