"""What Mitsuba 3 makes of a scene, denoised or not, and takes for it; kept on disk where asked."""

from __future__ import annotations

import hashlib
import statistics
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.mitsuba_client import ONE_BOUNCE, UNLIMITED, Mitsuba
from photonmap.film.relative_error import relative_squares

SAMPLES, RENDERS = 64, 4
"""Samples per pixel of one render, and number of renders."""
FEW = (1, 4, 16)
"""Samples per pixel of renders that are made to be denoised, besides one and all of the others."""
DENOISED = (*FEW, SAMPLES, SAMPLES * RENDERS)
TIMED = 2
"""Renders that time this machine anew, where images were kept."""

Images = NDArray[np.float32]


@dataclass
class Rendered:
    """Images in units of the scene, and processor seconds."""

    mean: Images
    """(H, W, 3) radiance, of all renders"""
    variance: Images
    """of one of them"""
    indirect: Images
    """(H, W, 3), without what lamps and one reflection give"""
    indirect_variance: Images
    seconds: float
    """of one of them"""
    denoised: Images
    """(D, H, W, 3), by `DENOISED`; D is 0 where there is no denoiser"""
    denoised_seconds: NDArray[np.float64]
    """(D,)"""

    def cost(self, valid: NDArray[np.bool_]) -> float:
        """Return processor seconds × relMSE, over valid pixels."""
        squares = relative_squares(self.variance[valid].astype(float), self.mean[valid])
        return self.seconds * float(squares.mean())

    def mean_of(self, name: str, valid: NDArray[np.bool_]) -> tuple[float, float]:
        """Return the mean of "radiance" or "indirect" over valid pixels, and its standard error.

        Bands of a pixel are lit by the same paths: they are taken to err alike.
        """
        image, variance = {
            "radiance": (self.mean, self.variance),
            "indirect": (self.indirect, self.indirect_variance),
        }[name]
        spread = variance[valid].mean(axis=-1, dtype=float) / RENDERS
        return float(image[valid].mean(dtype=float)), float(spread.sum() ** 0.5 / len(spread))


def render_or_read(
    other: Mitsuba, scene: tuple[Path, float], name: str, kept: Path | None
) -> Rendered:
    """Return what Mitsuba renders of a scene, or what it once did.

    A scene is its file and its unit of radiance, as `mitsuba_export.export_scene` returns them.
    Kept images are those of the same scene, to the bit, by the same Mitsuba. Their times are then
    multiplied by what a render takes now over what it took.
    """
    file, power = scene
    if kept is None:
        return _render(other, power)
    place = kept / f"{name}-{other.version}-{other.variant}-{_fingerprint(file)}.npz"
    if not place.exists():
        found = _render(other, power)
        kept.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(place, **asdict(found))
        return found
    with np.load(place) as arrays:
        found = Rendered(**{key: arrays[key] for key in arrays.files})
    seconds = statistics.mean(_timed(other, SAMPLES, seed)[1] for seed in range(TIMED))
    scale = seconds / float(found.seconds)
    return replace(found, seconds=seconds, denoised_seconds=found.denoised_seconds * scale)


def _fingerprint(file: Path) -> str:
    """Return a hash of a scene's files, wherever they lie, and of what is rendered of it."""
    hashed = hashlib.sha256(f"{DENOISED} {RENDERS}".encode())
    hashed.update(file.read_text().replace(str(file.parent), "").encode())
    for part in sorted(file.parent.iterdir()):
        if part != file:
            hashed.update(part.read_bytes())
    return hashed.hexdigest()[:16]


def _render(other: Mitsuba, power: float) -> Rendered:
    for depth in (UNLIMITED, ONE_BOUNCE):
        other.render(SAMPLES, 99, depth)  # compiles, and touches the memory
    images, seconds = zip(
        *(_timed(other, SAMPLES, seed + 1) for seed in range(RENDERS)), strict=True
    )
    beyond = [
        image - other.render(SAMPLES, 11 + seed, ONE_BOUNCE)[0] for seed, image in enumerate(images)
    ]
    noisy = [(count, *_timed(other, count, 21)) for count in FEW]
    noisy += [(SAMPLES, images[0], seconds[0])]
    noisy += [(SAMPLES * RENDERS, np.mean(images, axis=0), sum(seconds))]
    denoised, spent = _denoise(other, noisy)
    scale = np.float32(power)
    return Rendered(
        mean=np.mean(images, axis=0) * scale,
        variance=np.var(images, axis=0, ddof=1) * scale**2,
        indirect=np.mean(beyond, axis=0) * scale,
        indirect_variance=np.var(beyond, axis=0, ddof=1) * scale**2,
        seconds=statistics.mean(seconds),
        denoised=np.array(denoised, np.float32) * scale,
        denoised_seconds=np.array(spent),
    )


def _denoise(
    other: Mitsuba, noisy: list[tuple[int, Any, float]]
) -> tuple[list[Images], list[float]]:
    """Denoise images of so many samples that took so long; return nothing if it cannot be done."""
    try:
        other.denoise(noisy[0][1], 1)  # compiles
        found = [(other.denoise(image, count), other.processor) for count, image, _ in noisy]
    except RuntimeError as error:
        print(f"rooms: not denoised: {str(error).strip().splitlines()[-1]}", flush=True)
        return [], []
    images, seconds = zip(*found, strict=True)
    return list(images), [own + more for (*_, own), more in zip(noisy, seconds, strict=True)]


def _timed(other: Mitsuba, samples: int, seed: int) -> tuple[Images, float]:
    """Return an image and its processor seconds."""
    image, _ = other.render(samples, seed)
    return image, other.processor
