"""Angular errors of the illuminant, and the figures by which colour constancy is reported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, paired, real


def angular_error(truth: Any, estimate: Any) -> float:
    """Return the angle between two colours of light, degrees, whatever their brightness.

    S. D. Hordley and G. D. Finlayson, "Re-evaluating colour constancy algorithms", ICPR 2004.

    Parameters
    ----------
    truth, estimate : (C,)

    Raises
    ------
    InputError : they have different numbers of bands, or one of them is black or not finite
    """
    true, made = (real(color, "the colour") for color in (truth, estimate))
    if true.ndim != 1 or true.shape != made.shape:
        raise InputError(
            f"illuminants must both have shape (C,); got {true.shape} and {made.shape}"
        )
    if not all(np.isfinite(color).all() and color.any() for color in (true, made)):
        raise InputError("an illuminant is black or not finite, so it has no colour")
    return float(_angles(true, made))


def angular_error_map(truth: Any, estimate: Any, mask: Any = None) -> Floats:
    """Return the angle between illuminants in each valid pixel that light reaches: (P,) degrees.

    Parameters
    ----------
    truth : (H, W, C), 0 where no light arrives
    estimate : (H, W, C), or (C,) for one illuminant everywhere; 90° where it is black
    mask : (H, W) bool, of the pixels that count; None for all

    Raises
    ------
    InputError : no valid pixel is lit, or as `arrays.paired` says
    """
    true, made = real(truth, "the truth"), real(estimate, "the estimate")
    made = np.broadcast_to(made, true.shape) if made.shape == true.shape[-1:] else made
    pair = paired(true, made, mask)
    lit = pair.mask & pair.truth.any(axis=-1)
    if not lit.any():
        raise InputError("no light reaches a valid pixel, so there is no illuminant to compare")
    return _angles(pair.truth[lit], pair.estimate[lit])


def _angles(truth: Floats, estimate: Floats) -> Floats:
    """Return the angles between the last axes, degrees, accurate for small angles too.

    W. Kahan: 2 atan2(|u/|u| − v/|v||, |u/|u| + v/|v||). A black colour is at a right angle.
    """
    true, made = (_unit(colors) for colors in (truth, estimate))
    apart, together = (np.linalg.norm(colors, axis=-1) for colors in (true - made, true + made))
    return np.degrees(2.0 * np.arctan2(apart, together))


def _unit(colors: Floats) -> Floats:
    length = np.linalg.norm(colors, axis=-1, keepdims=True)
    return np.divide(colors, length, where=length > 0.0, out=np.zeros_like(colors))


@dataclass(frozen=True)
class AngularSummary:
    """Figures of many angular errors, degrees.

    Parameters
    ----------
    mean, median : over all
    trimean : (Q1 + 2 Q2 + Q3) / 4 of the quartiles
    best, worst : means over the quarter of lowest and of highest errors
    """

    mean: float
    median: float
    trimean: float
    best: float
    worst: float


def summarise_angles(errors: Any) -> AngularSummary:
    """Return the figures of errors (K,), K at least 1; a quarter is ⌈K / 4⌉ of them."""
    return AngularSummary(**{name: angular_figure(name, errors) for name in _FIGURES})


def angular_figure(name: str, errors: Any) -> float:
    """Return one figure of an `AngularSummary` of errors (K,), K at least 1, by its name."""
    ordered = np.sort(np.asarray(errors, np.float64).ravel())
    if not ordered.size:
        raise InputError("there are no angular errors to summarise")
    return float(_FIGURES[name](ordered))


def _trimean(ordered: Floats) -> float:
    low, middle, high = np.percentile(ordered, (25.0, 50.0, 75.0))
    return float(low + 2.0 * middle + high) / 4.0


_FIGURES: dict[str, Callable[[Floats], Any]] = {
    "mean": np.mean,
    "median": lambda ordered: np.percentile(ordered, 50.0),
    "trimean": _trimean,
    "best": lambda ordered: ordered[: -(-len(ordered) // 4)].mean(),
    "worst": lambda ordered: ordered[-len(ordered) // 4 :].mean(),
}
