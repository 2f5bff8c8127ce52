"""How linear RGB is shown as 8-bit sRGB."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.color import LUMINANCE
from photonmap.spectra.rgb_spaces import encode_srgb

_LUMINANCE = np.array(LUMINANCE)
_PERCENTILE, _SHOWN_AS = 99.0, 0.8  # of the luminance, and the linear value a preview gives it
_KNEE, _BRIGHTEST = 0.5, 25.0
"""Where highlights begin to be compressed, and what is shown as 1, linear."""
_STEEPNESS = 5.62216
"""Root a of a = ln(1 + a (`_BRIGHTEST` - `_KNEE`) / (1 - `_KNEE`)): the slope at the knee is 1."""


class Preview(NamedTuple):
    """An 8-bit image and the exposure at which it shows radiance."""

    image: NDArray[np.uint8]
    """(H, W, 3) sRGB"""
    exposure: float


def choose_exposure(lines: Iterable[NDArray[Any]], emission: NDArray[Any] | None) -> float:
    """Return the factor by which the 99th percentile of the luminance becomes 0.8.

    Of the pixels that are not black; and not emissive, unless all the others are black. 1 if there
    is none. `lines` are of linear RGB, (W, 3) each; `emission` is (H, W, N).
    """
    luminance = np.stack([np.nan_to_num(line) @ _LUMINANCE for line in lines])
    counted = luminance > 0.0
    if emission is not None:
        lit = counted & ~emission.any(axis=-1)
        counted = lit if lit.any() else counted
    if not counted.any():
        return 1.0
    return float(_SHOWN_AS / np.percentile(luminance[counted], _PERCENTILE))


def as_bytes(lines: Iterable[NDArray[Any]], exposure: float) -> NDArray[np.uint8]:
    """Return lines × exposure, clamped to [0, 1], as 8-bit sRGB: (H, W, 3) uint8."""
    shown = []
    for line in lines:
        scaled = np.nan_to_num(line) * np.float64(exposure)
        shown.append(np.rint(255.0 * encode_srgb(np.clip(scaled, 0.0, 1.0))).astype(np.uint8))
    return np.stack(shown)


def with_highlights(image: NDArray[Any]) -> NDArray[np.float64]:
    """Return linear RGB, (H, W, 3), with what is brighter than 0.5 compressed as its logarithm.

    So a window, 5 to 20 times as bright as the wall beside it, shows the sky behind. The largest
    channel decides, so hues stay, and nothing below 25 is clipped.
    """
    largest = np.max(np.nan_to_num(image), axis=-1, keepdims=True)
    above = np.maximum(largest - _KNEE, 0.0) / (1.0 - _KNEE)
    shown = np.minimum(largest, _KNEE)
    shown = shown + (1.0 - _KNEE) * np.log1p(_STEEPNESS * above) / _STEEPNESS
    return image * np.divide(shown, largest, out=np.ones_like(shown), where=largest > 0.0)
