"""How well N bands carry the luminance of lights, and weights that carry it exactly."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from photonmap.errors import warn
from photonmap.runtime.wording import enumerated, listed
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import VISIBLE, Color, Floats, Spectrum
from photonmap.spectra.observer import luminance, observer
from photonmap.spectra.projection import Method, choose_projection

MOST = 0.02
"""Error of a light's luminance above which photometric results warn."""
BY_BANDS = "luminance by these bands over the exact one"
"""How the warning of such lights begins."""
_BLUR, _MOVED = 20.0, 0.05
"""Width, nm, of the blur that moves more than this share of the light of a lamp with lines."""
_UNSEEN = 10.0  # Radiance over luminance from which on the eye hardly sees a lamp
_RCOND = 1e-3  # of lights whose bands are so alike that only huge weights would tell them apart


def describe_luminance(
    bands: Bands, lights: Iterable[tuple[str, Color]], method: Method
) -> list[dict[str, Any]]:
    """Return what the record says of the luminance of each light; those alike have one row.

    `names` are theirs, `ratio` is luminance by the bands over the exact one, `corrected` the same
    by `corrected_weights`, `bands` the band values (N,) at an exact luminance of 1, `lines` whether
    its spectrum has narrow lines that the eye sees.
    """
    rows: dict[tuple[float, ...], dict[str, Any]] = {}
    for name, color in lights:
        if (exact := luminance(color)) > 0.0:
            values = np.round(bands.emission(color) / exact, 12).tolist()
            row = rows.setdefault(tuple(values), {"names": [], "bands": values, "lines": False})
            row["names"] += [name] * (name not in row["names"])
            row["lines"] |= _has_lines(color) and float(np.mean(values)) < _UNSEEN
    found = list(rows.values())
    plain = luminance_weights(bands, method)
    corrected = corrected_weights(plain, found)
    for light in found:
        light["ratio"] = float(plain @ light["bands"])
        light["corrected"] = float(corrected @ light["bands"])
    return found


def _has_lines(color: Color) -> bool:
    """Return whether a spectrum has structure so narrow that a blur moves much of its light."""
    if not isinstance(color, Spectrum):
        return False
    values = color(np.arange(*VISIBLE))
    blurred = gaussian_filter1d(values, _BLUR / math.sqrt(8.0 * math.log(2.0)), mode="nearest")
    return bool(0.5 * np.abs(values - blurred).sum() > _MOVED * values.sum())


def luminance_weights(bands: Bands, method: Method) -> Floats:
    """Return the weights (N,) whose product with band radiances is Y."""
    matrix = choose_projection(bands, "rgb", method).matrix
    return np.asarray(observer().rgb_to_xyz[1] @ matrix)


def corrected_weights(weights: Floats, lights: Sequence[Mapping[str, Any]]) -> Floats:
    """Return the weights (N,) nearest to these by which each light has its exact luminance.

    By least squares where there are more lights than bands, or lights that these bands hardly tell
    apart: `corrected` in the record says what is left.
    """
    values = np.array([light["bands"] for light in lights])
    if not len(values):
        return weights
    lengths = np.maximum(np.linalg.norm(values, axis=1), 1e-30)  # infrared lamps have long rows
    missing = (1.0 - values @ weights) / lengths
    return np.asarray(weights + np.linalg.pinv(values / lengths[:, None], rcond=_RCOND) @ missing)


def warn_of_luminance(lights: Sequence[Mapping[str, Any]]) -> None:
    """Warn of lights whose luminance the bands miss by more than 2%, the worst first."""
    off = [light for light in lights if abs(light["ratio"] - 1.0) > MOST]
    off.sort(key=lambda light: -abs(light["ratio"] - 1.0))
    if off:
        stated = [
            f"{listed(light['names'])} {light['ratio']:.3f} (corrected {light['corrected']:.3f})"
            for light in off
        ]
        warn(
            f"{BY_BANDS}: {enumerated(stated)}; luminance() and illuminance() correct it for "
            "direct light and grey surfaces, rgb() and xyz() do not; narrower bands, as 400:700:5, "
            "are closer everywhere"
        )
