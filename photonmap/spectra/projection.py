"""From N bands to RGB spaces, XYZ or any camera, by colorimetric integration or by regression."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from photonmap.errors import InputError
from photonmap.runtime.wording import shown, suggest
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import (
    Color,
    Floats,
    Spectrum,
    SpectrumSet,
    integrate_products,
    read_only,
    resample,
)
from photonmap.spectra.observer import emission_spectrum, observer

Target = Bands | Literal["rgb", "xyz"]
Method = Literal["direct", "primaries", "regression"]

SRGB, REC2020 = "srgb", "rec2020"
_D65, _ACES = None, (0.32168, 0.33767)
_PRIMARIES = {
    REC2020: (((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)), _D65),
    "aces-ap0": (((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.0770)), _ACES),
    "aces-ap1": (((0.713, 0.293), (0.165, 0.830), (0.128, 0.044)), _ACES),
}
"""Chromaticities of red, green, blue and white; None for the white of sRGB, D65.

Of ITU-R BT.2020-2, SMPTE ST 2065-1 and ACES S-2014-004.
"""
SPACES = (SRGB, *_PRIMARIES, "xyz")
"""Names of the spaces; instead of one, a camera or FILE.csv may be given."""

_CHIPS = 128  # of the training set; all their ordered pairs are the colours after two bounces
_TRAINING_LIGHTS = ("1", "D65", "A")
_RIDGE = 0.01  # of the mean square of a band


@dataclass(frozen=True, eq=False)
class Projection:
    """A linear map from band radiances to the values of other sensors.

    `matrix`, (T, N), times band values are the values of T sensors. `residual` are the fit's errors
    over the colours that it was trained on, after one and after two bounces: root mean square error
    over root mean square; None without a fit.
    """

    matrix: Floats
    residual: tuple[float, float] | None = None


def choose_projection(bands: Bands, target: Target, method: Method) -> Projection:
    """Return the projection of a method onto "rgb", "xyz" or other bands.

    "direct" is `direct_projection`, "primaries" `primaries_projection`, "regression"
    `fit_projection` to the Munsell chips under equal energy, D65 and A. Others are an `InputError`.
    """
    if not isinstance(target, Bands) and target not in ("rgb", "xyz"):
        raise InputError(f"there is no target {shown(target)}; give 'rgb', 'xyz' or Bands")
    if method not in _METHODS:
        raise InputError(f"there is no method {shown(method)}; {suggest(str(method), _METHODS)}")
    return _METHODS[method](bands, target)


def default_method(has_spectra: bool) -> Method:
    """Return the method for a scene, by whether any of its colours is a spectrum."""
    return "direct" if has_spectra else "primaries"


@cache
def direct_projection(bands: Bands, target: Target) -> Projection:
    """Integrate the smoothest spectra that have the bands' values over the target's curves.

    The smoothest has the least ∫ s'² dλ of all whose averages over the bands are those given:
    between sharp bands it is linear, and constant beyond the outer ones. Towards RGB and XYZ each
    channel is then scaled to see D65 as white. From RGB to other sensors the spectra are those that
    RGB emission stands for. A target of the bands of RGB, which have no sensitivities, is an
    `InputError`.
    """
    if isinstance(target, Bands):
        return Projection(read_only(target.average_all(*smoothest_spectra(bands)).T))
    if bands.is_rgb:
        return _from_rgb(target, np.eye(3))
    eye = observer()
    grid, curves = smoothest_spectra(bands)
    matrix = integrate_products(eye.wavelengths, eye.matching, grid, curves)
    white = bands.average_all(eye.wavelengths, eye.d65[None])[0]
    return _from_rgb(target, matrix / (matrix @ white)[:, None])


@cache
def primaries_projection(bands: Bands, target: Target) -> Projection:
    """Correct `direct_projection` so that RGB emission returns to its RGB, and to its XYZ.

    So do RGB surfaces under D65. The correction is the smallest in the sum of squares: exact for
    N ≥ 3; for fewer bands white is exact, and the rest as near as can be. It is for scenes whose
    colours are RGB; measured spectra it takes farther from their colours. Other sensors know no
    primaries: towards them it is `direct_projection`.
    """
    if isinstance(target, Bands) or bands.is_rgb:
        return direct_projection(bands, target)
    direct = direct_projection(bands, "rgb").matrix
    return _from_rgb(target, direct + _correction(bands.emission_basis.T, direct))


def _from_rgb(target: Literal["rgb", "xyz"], to_rgb: Floats) -> Projection:
    return Projection(read_only(to_rgb if target == "rgb" else observer().rgb_to_xyz @ to_rgb))


def fit_projection(
    bands: Bands, target: Target, reflectances: SpectrumSet, illuminants: Iterable[Color]
) -> Projection:
    """Fit the linear map that comes closest to the target over rendered colours.

    The colours are those of reflectances under illuminants after one bounce, and of all their
    ordered pairs after two, both counting equally: their bands are multiplied as a render
    multiplies them, and the target's values are those of the products of the curves. So the fit
    compensates for part of the error of products of bands (S. Beigpour et al., "Intrinsic image
    evaluation on synthetic complex scenes", ICIP 2013). Of larger sets, 128 reflectances are taken,
    evenly; they cover 400 to 700 nm, and hold their outer values beyond. A ridge pulls towards
    `direct_projection` where the colours carry little information, and protects other colours and
    lights. RGB, which has no sensitivities, and no illuminant are an `InputError`.
    """
    if bands.is_rgb:
        raise InputError("RGB has no sensitivities to fit; choose a number of bands")
    curves = reflectances.values[:: -(-len(reflectances) // _CHIPS)]
    samples = [
        _colors(bands, target, reflectances.wavelengths, curves, emission_spectrum(light))
        for light in illuminants
    ]
    if not samples:
        raise InputError("a fit needs at least one illuminant; give one")
    once, twice = (
        [np.concatenate(rows) for rows in zip(*pairs, strict=True)]
        for pairs in zip(*samples, strict=True)
    )
    direct = direct_projection(bands, target).matrix
    weight = np.sqrt(len(twice[0]) / len(once[0]))
    inputs = np.concatenate([once[0] * weight, twice[0]])
    missing = np.concatenate([once[1] * weight, twice[1]]) - inputs @ direct.T
    gram = inputs.T @ inputs
    ridge = _RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram))
    matrix = direct + np.linalg.solve(gram + ridge, inputs.T @ missing).T
    return Projection(read_only(matrix), (_residual(matrix, *once), _residual(matrix, *twice)))


@cache
def _default_fit(bands: Bands, target: Target) -> Projection:
    """Fit to the Munsell chips under equal energy, D65 and A."""
    from photonmap.spectra.color_text import emission
    from photonmap.spectra.munsell import munsell_set

    return fit_projection(bands, target, munsell_set(), map(emission, _TRAINING_LIGHTS))


_METHODS: dict[str, Callable[[Bands, Target], Projection]] = {
    "direct": direct_projection,
    "primaries": primaries_projection,
    "regression": _default_fit,
}


def check_space(name: str) -> str:
    """Return the name of a space, camera or file of three sensitivities; refuse others."""
    if name not in SPACES:
        _camera(name)
    return name


def _camera(name: str) -> Bands:
    try:
        bands = Bands.parse(name)
    except InputError:
        bands = None
    if bands is None or bands.count != 3 or bands.is_rgb:
        nearest = suggest(name, SPACES)
        other = " " if nearest[-1] == "?" else ", or give "
        raise InputError(
            f"there is no RGB space {name!r}; {nearest}{other}the name of a camera, or a FILE.csv "
            "of three sensitivities"
        )
    return bands


@cache
def from_srgb(name: str) -> Floats:
    """Return the matrix (3, 3) from linear sRGB to a space; light is not adapted to its white."""
    if name == SRGB:
        return np.eye(3)
    to_xyz = observer().rgb_to_xyz
    if name == "xyz":
        return to_xyz
    primaries, white = _PRIMARIES[name]
    columns = np.array([_xyz(each) for each in primaries]).T
    light = to_xyz.sum(axis=1) if white is None else _xyz(white)
    columns = columns * np.linalg.solve(columns, light)
    return np.linalg.solve(columns, to_xyz)


def _xyz(chromaticity: tuple[float, float]) -> Floats:
    """Return the XYZ of a chromaticity at Y = 1; of one at y = 0, those of x + z alone."""
    x, y = chromaticity
    return np.array([x, y, 1.0 - x - y]) / (y if abs(y) > 1e-9 else 1.0)


def projection_onto(bands: Bands, name: str, method: Method | None) -> Floats:
    """Return the matrix (3, N) from the radiances of bands to a space or a camera.

    Bands that are the camera's own are taken as they are. The method is None for bands of RGB.
    """
    if name in SPACES:
        return from_srgb(name) @ choose_projection(bands, "rgb", method or "direct").matrix
    camera = _camera(name)
    if camera.describe() == bands.describe():
        return np.eye(3)
    return choose_projection(bands, camera, method or "direct").matrix


def _colors(
    bands: Bands, target: Target, wavelengths: Floats, curves: Floats, light: Spectrum
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return (band values, target values) after one bounce and after two, one row a colour."""
    lit = bands.average_all(light.wavelengths, light.values[None])[0]
    averages = bands.average_all(wavelengths, curves)
    pairs = (lit * averages[:, None] * averages).reshape(-1, bands.count)

    grid, sensors = _target_weights(target)
    chips = resample(grid, wavelengths, curves)
    once = (chips * light(grid)) @ sensors.T
    twice = np.stack([(chips * (light(grid) * sensor)) @ chips.T for sensor in sensors], axis=-1)
    return (lit * averages, once), (pairs, twice.reshape(-1, len(sensors)))


def _target_weights(target: Target) -> tuple[Floats, Floats]:
    """Return a grid (M,), nm, and (T, M) weights whose products with a curve are what it gives."""
    eye = observer()
    if not isinstance(target, Bands):
        curves = eye.matching if target == "rgb" else eye.rgb_to_xyz @ eye.matching
        return eye.wavelengths, curves  # zero at both ends, in steps of 1 nm
    if target.is_rgb:
        raise InputError("RGB has no sensitivities; name the target 'rgb'")
    return hat_averages(target)


def _residual(matrix: Floats, inputs: Floats, truths: Floats) -> float:
    return float(np.linalg.norm(inputs @ matrix.T - truths) / np.linalg.norm(truths))


def smoothest_spectra(bands: Bands) -> tuple[Floats, Floats]:
    """Return a grid (M,), nm, and curves (N, M): band values @ curves = the smoothest spectrum.

    For RGB it is that which RGB emission stands for. The minimum of ∫ s'² under linear constraints
    is a constant and a sum of the constraints' averages of −|λ − μ| whose weights add up to 0: G.
    Wahba, "Spline Models for Observational Data", 1990, section 1.3.
    """
    if bands.is_rgb:
        return observer().wavelengths, observer().basis * observer().d65
    grid, averages = hat_averages(bands)
    kernel = -np.abs(grid[:, None] - grid) @ averages.T
    n = bands.count
    system = np.ones((n + 1, n + 1))
    system[:n, :n], system[n, n] = averages @ kernel, 0.0
    weights = np.linalg.lstsq(system, np.eye(n + 1, n), rcond=1e-12)[0]
    return grid, (kernel @ weights[:n] + weights[n]).T


def hat_averages(bands: Bands) -> tuple[Floats, Floats]:
    """Return whole wavelengths (M,) over what the eye and the bands see, and weights (N, M).

    They are those of a piecewise-linear curve's samples in its averages over the bands.
    """
    low = min(380.0, *(curve.wavelengths[0] for curve in bands.sensitivities))
    high = max(780.0, *(curve.wavelengths[-1] for curve in bands.sensitivities))
    grid = np.arange(np.floor(low), np.ceil(high) + 1.0)
    weights = np.zeros((bands.count, len(grid)))
    for row, curve in zip(weights, bands.sensitivities, strict=True):
        first = np.searchsorted(grid, curve.wavelengths[0], "right") - 1
        last = np.searchsorted(grid, curve.wavelengths[-1], "left") + 1
        near, samples = grid[first:last], (curve.wavelengths, curve.values[None])
        row[first:last] = integrate_products(*samples, near, np.eye(len(near)))[0]
    return grid, weights


def _correction(emission: Floats, direct: Floats) -> Floats:
    """Return the least C (3, N) for which (direct + C) @ emission is the identity.

    White is met first, by a row vector along it; the rest at right angles to it, but for directions
    that the bands hardly see, as where all of them lie within the red.

    Parameters
    ----------
    emission : (N, 3) band radiances of red, green and blue
    direct : (3, N)
    """
    missing = np.eye(3) - direct @ emission
    white = emission.sum(axis=1)
    to_white = np.outer(missing.sum(axis=1), white / (white @ white))
    missing -= to_white @ emission
    others = np.linalg.qr(white[:, None], mode="complete")[0][:, 1:].T
    return to_white + missing @ np.linalg.pinv(others @ emission, rcond=0.02) @ others
