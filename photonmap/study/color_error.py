"""Colour errors of too few bands: an image of N bands against one of many.

Both are projected to XYZ or linear sRGB as the renderer does. With equal seeds and passes they
share their noise, so that their difference is due to the bands alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.results.result import Result
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer
from photonmap.study.metrics import Floats, Mask, relative_distance

REFERENCE_BANDS = "81"
"""Bands of the images that are taken as true."""

_WHITE = 99.0  # percentile of the true luminance that is taken as white


@dataclass(frozen=True)
class ColorError:
    """Colour errors of an image of N bands against one of many.

    Parameters
    ----------
    delta_mean, delta_p95 : ΔE2000 of radiance, mean and 95th percentile over pixels
    indirect_mean, indirect_p95 : the same for indirect light alone
    luminance : relative error of the luminance Y of radiance
    radiance, shading, indirect : relative distances in XYZ
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
    """Compare a result with one of more bands and equal seed and passes, over valid pixels."""
    radiance, indirect = (
        _summary(
            delta_e_2000(result.rgb(buffer, white="D65"), truth.rgb(buffer, white="D65"))[mask]
        )
        for buffer in ("radiance", "indirect")
    )
    distances = {
        buffer: relative_distance(result.xyz(buffer)[mask], truth.xyz(buffer)[mask])
        for buffer in ("radiance", "shading", "indirect")
    }
    luminance = relative_distance(result.xyz()[mask][:, 1:2], truth.xyz()[mask][:, 1:2])
    return ColorError(*radiance, *indirect, luminance, **distances)


def delta_e_2000(
    image: NDArray[np.floating], truth: NDArray[np.floating], white: float | None = None
) -> Floats:
    """Return ΔE2000 of each pixel; white is D65.

    Parameters
    ----------
    image, truth : (..., 3) linear sRGB; if the truth is black, all differences are 0
    white : luminance of white; None takes the 99th percentile of the true luminance
    """
    to_xyz = observer().rgb_to_xyz
    if white is None:
        white = float(np.percentile(truth @ to_xyz[1], _WHITE))
    if white <= 0.0:
        return np.zeros(truth.shape[:-1])
    with colour_science() as colour:
        labs = [colour.XYZ_to_Lab(rgb / white @ to_xyz.T) for rgb in (image, truth)]
        return np.asarray(colour.delta_E(*labs, method="CIE 2000"))


def _summary(deltas: Floats) -> tuple[float, float]:
    """Return the mean and the 95th percentile."""
    return float(deltas.mean()), float(np.percentile(deltas, 95.0))
