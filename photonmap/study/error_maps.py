"""Pictures and error maps as data URIs, small enough to embed dozens of them in a page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from photonmap.report.pages import webp_uri
from photonmap.results.result import Result
from photonmap.spectra.color_difference import delta_e_2000
from photonmap.study.errors import REFERENCE_BANDS, Floats, Reference, relative_to

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
    """A map of the errors of an image.

    Parameters
    ----------
    kind : "true": luminance against the reference, signed; "stated" error; or "delta": ΔE2000
    image : data URI
    scale : the value at the end of the colour bar: a fraction, or ΔE2000
    """

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
    return [
        "#" + "".join(f"{part:02x}" for part in color)
        for color in _colors(kind, np.linspace(0.0, 1.0, steps))
    ]


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
