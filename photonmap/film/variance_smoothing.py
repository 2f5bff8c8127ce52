"""Variance smoothing: standard errors that hold where few passes saw what makes a pixel vary.

An edge or a shadow that grazes a pixel may show in none of 16 passes: their spread is 0 then, and
the truth lies infinitely many standard errors away. So each variance is a mean of the pixel's own
and of what its eight neighbours show, which counts for some passes: nothing in the long run.
What they show is scaled as that of counts is, variance with brightness: beside an area light, the
wall is not as uncertain as the light's edge, nor is a caustic as certain as the shadow beside it.
Neighbours that do not vary say nothing of a pixel that does, as the wall beside a mirror of what is
seen there. Of a pixel whose passes all agree, they say what one sample more may have seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

PRIOR = 4.0
"""Passes that the neighbours count for. It and the scaling are measured: by how often intervals
hold the truth, over many seeds of scenes with diffuse surfaces, mirrors and glass."""
PRIORS = {"direct": 1.0, "direct_unfiltered": 1.0, "radiance": 2.5, "indirect_unfiltered": 7.0}
"""The same for buffers whose noise lies in patches, as that of direct light in penumbrae, and for
one in which rare photons of caustics count."""
OF_EDGES = ("reflectance", "emission")
"""Buffers that vary where edges cross a pixel, unless surfaces have textures."""
BLOCK_PRIOR = 1.0
"""The same for means over blocks, which have less in common with their neighbours."""
UNSEEN = 48.0
"""The same for a pixel whose passes all agree: what makes it vary is rarer than they could show."""
SAMPLES = 16
"""Camera samples of a pass of the usual size in a pixel that an edge may graze; half of one may go
unseen."""
ROUNDING = np.float32(2.0**-23)
"""Relative rounding error of sums of samples: means differ by it where all samples agree."""
SECOND_ORDER = 2.0
"""Relative second-order error of a ratio, over the square of its denominator's relative error."""
OF_CONTRAST = 0.5
"""Standard deviation of one sample's ratio, over the largest difference to a neighbour's."""

Image = NDArray[np.float32]


def smooth_error(
    error: Image,
    value: Image,
    counts: NDArray[np.integer] | int,
    prior: float = PRIOR,
    edges: float = 0.0,
    emits: NDArray[np.bool_] | None = None,
) -> Image:
    """Return a standard error smoothed by its neighbours, (H, W, N).

    Parameters
    ----------
    error, value : (H, W, N), of two passes or more, each pixel's own
    counts : (H, W) passes of each pixel, or of all
    prior : passes that neighbours count for
    edges : share of the `SAMPLES` that a pass takes where an edge may graze a pixel; 0 where none
        can
    emits : (H, W) whether a pixel shows an emitter, if the value includes emission. The edge of an
        area light says nothing of a wall beside it that varies.
    """
    scale = max(float(np.max(error)), float(np.max(np.abs(value))))
    if scale == 0.0:
        return error
    error, value = error / np.float32(scale), value / np.float32(scale)
    own = (np.maximum(counts, 1).astype(np.float32) - 1.0)[..., None]
    variance = error**2
    counts_for = np.where(variance > 0.0, np.float32(prior), np.float32(UNSEEN))
    steady = counts_for * _around(variance, value, emits) + own * variance
    steady /= counts_for + own
    if edges > 0.0:
        unseen = np.float32(0.5 / (SAMPLES * edges)) * _contrast(value) / (own + 1.0)
        steady = np.where(variance > 0.0, steady, np.maximum(steady, unseen**2))
    return (np.sqrt(steady + (ROUNDING * value) ** 2) * scale).astype(np.float32)


def degrees_of_freedom(buffer: str, passes: NDArray[np.integer] | int) -> NDArray[np.float64]:
    """Return those of smoothed errors of a buffer: the truth is Student's t of them off.

    Those of a pixel's own replicates, one less than passes up to 16, and those of eight neighbours
    that vary alike are put together by their weights (Welch 1947, Satterthwaite 1946). Where edges
    alone make pixels vary, each does so in its own way.
    """
    own = np.maximum(passes, 2) - 1.0
    replicates = np.maximum(np.minimum(own, 15.0), (own + 1.0) / 8.0 - 1.0)
    if buffer in OF_EDGES:
        return replicates
    prior = prior_of(buffer)
    return replicates * (prior + own) ** 2 / (prior**2 / 8.0 + own**2)


def prior_of(buffer: str) -> float:
    """Return the passes that a pixel's neighbours count for in errors of a buffer."""
    return PRIORS.get(buffer, PRIOR)


def widen_ratio(error: Image, ratio: Image, denominator: Image, denominator_error: Image) -> Image:
    """Return the error of a ratio whose denominator is uncertain, (H, W, N) all of them.

    The delta method is of first order, and too narrow where few samples met what is divided by: one
    alone has no spread. Then neighbours say how much samples differ. Where none met it, and the
    ratio is 0 for want of another value, it may be what they show.
    """
    relative = np.divide(
        denominator_error, denominator, out=np.zeros_like(error), where=denominator > 0.0
    )
    met = np.max([*_neighbours(denominator)], axis=0) > 0.0
    missed = met & (denominator == 0.0) & (ratio == 0.0)
    shown = np.where(missed, 1.0, OF_CONTRAST * np.minimum(relative, 1.0)) * _contrast(ratio)
    widened = error * (1.0 + SECOND_ORDER * relative**2)
    return np.maximum(widened, shown).astype(np.float32)


def _around(variance: Image, value: Image, emits: NDArray[np.bool_] | None) -> Image:
    """Return the mean variance of those of eight neighbours that count, scaled; edges are doubled.

    All count for a pixel without variance, for others those that have one and show an emitter
    if it does, or none if it does not; its own if there are none.
    """
    norm = np.sqrt(value**2 + value.mean(axis=(0, 1), dtype=np.float64).astype(np.float32) ** 2)
    relative = np.divide(variance, norm, out=np.zeros_like(variance), where=norm > 0.0)
    varies = variance > 0.0
    total, count = np.zeros_like(variance), np.zeros(variance.shape, np.float32)
    kind = (np.zeros(value.shape[:2], bool) if emits is None else emits)[..., None]
    for shown, other in zip(_neighbours(relative), _neighbours(kind), strict=True):
        counts = (shown > 0.0) & ~(varies & (other != kind))
        total += np.where(counts, shown, np.float32(0.0))
        count += counts
    mean = total * norm / np.where(varies, np.maximum(count, 1.0), 8.0)
    return np.where(varies & (count == 0.0), variance, mean)


def _contrast(value: Image) -> Image:
    """Return the largest difference to one of eight neighbours."""
    contrast = np.zeros_like(value)
    for other in _neighbours(value):
        np.maximum(contrast, np.abs(other - value), out=contrast)
    return contrast


def _neighbours(image: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Give the eight neighbours of all pixels, the image's edges doubled."""
    height, width = image.shape[:2]
    edged = np.pad(image, ((1, 1), (1, 1), (0, 0)), mode="edge")
    for row in range(3):
        for column in range(3):
            if (row, column) != (1, 1):
                yield edged[row:, column:][:height, :width]
