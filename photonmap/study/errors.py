"""Errors of images: stated by a render, true against a reference, and of colours.

Relative errors are sqrt(mean(d² / (v² + 0.01 m²))) over bands and valid pixels: d is a deviation, v
the value it is relative to, m its mean in a band.

The reference is two long renders of independent seeds. Their noise does not bias a measured error:
for halves A and B, the expectation of mean((I − A)(I − B) / …) is the squared error of I alone.
Their difference measures the error of the reference itself.

Colour errors compare an image of N bands with one of many. Both are projected to XYZ or linear sRGB
as the renderer does. With equal seeds and passes they share their noise, so that their difference
is due to the bands alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from photonmap.film.relative_error import Mask, divide_by_norm, squared_norm, valid_pixels
from photonmap.report.pages import webp_uri
from photonmap.results.result import Result
from photonmap.spectra.color_difference import delta_e_2000

Floats = NDArray[np.float64]

BUFFERS = ("radiance", "direct", "indirect", "shading")
"""Buffers whose errors are studied."""


def counted_pixels(result: Result) -> Mask:
    """Return which pixels are valid, (H, W)."""
    return valid_pixels(result.coverage, result.emission, result.unresolved)


def mean_relative(squares: NDArray[Any], values: NDArray[Any]) -> float:
    """Return mean(squares / (v² + 0.01 m²)) of (P, N) squares and values; black bands count 0."""
    return float(divide_by_norm(np.asarray(squares, np.float64), relative_to(values)).mean())


def relative_to(values: NDArray[Any]) -> Floats:
    """Return v² + 0.01 m² of (P, N) values, m the mean over P."""
    return squared_norm(np.asarray(values, np.float64))


def relative_distance(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return sqrt(mean(|d|² / (|v|² + 0.01 |m|²))) of colours (P, 3), taken as vectors."""
    squares = ((np.asarray(values, np.float64) - truth) ** 2).sum(axis=-1, keepdims=True)
    norm = relative_to(truth).sum(axis=-1, keepdims=True)
    return math.sqrt(float(divide_by_norm(squares, norm).mean()))


def stated_error(result: Result, buffer: str, mask: Mask) -> float:
    """Return the relative error that a render states for a buffer; nan after a single pass."""
    if buffer not in result.errors:
        return math.nan
    spread = result.errors[buffer][mask].astype(np.float64)
    return math.sqrt(mean_relative(spread**2, result.buffers[buffer][mask]))


