"""Buffers derived from those of a render: illuminant colours, masks, linear sRGB."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import RENDERED, split_name
from photonmap.dataset.files.light_colors import direct_light_color, light_colors, over_mean
from photonmap.dataset.files.pure_pixels import pure_pixels
from photonmap.film.valid_pixels import valid_pixels
from photonmap.results.result import Result
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import SRGB, Method, projection_onto

Image = NDArray[Any]

PROJECTED = tuple(
    row.name for row in RENDERED if row.is_banded and row.name not in ("residual", "covariance")
)
"""Buffers that have a colour: not the residual, which is computed again, nor what errors need."""


def with_derived(
    result: Result, scene: Scene | None = None, pieces: NDArray[np.bool_] | None = None
) -> Result:
    """Return a render with the buffers that follow from its own, `photonmap.buffers.ADDED`.

    Parameters
    ----------
    scene : that was rendered; without it, no pixel is known to be pure, and the colour of direct
        light is that of direct / reflectance
    pieces : which pixels show one piece of surface, where it is known, see
        `photonmap.dataset.files.pure_pixels.one_piece`
    """
    color, pure = None, np.zeros(result.coverage.shape, bool)
    if scene is not None:
        colors = light_colors(scene, result.per_light, result.bands)
        color, pure = direct_light_color(result, colors), pure_pixels(result, scene, pieces)
    emits = result.emission.any(axis=-1)
    background = result.object_id == 0
    buffers = {
        **result.buffers,
        "scalar_shading": result.scalar_shading,
        "illuminant": result.illuminant.data,
        "illuminant_direct": _ratio_color(result) if color is None else color,
        "valid": _valid(result),
        "light_source": emits & ~background,
        "background": background,
        "pure": pure,
    }
    return replace(result, buffers=buffers)


def _valid(result: Result) -> NDArray[np.bool_]:
    """Return the valid pixels of a render but for those of mirrors, glass or bare metal.

    Such pixels have a residual and no reflectance; those at its edges are next to them.
    """
    seen = result.residual.any(axis=-1)
    specular = seen & ~result.reflectance.any(axis=-1)
    beside = np.pad(specular, 1)
    beside = beside[:-2] | beside[1:-1] | beside[2:]
    beside = beside[:, :-2] | beside[:, 1:-1] | beside[:, 2:]
    valid = valid_pixels(result.coverage, result.emission, result.unresolved)
    return valid & ~(seen & beside)


def _ratio_color(result: Result) -> Image:
    """Return the colour of direct / reflectance; 0 where a band of reflectance is 0."""
    reflectance = result.reflectance.astype(np.float64)
    known = (reflectance > 0.0).all(axis=-1, keepdims=True)
    known &= ~result.residual.any(axis=-1, keepdims=True)
    shading = np.divide(result.direct, reflectance, where=known, out=np.zeros(reflectance.shape))
    return over_mean(shading)


def rgb_method(bands: Bands) -> Method | None:
    """Return how bands are projected to RGB: by regression; None for RGB, which stays as it is."""
    return None if bands.is_rgb else "regression"


def as_rgb(result: Result, space: str = SRGB) -> Result:
    """Return the buffers in RGB, (H, W, 3) float32 each, those of light groups included.

    Radiances and shading are projected by one matrix, reflectance by the same under equal-energy
    white, and kept within [0, 1]; the colours of lights are kept. Projection does not commute with
    products: `residual` is the signed rest of these RGB images, radiance − emission − reflectance ×
    shading. `illuminant` is shading over its mean, `illuminant_direct` the same for direct light
    alone, 0 where it is unknown. What follows from a buffer that is not held is left out.

    Parameters
    ----------
    result : with the buffers that `with_derived` adds
    space : linear sRGB, or as `photonmap.spectra.projection.check_space` takes it
    """
    matrix = projection_onto(result.bands, space, rgb_method(result.bands))
    names = [name for name in result.buffers if split_name(name)[0] in PROJECTED]
    rgb = {name: _project(result.buffers[name], matrix) for name in names}
    white = matrix.sum(axis=1, keepdims=True)
    rgb["reflectance"] = np.clip(_project(result.reflectance, matrix / white), 0.0, 1.0)
    if "emission" in rgb:
        product = rgb["reflectance"].astype(np.float64) * rgb["shading"]
        rest = rgb["radiance"].astype(np.float64) - rgb["emission"] - product
        rgb["residual"] = rest.astype(np.float32)
    other = {} if space == SRGB else {"rgb_space": Path(space).name}
    projected = Result(rgb, {}, Bands.rgb(), {**result.record, "white": None, **other})
    rgb["scalar_shading"] = projected.scalar_shading
    rgb["illuminant"] = projected.illuminant.data
    if (color := result.buffers.get("illuminant_direct")) is not None:
        rgb["illuminant_direct"] = over_mean(_project(color, matrix))
    return replace(projected, buffers=rgb)


def _project(image: Image, matrix: NDArray[np.float64]) -> NDArray[np.float32]:
    most = np.finfo(np.float32).max
    return np.clip(image @ matrix.T, -most, most).astype(np.float32)


def rgb_residual(rgb: Result) -> float:
    """Return the norm of the RGB residual relative to that of radiance − emission, or 0."""
    light = rgb.radiance.astype(np.float64) - rgb.emission
    whole = float(np.linalg.norm(light))
    return float(np.linalg.norm(rgb.residual.astype(np.float64))) / whole if whole else 0.0


def negative_share(rgb: Result, valid: NDArray[np.bool_]) -> float | None:
    """Return the share of valid pixels in which radiance is negative in a channel, or None."""
    return float((rgb.radiance[valid] < 0.0).any(axis=-1).mean()) if valid.any() else None
