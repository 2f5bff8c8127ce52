"""How linear RGB is shown as 8-bit sRGB."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.images import encode_srgb

_LUMINANCE = np.array(LUMINANCE)
_PERCENTILE, _SHOWN_AS = 99.0, 0.8  # of the luminance, and the linear value a preview gives it


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