def mean_difference(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return the relative difference of the means of two images over all pixels and bands."""
    whole = float(np.mean(truth, dtype=np.float64))
    return float(np.mean(values, dtype=np.float64)) / whole - 1.0 if whole > 0.0 else 0.0


def mean_error(result: Result, mask: Mask) -> float:
    """Return the relative standard error of mean radiance of independent pixels.

    Pixels are independent in path tracing, which shares no light between them. nan after a single
    pass.
    """
    if "radiance" not in result.errors:
        return math.nan
    spread = result.errors["radiance"][mask].mean(axis=-1, dtype=np.float64)
    mean = float(result.radiance[mask].mean(dtype=np.float64))
    return float(np.sqrt((spread**2).sum())) / len(spread) / mean if mean > 0.0 else 0.0


class Reference:
    """Two independent renders of the same settings, and their mean; a pixel at least is valid."""

    def __init__(self, first: Result, second: Result) -> None:
        self._halves = first, second

    @cached_property
    def mask(self) -> Mask:
        """Valid pixels, (H, W) bool."""
        return counted_pixels(self._halves[0])

    @property
    def passes(self) -> int:
        """Number of passes of both halves."""
        return sum(half.record["passes"] for half in self._halves)

    @property
    def seconds(self) -> float:
        """Seconds of rendering both halves."""
        return sum(half.record["seconds"]["render"] for half in self._halves)

    @cached_property
    def exposure(self) -> float:
        """Exposure of all pictures of the study."""
        return self._halves[0].exposure

    @cached_property
    def luminance(self) -> Floats:
        """Luminance of radiance, (H, W)."""
        return np.mean([half.xyz()[..., 1] for half in self._halves], axis=0, dtype=np.float64)

    def value(self, buffer: str) -> Floats:
        """Return the mean of the halves over valid pixels, (P, N)."""
        return np.mean([h.buffers[buffer][self.mask] for h in self._halves], 0, dtype=np.float64)

    def own_error(self, buffer: str) -> float:
        """Return the relative error of the reference, from the difference of its halves."""
        first, second = (half.buffers[buffer][self.mask] for half in self._halves)
        half_difference = (first.astype(np.float64) - second) / 2.0
        return math.sqrt(mean_relative(half_difference**2, self.value(buffer)))

    def own_errors(self) -> dict[str, float]:
        """Return `own_error` of every studied buffer."""
        return {buffer: self.own_error(buffer) for buffer in BUFFERS}

    def fits(self, result: Result) -> bool:
        """Return whether a result has the size and the bands of the reference."""
        first = self._halves[0]
        return result.radiance.shape == first.radiance.shape and result.bands == first.bands

    def true_error(self, result: Result, buffer: str) -> float:
        """Return the true relative error of a result; 0 where it is too small to be measured."""
        image = result.buffers[buffer][self.mask].astype(np.float64)
        first, second = (image - half.buffers[buffer][self.mask] for half in self._halves)
        return math.sqrt(max(mean_relative(first * second, self.value(buffer)), 0.0))

    def mean_difference(self, result: Result) -> float:
        """Return the relative difference of a result's mean radiance from the reference's."""
        return mean_difference(result.radiance[self.mask], self.value("radiance"))


REFERENCE_BANDS = "81"
"""Bands of the images that are taken as true."""


@dataclass(frozen=True)
class ColorError:
    """Colour errors of an image of N bands against one of many."""

    delta_mean: float  # ΔE2000 of radiance, mean and 95th percentile over pixels
    delta_p95: float
    indirect_mean: float  # the same for indirect light alone
    indirect_p95: float
    luminance: float  # relative error of the luminance Y of radiance
    radiance: float  # relative distances in XYZ
    shading: float
    indirect: float


def color_error(result: Result, truth: Result, mask: Mask) -> ColorError:
    """Compare a result with one of more bands and equal seed and passes, over valid pixels."""
    deltas = [
        delta_e_2000(result.rgb(buffer, white="D65"), truth.rgb(buffer, white="D65"))[mask]
        for buffer in ("radiance", "indirect")
    ]
    means = [each for off in deltas for each in (off.mean(), np.percentile(off, 95.0))]
    distances = [
        relative_distance(result.xyz(buffer)[mask], truth.xyz(buffer)[mask])
        for buffer in ("radiance", "shading", "indirect")
    ]
    luminance = relative_distance(result.xyz()[mask][:, 1:2], truth.xyz()[mask][:, 1:2])
    return ColorError(*map(float, (*means, luminance, *distances)))


Kind = Literal["true", "stated", "delta"]

COLORMAPS: dict[Kind, str] = {"true": "RdBu_r", "stated": "magma", "delta": "magma"}
"""Colour maps of Matplotlib; signed maps have 0 in the middle."""

CAPTIONS: dict[Kind, str] = {
    "true": "luminance − reference, relative",
    "stated": "estimated standard error of luminance, relative",
    "delta": f"ΔE2000 against {REFERENCE_BANDS} bands",
}

_STEPS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
_COVERED = 98.0  # percentile of the absolute values that the scale of a map covers


@dataclass(frozen=True)
class ErrorMap:
    """A map of errors as a data URI; `scale` ends its colour bar: a fraction, or ΔE2000."""

    kind: Kind
    image: str
    scale: float


def true_map(result: Result, reference: Reference) -> ErrorMap:
    """Map luminance minus that of the reference, relative to sqrt(Y² + 0.01 m²)."""
    truth = reference.luminance
    return _map("true", (result.xyz()[..., 1] - truth) / _scale_of(truth))


def stated_map(result: Result) -> ErrorMap | None:
    """Map the relative standard error of radiance, as band means; None after a single pass."""
    if "radiance" not in result.errors:
        return None
    radiance = result.radiance.mean(axis=-1, dtype=np.float64)
    spread = result.errors["radiance"].mean(axis=-1, dtype=np.float64)
    return _map("stated", spread / _scale_of(radiance))


def delta_map(result: Result, truth: Result) -> ErrorMap:
    """Map ΔE2000 of radiance against a render of more bands."""
    return _map("delta", delta_e_2000(result.rgb(white="D65"), truth.rgb(white="D65")))


def picture(result: Result, exposure: float) -> str:
    """Return radiance as a data URI at the given exposure."""
    return webp_uri(result.preview(exposure))


def color_bar(kind: Kind, steps: int = 17) -> list[str]:
    """Return colours of a map from low to high, as #rrggbb."""
    colors = _colors(kind, np.linspace(0.0, 1.0, steps))
    return [f"#{bytes(color).hex()}" for color in colors]


def _scale_of(values: NDArray[np.floating]) -> Floats:
    """Return sqrt(v² + 0.01 m²) of an image (H, W); 1 if the image is black."""
    norm = np.sqrt(relative_to(values.ravel()[:, None])).reshape(values.shape)
    return np.where(norm > 0.0, norm, 1.0)


def _map(kind: Kind, values: Floats) -> ErrorMap:
    """Colour values at the smallest round scale that covers nearly all of them."""
    most = np.percentile(np.abs(values), _COVERED)
    scale = next((step for step in _STEPS if step >= most), _STEPS[-1])
    shown = (values / scale + 1.0) / 2.0 if kind == "true" else values / scale
    return ErrorMap(kind, webp_uri(_colors(kind, shown)), scale)


def _colors(kind: Kind, values: Floats) -> NDArray[np.uint8]:
    """Return the colours of values, clipped to [0, 1], as (..., 3) uint8."""
    from matplotlib import colormaps

    return np.asarray(colormaps[COLORMAPS[kind]](np.clip(values, 0.0, 1.0), bytes=True))[..., :3]
