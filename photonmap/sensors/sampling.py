"""Sensitivities as quadratures: nodes and weights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum, SpectrumSet, check_covers, resample, without_tails

Floats = NDArray[np.float64]

STEP = 5.0
"""Distance of samples, nm. The paper gives none; `interreflection_errors` states its effect."""

FINE = 1.0
"""Distance of samples where no paper is followed, nm."""

_LOSS = 0.01
"""Largest error of a sum, relative to a sensitivity's integral."""


def trapezoid_weights(nodes: Floats) -> Floats:
    """Return w (M,) with w @ f = ∫ f for f that is linear between `nodes` (M,)."""
    steps = np.diff(nodes) / 2.0
    return np.append(steps, 0.0) + np.append(0.0, steps)


def sensitivity_nodes(curve: Spectrum, step: float = STEP) -> tuple[Floats, Floats]:
    """Return nodes where a sensitivity ρ is not 0, and weights w: w @ f ≈ ∫ ρ f by trapezoids.

    The nodes are the multiples of `step` between the two ends of ρ, and these ends, so that steep
    edges stay in place. Where the sum is off by more than 1% of ∫ ρ, as with narrow bands, the
    step is halved. The weights are scaled to sum to ∫ ρ.

    Parameters
    ----------
    curve : ρ, nm⁻¹
    step : largest distance of nodes, nm

    Returns
    -------
    nodes : (M,) float64, nm, increasing
    weights : (M,) float64
    """
    nonzero = np.flatnonzero(curve.values)
    support = slice(max(nonzero[0] - 1, 0), nonzero[-1] + 2)
    knots, integral = curve.wavelengths[support], np.trapezoid(curve.values, curve.wavelengths)
    nodes = _grid(knots[0], knots[-1], step)
    weights = trapezoid_weights(nodes) * curve(nodes)
    if abs(weights.sum() - integral) > _LOSS * integral:
        return sensitivity_nodes(curve, step / 2.0)
    return nodes, weights * (integral / weights.sum())


def _grid(low: float, high: float, step: float) -> Floats:
    """Return the multiples of `step` within both ends, and the ends."""
    inside = np.arange(np.floor(low / step) + 1.0, np.ceil(high / step)) * step
    return np.concatenate([[low], inside, [high]])


def band_values(
    bands: Bands, reflectances: SpectrumSet, illuminant: Spectrum, step: float = STEP
) -> tuple[Floats, Floats]:
    """Return the band values of reflectances, R (C, N), and of the illuminant, E (N,).

    Raises
    ------
    InputError
        if a curve does not cover the bands
    """
    reflected, emitted = [], []
    for sensitivity in bands.sensitivities:
        weights, curves, light = sample_band(sensitivity, reflectances, illuminant, step)
        reflected.append(curves @ weights)
        emitted.append(weights @ light)
    return np.array(reflected).T, np.array(emitted)


def sample_band(
    sensitivity: Spectrum, reflectances: SpectrumSet, illuminant: Spectrum, step: float = STEP
) -> tuple[Floats, Floats, Floats]:
    """Return the weights (M,) of `sensitivity_nodes`, and reflectances (C, M) and light (M,) there.

    As in a render, curves keep their outer values in the tails of the sensitivity.

    Raises
    ------
    InputError
        if a curve does not cover what the band sees but for a thousandth at either end
    """
    nodes, weights = sensitivity_nodes(sensitivity, step)
    seen = without_tails(sensitivity)
    check_covers(reflectances.wavelengths, *seen)
    illuminant.check_covers(*seen)
    curves = resample(nodes, reflectances.wavelengths, reflectances.values)
    return weights, curves, illuminant(nodes)


def check_sensitivities(bands: Bands) -> None:
    """Raise `InputError` for red, green and blue, which have no sensitivities."""
    if bands.is_rgb:
        raise InputError("rgb has no sensitivities; choose a number of bands")
