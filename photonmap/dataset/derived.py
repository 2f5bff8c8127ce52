"""What a data set has beside a render's buffers: colours of light, masks, and linear sRGB."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.output import LIGHT
from photonmap.projection import Method
from photonmap.result import Result

Image = NDArray[Any]

PROJECTED = (*LIGHT[:-1], "reflectance", "shading")
MASKS = ("valid", "light_source", "background")


def with_derived(result: Result) -> Result:
    """Return a render with buffers that follow from its own.

    `scalar_shading` (H, W) is the mean of shading over the bands; `illuminant` (H, W, N) shading
    over it, so that their product is shading; `illuminant_direct` the same of direct light alone, 0
    where that is not known: where a band of reflectance is 0, or some light is not diffuse. Masks
    are (H, W) bool: `background` where no surface is at the centre, `light_source` where something
    emits in the pixel and a surface is at its centre, `valid` where surfaces cover the pixel, none
    emits, and light was found.
    """
    emits = result.emission.any(axis=-1)
    background = result.object_id == 0
    covered = result.coverage >= 1.0
    buffers = {
        **result.buffers,
        "scalar_shading": result.scalar_shading,
        "illuminant": result.illuminant.data,
        "illuminant_direct": _direct_illuminant(result),
        "valid": covered & ~emits & ~result.unresolved,
        "light_source": emits & ~background,
        "background": background,
    }
    return replace(result, buffers=buffers)


def _direct_illuminant(result: Result) -> Image:
    """Return the colour of direct light: direct / reflectance over its mean, or 0."""
    reflectance = result.reflectance.astype(np.float64)
    known = (reflectance > 0.0).all(axis=-1, keepdims=True)
    known &= ~result.residual.any(axis=-1, keepdims=True)
    shading = np.divide(result.direct, reflectance, where=known, out=np.zeros(reflectance.shape))
    return _over_mean(shading)


def _over_mean(light: Image) -> Image:
    """Return light over its mean over bands, 0 where that is 0."""
    mean = light.mean(axis=-1, keepdims=True, dtype=np.float64)
    lit = np.broadcast_to(mean > 0.0, light.shape)
    return np.divide(light, mean, where=lit, out=np.zeros(light.shape)).astype(np.float32)


def rgb_method(bands: Bands) -> Method | None:
    """Return how bands are projected: by regression, or RGB as it stands."""
    return None if bands.is_rgb else "regression"


def as_rgb(result: Result) -> Result:
    """Return a render in linear sRGB, (H, W, 3) float32 each; those of groups of lights too.

    Radiances and shading are projected by one matrix, reflectance by the same under equal-energy
    white. Products do not commute with that: `residual` is the signed rest, radiance − emission −
    reflectance × shading, of these RGB images. `illuminant` is shading over its mean,
    `illuminant_direct` the same of direct light alone, 0 where that is not known.

    Parameters
    ----------
    result : with what `with_derived` adds
    """
    method = rgb_method(result.bands)
    names = [name for name in result.buffers if name.partition("@")[0] in PROJECTED]
    rgb = {name: result.rgb(name, method) for name in names}
    product = rgb["reflectance"].astype(np.float64) * rgb["shading"]
    rest = rgb["radiance"].astype(np.float64) - rgb["emission"] - product
    rgb["residual"] = rest.astype(np.float32)
    projected = Result(rgb, {}, Bands.rgb(), result.record)
    rgb["scalar_shading"] = projected.scalar_shading
    rgb["illuminant"] = projected.illuminant.data
    rgb["illuminant_direct"] = _over_mean(result.rgb("illuminant_direct", method))
    return projected


def rgb_residual(rgb: Result) -> float:
    """Return the norm of the RGB residual over that of radiance − emission; 0 where that is 0."""
    light = rgb.radiance.astype(np.float64) - rgb.emission
    whole = float(np.linalg.norm(light))
    return float(np.linalg.norm(rgb.residual.astype(np.float64))) / whole if whole else 0.0
