"""What metrics take: a truth, an estimate of the same size, and the mask of pixels that count."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Pair(NamedTuple):
    """A truth and an estimate; both are 0 outside of the mask."""

    truth: Floats  # (H, W, C)
    estimate: Floats  # (H, W, C)
    mask: Mask  # (H, W)


def paired(truth: Any, estimate: Any, mask: Any = None) -> Pair:
    """Check a truth and an estimate, and return them as (H, W, C) float64.

    Parameters
    ----------
    truth, estimate : (H, W) or (H, W, C); an estimate (H, W) stands for C equal bands
    mask : (H, W) bool, of the pixels that count; None for all

    Raises
    ------
    InputError : sizes differ, no pixel counts, or a value that counts is not finite
    """
    true, made = _banded(truth, "truth"), _banded(estimate, "estimate")
    if made.shape[2] == 1:
        made = np.broadcast_to(made, (*made.shape[:2], true.shape[2]))
    if made.shape != true.shape:
        raise InputError(f"the estimate is {_size(made)}, the truth {_size(true)}; make them equal")
    counted = np.ones(true.shape[:2], bool) if mask is None else np.asarray(mask, bool)
    if counted.shape != true.shape[:2]:
        raise InputError(f"the mask is {counted.shape}, the truth {_size(true)}; make them equal")
    if not counted.any():
        raise InputError("no pixel is valid, so there is nothing to compare")
    for name, image in (("truth", true), ("estimate", made)):
        if wrong := int((~np.isfinite(image[counted]).all(axis=-1)).sum()):
            raise InputError(f"the {name} has NaN or infinity in {wrong} valid pixels; mask them")
    inside = counted[..., None]
    return Pair(np.where(inside, true, 0.0), np.where(inside, made, 0.0), counted)


def _banded(image: Any, name: str) -> Floats:
    """Return an image as (H, W, C) float64."""
    array = real(image, f"the {name}")
    if array.ndim not in (2, 3):
        raise InputError(f"the {name} has shape {array.shape}; it must be (H, W) or (H, W, C)")
    return array if array.ndim == 3 else array[..., None]


def _size(image: Floats) -> str:
    height, width, count = image.shape
    return f"{width}×{height} in {count} band{'s' * (count != 1)}"


def real(values: Any, owner: str) -> Floats:
    """Return values as float64; complex ones, text or the like are an `InputError`."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise InputError(f"{owner} is of type {array.dtype}; give real numbers")
    return array.astype(np.float64, copy=False)


def to_grey(image: Any) -> Floats:
    """Return the mean over bands of (H, W) or (H, W, C): (H, W)."""
    array = real(image, "the image")
    return array if array.ndim == 2 else array.mean(axis=-1)


def blurred_within(image: Floats, mask: Mask, sigma: float, mode: str = "reflect") -> Floats:
    """Return the Gaussian means of (H, W, C) over the pixels of a mask; 0 where none is near.

    σ is in pixels; the mode is what is beyond the border, as `scipy.ndimage.gaussian_filter` takes
    it.
    """
    from scipy.ndimage import gaussian_filter

    near, weight = (
        gaussian_filter(values, sigma, axes=(0, 1), mode=mode)
        for values in (np.where(mask[..., None], image, 0.0), mask[..., None].astype(np.float64))
    )
    return np.divide(near, weight, where=weight > 0.0, out=np.zeros_like(near))


def least_squares_factor(truth: Floats, estimate: Floats) -> float:
    """Return the factor of the estimate that brings it closest to the truth; 0 if it is black."""
    energy = float((estimate * estimate).sum())
    return float((truth * estimate).sum()) / energy if energy > 0.0 else 0.0
