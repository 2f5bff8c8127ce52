"""What the lens does to light before it reaches the filters: vignetting, and point spread."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.spectra.curves import Floats

NONE, COS4 = "none", "cos4"
GAUSSIAN, DEFOCUS = "gaussian", "defocus"
_MOST_SPREAD = 64.0  # Largest standard deviation or radius, pixels
_CUT = 6.0  # Standard deviations at which a Gaussian is cut: 2e-9 of it lies beyond
_SUBPIXELS = 16  # Points along a side of a pixel by which the disk of a defocused point is measured
_FLAT = ("pinhole", "intrinsics")  # Cameras whose image is a plane, of which cos⁴ is true


def check_vignetting(text: str) -> str:
    """Return the text of a vignetting if it is one; raise `InputError` if not."""
    if text not in (NONE, COS4):
        _coefficients(text)
    return text


def _coefficients(text: Any) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except (AttributeError, ValueError):
        numbers = [math.nan]
    if not all(map(math.isfinite, numbers)):
        raise InputError(f"{shown(text)} is not none, cos4, or numbers such as -0.3,0.05")
    return numbers


def vignette(text: str, size: tuple[int, int], camera: dict[str, Any]) -> Floats:
    """Return the relative illuminance at the centres of pixels: (H, W).

    cos4 is E(θ) / E(0) = cos⁴ θ, with θ between the ray and the optical axis: M. Reiss, "The cos⁴
    law of illumination", JOSA 35(4), 1945.

    camera : the record of `photonmap.Camera.describe`
    """
    width, height = size
    if text == NONE:
        return np.ones((height, width))
    x, y = np.arange(width) + 0.5, (np.arange(height) + 0.5)[:, None]
    kind = camera.get("kind", "camera")
    if text == COS4:
        if kind not in _FLAT or camera.get("intrinsics") is None:
            raise InputError(
                "vignetting cos4 holds for images on a plane, not for a camera of the kind "
                f"{kind}; choose none, or a polynomial as in -0.3,0.05"
            )
        (fx, _, cx), (_, fy, cy), _ = camera["intrinsics"]
        return 1.0 / (1.0 + ((x - cx) / fx) ** 2 + ((y - cy) / fy) ** 2) ** 2
    matrix = camera.get("intrinsics")
    cx, cy = (0.5 * width, 0.5 * height) if matrix is None else (matrix[0][2], matrix[1][2])
    farthest = max(cx, width - cx) ** 2 + max(cy, height - cy) ** 2
    squared = ((x - cx) ** 2 + (y - cy) ** 2) / farthest
    values = np.polynomial.polynomial.polyval(squared, [1.0, *_coefficients(text)])
    if values.min() < 0.0:
        raise InputError(f"vignetting {text} falls to {values.min():.3g} in the image; keep it ≥ 0")
    return values


def check_psf(text: str) -> str:
    """Return the text of a point spread if it is one; raise `InputError` if not."""
    _spreads(text)
    return text


def _spreads(text: Any) -> list[tuple[str, float]]:
    """Return the kinds and sizes (pixels) of the parts of a point spread."""
    if text == NONE:
        return []
    found = []
    for part in str(text).split("+"):
        kind, _, number = part.strip().partition(":")
        try:
            wide = float(number)
        except ValueError:
            wide = math.nan
        if kind not in (GAUSSIAN, DEFOCUS) or not 0.0 < wide <= _MOST_SPREAD:
            raise InputError(
                f"{shown(text)} is not none, gaussian:S or defocus:R, with S and R above 0 and up "
                f"to {_MOST_SPREAD:g} pixels"
            )
        found.append((kind, wide))
    return found


def spread(image: Floats, text: str) -> Floats:
    """Return an image blurred by a point spread: (H, W, C).

    Kernels are integrals over pixels, are symmetric and add up to 1, and the image goes on in its
    mirror image: so the sum over all pixels does not change.
    """
    from scipy.ndimage import convolve, convolve1d

    for kind, wide in _spreads(text):
        if kind == GAUSSIAN:
            weights = gaussian_weights(wide)
            for axis in (0, 1):
                image = convolve1d(image, weights, axis=axis, mode="reflect")
        else:
            image = convolve(image, disk_weights(wide)[..., None], mode="reflect")
    return image


def gaussian_weights(sigma: float) -> Floats:
    """Return the integrals of a Gaussian over pixels along an axis, which add up to 1."""
    from scipy.special import ndtr

    half = math.ceil(_CUT * sigma)
    edges = np.arange(-half, half + 2) - 0.5
    weights = np.diff(ndtr(edges / sigma))
    return weights / weights.sum()


def disk_weights(radius: float) -> Floats:
    """Return the fractions of a disk within pixels: square, adding up to 1."""
    half = math.ceil(radius + 0.5) - 1
    count = (2 * half + 1) * _SUBPIXELS
    at = (np.arange(count) + 0.5) / _SUBPIXELS - 0.5 * (2 * half + 1)
    inside = (at[:, None] ** 2 + at**2 <= radius**2).astype(np.float64)
    side = 2 * half + 1
    weights = inside.reshape(side, _SUBPIXELS, side, _SUBPIXELS).sum(axis=(1, 3))
    return weights / weights.sum()
