"""Each light's share of the irradiance, interreflection included, and its standard error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import group_name
from photonmap.errors import InputError
from photonmap.results.result import Result

Array = NDArray[Any]


def shares_of(shadings: Mapping[str, Array]) -> dict[str, Array]:
    """Return the shares of lights, (H, W) float32 each, of the means over bands.

    They add up to 1, and are 0 where no light arrives.

    Parameters
    ----------
    shadings : (H, W, N) by light group
    """
    parts = {light: image.mean(axis=-1, dtype=np.float64) for light, image in shadings.items()}
    whole = np.sum([*parts.values()], axis=0)
    return {light: _ratio(part, whole).astype(np.float32) for light, part in parts.items()}


def share_errors(result: Result, lights: Sequence[str]) -> dict[str, Array]:
    """Return the standard errors of shares, (H, W) float32 each; 0 where no light arrives.

    By the delta method, the variance of a share s is that of S − sT over T², where S is a light's
    shading and T that of all. It has the covariance of S and T: lights of a pixel share camera
    samples, and choose light samples among each other. It follows from the errors of the lights and
    of their sum, with one correlation for all pairs of lights in a pixel; this is exact for two
    lights. Errors of bands add up as if they were fully correlated, which is the most they can do.

    Raises
    ------
    InputError : the result has no errors of light groups, as in lean files
    """
    names = {light: group_name("shading", light) for light in lights}
    if missing := [name for name in names.values() if name not in result.errors]:
        raise InputError(f"holds no standard error of {missing[0]}; make the set with --full")
    values = np.array([result.buffers[name] for name in names.values()], np.float64)
    errors = np.array([result.standard_error(name) for name in names.values()], np.float64)
    whole, of_whole = values.sum(axis=0), result.standard_error("shading").astype(np.float64)
    with_whole = _covariances(errors, of_whole)
    bands = whole.sum(axis=-1)
    found = {}
    for light, value, error, covariance in zip(lights, values, errors, with_whole, strict=True):
        share = _ratio(value.sum(axis=-1), bands)[..., None]
        variance = error**2 - 2.0 * share * covariance + share**2 * of_whole**2
        spread = np.sqrt(np.maximum(variance, 0.0)).sum(axis=-1)
        found[light] = _ratio(spread, bands).astype(np.float32)
    return found


def _covariances(errors: Array, of_whole: Array) -> Array:
    """Return the covariances of lights with their sum, (lights, H, W, N).

    Parameters
    ----------
    errors : standard errors of the lights, (lights, H, W, N)
    of_whole : of their sum, (H, W, N)
    """
    others = errors.sum(axis=0) - errors
    pairs = (errors * others).sum(axis=0)
    correlation = np.clip(_ratio(of_whole**2 - (errors**2).sum(axis=0), pairs), -1.0, 1.0)
    return errors**2 + correlation * errors * others


def _ratio(part: Array, whole: Array) -> Array:
    """Return a ratio, 0 where there is nothing to divide by."""
    return np.divide(part, whole, where=whole > 0.0, out=np.zeros(part.shape))
