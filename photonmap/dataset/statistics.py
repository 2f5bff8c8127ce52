"""Numbers of one image that the report adds up: energy, histograms of reflectance and light."""

from __future__ import annotations

from typing import Any

import numpy as np

from photonmap.result import Result

BINS = 20


def summarise(result: Result, rgb: Result) -> dict[str, Any]:
    """Return an image's statistics, JSON-able.

    `direct_share` is r = Σ|direct| / Σ|direct + indirect| over pixels and bands, None without
    light. Histograms, over valid pixels, have `BINS` bins over [0, 1]: of reflectance, all bands
    counting alike, and of the illuminant's red and blue parts of R + G + B, where it has no
    negative part.

    Parameters
    ----------
    result : in its bands, with what `with_derived` adds
    rgb : the same in RGB
    """
    direct = result.direct.astype(np.float64)
    whole = float(np.abs(direct + result.indirect).sum())
    valid = result.buffers["valid"]
    light = rgb.buffers["illuminant"][valid]
    light = light[(light >= 0.0).all(axis=-1) & light.any(axis=-1)].astype(np.float64)
    parts = light / light.sum(axis=-1, keepdims=True)
    return {
        "direct_share": float(np.abs(direct).sum()) / whole if whole else None,
        "valid": float(valid.mean()),
        "reflectance": _histogram(result.reflectance[valid]),
        "illuminant_red": _histogram(parts[:, 0]),
        "illuminant_blue": _histogram(parts[:, 2]),
    }


def _histogram(values: Any) -> list[int]:
    return np.histogram(np.clip(values, 0.0, 1.0), BINS, (0.0, 1.0))[0].tolist()
