"""Sensitivity curves: Gaussians and boxes over equal bins, and sensors of a file or by name."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, warn
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.spectra import names
from photonmap.spectra.curves import EXTRAPOLATE, FILES, VISIBLE, Spectrum, merge_grids
from photonmap.spectra.tables import read_table

MOST = 256  # Largest number of bands
ENDS = (280.0, 800.0)  # Between which bands lie, nm: visible light, and ultraviolet of sunlight

Limits = tuple[float, float]
STEPS = re.compile(r" *([\d.]+ *:){2} *[\d.]+ *")  # The text of bands in steps: first, last, step

BEST = {
    3: (0.269, 1.0),
    4: (0.388, 0.812),
    5: (0.287, 0.825),
    6: (0.269, 0.825),
    7: (0.25, 0.838),
    8: (0.244, 0.988),
    9: (0.244, 0.863),
    10: (0.237, 0.925),
    11: (0.175, 0.938),
    12: (0.181, 0.925),
}
"""By the number of bands: σ, and the distance between centres, both in widths of the equal bins.

Those with the least mean ΔE2000 after two bounces and regression, over the Munsell chips that are
shipped and under D65, as `photonmap.sensors.comparison` finds them for 400 to 700 nm.
"""

_CUT = 8.0  # σ from the centre, where a Gaussian has fallen to 1e-14 of its peak and is truncated
_NOISE = 0.02  # of a sensor's peak: how far below 0 a measured curve may dip


def gaussians(n: int, low: float, high: float, sigma: float | None) -> tuple[list[Spectrum], float]:
    """Return `n` curves, each centred on its bin, and their σ (nm): a quarter of the bin."""
    bin_width = _bin_width(n, low, high)
    sigma = bin_width / 4.0 if sigma is None else float(sigma)
    if not 0.01 <= sigma <= high - low:
        raise InputError(
            f"σ is {sigma:g} nm; keep it between 0.01 and the range of the bands, {high - low:g}"
        )
    steps = 2 * int(np.ceil(max(2.0 * bin_width / sigma, bin_width / 2.0)))  # 1 nm, σ/4 or less
    wavelengths = np.linspace(low, high, n * steps + 1)
    curves = []
    for centre in wavelengths[steps // 2 :: steps]:
        z = np.abs(wavelengths - centre) / sigma
        near = np.flatnonzero(z < _CUT)
        support = slice(max(near[0] - 1, 0), near[-1] + 2)
        curve = np.where(z < _CUT, np.exp(-0.5 * np.minimum(z, _CUT) ** 2), 0.0)
        curves.append(Spectrum(wavelengths[support], curve[support]))
    return curves, sigma


def spread_gaussians(
    count: int, low: float, high: float, width: float, spread: float
) -> list[Spectrum]:
    """Return Gaussians whose centres are moved towards the middle of the range or away.

    `low` and `high`, nm, are where the curves are truncated; `width` (σ) and `spread` (the distance
    between centres) count in widths of a bin, (high − low) / N.
    """
    size, middle = (high - low) / count, (low + high) / 2.0
    centres = middle + spread * size * (np.arange(count) - (count - 1) / 2.0)
    sigma = width * size
    wavelengths = np.linspace(low, high, 1 + int(np.ceil((high - low) / min(1.0, sigma / 4.0))))
    z = (wavelengths - centres[:, None]) / sigma
    curves = np.where(np.abs(z) < _CUT, np.exp(-0.5 * z * z), 0.0)
    return [Spectrum(wavelengths, curve) for curve in curves]


def boxes(n: int, low: float, high: float) -> list[Spectrum]:
    """Return `n` curves, each constant over its bin."""
    _bin_width(n, low, high)
    edges = np.linspace(low, high, n + 1)
    return [Spectrum(edges[k : k + 2], np.ones(2)) for k in range(n)]


def stepped(first: float, last: float, step: float) -> tuple[list[Spectrum], float, float]:
    """Return Gaussians around first, first + step, … last, and the range of all, nm.

    Each is symmetric, so that its mean is where it is centred.
    """
    count = round((last - first) / step) + 1 if step > 0.0 else 0
    if count < 1 or abs(first + (count - 1) * step - last) > 1e-9 * last:
        raise InputError(
            f"bands {first:g}:{last:g}:{step:g}: steps must lead from the first wavelength to the "
            "last, as in 400:700:10"
        )
    low, high = first - 0.5 * step, last + 0.5 * step
    if not ENDS[0] <= low < high <= ENDS[1]:
        raise InputError(
            f"bands {first:g}:{last:g}:{step:g} reach from {low:g} to {high:g} nm, half a step "
            f"beyond their ends; they must lie within {ENDS[0]:g} to {ENDS[1]:g} nm"
            + _steps_within(first, last, step)
        )
    _bin_width(count, low, high)
    half = int(np.ceil(max(step / 2.0, 8.0)))  # samples on either side: 1 nm, σ/4 or less
    z = np.arange(-half, half + 1) / half
    curve = np.exp(-0.5 * (2.0 * z) ** 2)
    centers = first + step * np.arange(count)
    return [Spectrum(center + 0.5 * step * z, curve) for center in centers], low, high


def _steps_within(first: float, last: float, step: float) -> str:
    """Return a remedy for steps that leave `ENDS`; "" where not even one fits."""
    start = max(first, ENDS[0] + 0.5 * step)
    more = np.floor((min(last, ENDS[1] - 0.5 * step) - start) / step + 1e-9)
    return "" if more < 0 else f", as {start:g}:{start + more * step:g}:{step:g} do"


def sensor(curve: Spectrum, label: str, limits: Limits | None) -> Spectrum:
    """Return a sensitivity truncated to the range and to its support, or raise `InputError`."""
    if not isinstance(curve, Spectrum):
        remedy = "give each channel as a photonmap.Spectrum, in nm"
        raise InputError(f"{label}: {shown(curve)} is not a curve; {remedy}")
    curve.check_covers(*(limits or VISIBLE))
    lowest, peak = curve.values.min(), curve.values.max()
    if lowest < -_NOISE * peak:
        at = curve.wavelengths[np.argmin(curve.values)]
        raise InputError(
            f"{label}: sensitivity is {lowest:.6g} at {at:g} nm; keep it at 0 or above"
        )
    if lowest < 0.0:
        warn(
            f"{label}: sensitivity dips to {lowest:.3g}, {-lowest / peak:.2%} of its peak; set to 0"
        )
    low, high = limits or curve.wavelengths[[0, -1]]
    inside = (curve.wavelengths > low) & (curve.wavelengths < high)
    grid = merge_grids(np.array([low, high]), curve.wavelengths[inside])
    values = np.maximum(curve(grid), 0.0)
    nonzero = np.flatnonzero(values)
    if not nonzero.size:
        raise InputError(f"{label}: is 0 from {low:g} to {high:g} nm; widen the range")
    support = slice(max(nonzero[0] - 1, 0), nonzero[-1] + 2)
    return Spectrum(grid[support], values[support])


def table_of(text: str) -> Path | None:
    """Return the file that a text names; None if it is the name of an observer or a camera."""
    path = Path(text.strip().removeprefix(EXTRAPOLATE).strip())
    return path if path.suffix.lower() in FILES else None


def check_camera(text: str) -> str:
    """Return the name of a known camera or observer; files and bands are not looked at."""
    body = text.strip().removeprefix(EXTRAPOLATE).strip()
    is_bands = ":" in body or body.isdecimal() or body.lower() == "rgb"
    if table_of(body) is not None or is_bands:
        return text
    try:
        names.sensors(body)
    except InputError:
        known = names.sensor_names()
        meant = suggest(body, known)
        others = f" Known are {listed(known, len(known))};" if "?" in meant else ";"
        raise InputError(
            f"{shown(body)} is not known; {meant}{others} or give a FILE.csv of sensitivities"
        ) from None
    return text


def read_sensors(text: str) -> tuple[list[str], list[Spectrum]]:
    """Return the names of channels, and their curves in the source's unit.

    The text is a FILE.csv, the name of an observer or a camera, or "best:6" for the best six
    Gaussians; what cannot be read is an `InputError`.
    """
    body, path = text.strip(), table_of(text)
    held = body.startswith(EXTRAPOLATE)
    if path is not None:
        table = read_table(path, kind="sensitivity")
        pairs = list(zip(table.names, table, strict=True))
    else:
        name = body.removeprefix(EXTRAPOLATE).strip()
        kind, _, number = name.partition(":")
        pairs = _best(number.strip()) if kind == "best" else list(names.sensors(name))
    curves = [replace(curve, extrapolate=held) for _, curve in pairs]
    return [name for name, _ in pairs], curves


def _best(text: str) -> list[tuple[str, Spectrum]]:
    """Return the best Gaussians for a number of bands, see `BEST`, by their mean wavelengths."""
    count = int(text) if text.isdecimal() else 0
    if count not in BEST:
        raise InputError(
            f"the best bands are tabulated for {min(BEST)} to {max(BEST)} bands; got {text!r}; "
            "`python -m photonmap sensors --best` finds others"
        )
    curves = spread_gaussians(count, *VISIBLE, *BEST[count])
    means = [float(each.wavelengths @ each.values / each.values.sum()) for each in curves]
    return [(f"{mean:.1f}nm", each) for mean, each in zip(means, curves, strict=True)]


def _bin_width(n: int, low: float, high: float) -> float:
    """Return the width of each of `n` bins, or raise `InputError`."""
    if not 1 <= n <= MOST:
        raise InputError(f"the number of bands must be from 1 to {MOST}; got {n}")
    if not ENDS[0] <= low < high <= ENDS[1]:
        raise InputError(
            f"the range of the bands must lie within {ENDS[0]:g} to {ENDS[1]:g} nm, the lower end "
            f"first; got {low:g} to {high:g}"
        )
    if high - low < n:
        raise InputError(
            f"{n} bands in {low:g} to {high:g} nm are narrower than 1 nm; "
            "use fewer bands or a wider range"
        )
    return (high - low) / n
