"""Buffers derived from those of a render: illuminant colours, masks, linear sRGB."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import RENDERED, split_name
from photonmap.film.valid_pixels import valid_pixels
from photonmap.results.result import Result
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import Method

Image = NDArray[Any]

PROJECTED = tuple(
    row.name for row in RENDERED if row.is_banded and row.name not in ("residual", "covariance")
)
"""Buffers that have a colour: not the residual, which is computed again, nor what errors need."""


def with_derived(result: Result) -> Result:
    """Return a render with the buffers that follow from its own, `photonmap.buffers.ADDED`."""
    emits = result.emission.any(axis=-1)
    background = result.object_id == 0
    buffers = {
        **result.buffers,
        "scalar_shading": result.scalar_shading,
        "illuminant": result.illuminant.data,
        "illuminant_direct": _direct_illuminant(result),
        "valid": _valid(result),
        "light_source": emits & ~background,
        "background": background,
    }
    return replace(result, buffers=buffers)


def _valid(result: Result) -> NDArray[np.bool_]:
    """Return the valid pixels of a render but for those that show a mirror or glass.

    Such pixels have a residual and no reflectance; those at its edges are next to them.
    """
    seen = result.residual.any(axis=-1)
    specular = seen & ~result.reflectance.any(axis=-1)
    beside = np.pad(specular, 1)
    beside = beside[:-2] | beside[1:-1] | beside[2:]
    beside = beside[:, :-2] | beside[:, 1:-1] | beside[:, 2:]
    valid = valid_pixels(result.coverage, result.emission, result.unresolved)
    return valid & ~(seen & beside)


def _direct_illuminant(result: Result) -> Image:
    """Return the colour of direct light: direct / reflectance over its band mean, or 0."""
    reflectance = result.reflectance.astype(np.float64)
    known = (reflectance > 0.0).all(axis=-1, keepdims=True)
    known &= ~result.residual.any(axis=-1, keepdims=True)
    shading = np.divide(result.direct, reflectance, where=known, out=np.zeros(reflectance.shape))
    return _over_mean(shading)


def _over_mean(light: Image) -> Image:
    """Return light divided by its mean over bands, 0 where that is 0."""
    mean = light.mean(axis=-1, keepdims=True, dtype=np.float64)
    lit = np.broadcast_to(mean > 0.0, light.shape)
    return np.divide(light, mean, where=lit, out=np.zeros(light.shape)).astype(np.float32)


def rgb_method(bands: Bands) -> Method | None:
    """Return how bands are projected to RGB: by regression; None for RGB, which stays as it is."""
    return None if bands.is_rgb else "regression"


def as_rgb(result: Result) -> Result:
    """Return the buffers in linear sRGB, (H, W, 3) float32 each, those of light groups included.

    Radiances and shading are projected by one matrix, reflectance by the same under equal-energy
    white; the colours of lights are kept. Projection does not commute with products: `residual` is
    the signed rest of these RGB images, radiance − emission − reflectance × shading. `illuminant`
    is shading over its mean, `illuminant_direct` the same for direct light alone, 0 where it is
    unknown.

    Parameters
    ----------
    result : with the buffers that `with_derived` adds
    """
    method = rgb_method(result.bands)
    names = [name for name in result.buffers if split_name(name)[0] in PROJECTED]
    rgb = {name: result.rgb(name, method, "D65") for name in names}
    product = rgb["reflectance"].astype(np.float64) * rgb["shading"]
    rest = rgb["radiance"].astype(np.float64) - rgb["emission"] - product
    rgb["residual"] = rest.astype(np.float32)
    projected = Result(rgb, {}, Bands.rgb(), {**result.record, "white": None})
    rgb["scalar_shading"] = projected.scalar_shading
    rgb["illuminant"] = projected.illuminant.data
    rgb["illuminant_direct"] = _over_mean(result.rgb("illuminant_direct", method, "D65"))
    return projected


def rgb_residual(rgb: Result) -> float:
    """Return the norm of the RGB residual relative to that of radiance − emission, or 0."""
    light = rgb.radiance.astype(np.float64) - rgb.emission
    whole = float(np.linalg.norm(light))
    return float(np.linalg.norm(rgb.residual.astype(np.float64))) / whole if whole else 0.0
