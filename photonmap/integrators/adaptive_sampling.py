"""How many samples later passes take, and where: decided by the first ones, without bias.

**Where.** Passes form two halves, those of even and those of odd number; after the first ones,
every other replicate. The variance of direct and of indirect light that passes of one half show
decides on the light samples and gather rays of later ones of the other: no pass is planned by its
own numbers, so each replicate is an unbiased estimate, uncorrelated with the rest, and their plain
mean and spread stay honest.

**How many.** A render needs `LEAST_PASSES` before it can trust its own error. Where that many full
passes would be more work than the goal needs, passes take a half of the samples or less. The first
ones, of an eighth, tell. If these turn out too small, they are discarded, and only decide where the
next ones take samples.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.film.budget import (
    ENOUGH_PHOTONS,
    LEAST_PASSES,
    LEAST_PHOTONS,
    Goal,
    share_on_edges,
)
from photonmap.film.relative_error import relative_squares
from photonmap.film.surface_filter import Surfaces
from photonmap.integrators.sampling_plan import SAMPLES
from photonmap.kernels.core.passes import (
    FLUORESCENT_DIRECT,
    FLUORESCENT_INDIRECT,
    VIA_DIRECT,
    VIA_INDIRECT,
    Estimate,
    Film,
    SamplingPlan,
)
from photonmap.kernels.film.pixels import FLAT
from photonmap.runtime.storage import RAM, Storage, strips

WINDOWS = {4: 5, 8: 3}
"""After how many passes sampling is decided on, and over squares of how many pixels a side the
variances that they show are averaged for it"""
LEAST, MOST = -1, 2
"""Log2 of the factor on the samples of a pixel, at least and at most."""
MOST_SAMPLES = 128
"""Samples of one kind in a pixel, at most."""
GATHER_COST = 0.6
"""What a gather ray is taken to cost, in light samples: what renders best, not its time."""
POWER = 1.5
"""Power with which variance falls as samples rise: by more than 1, as they are stratified."""
LEFT = 0.3
"""Of the variance of a flat pixel, where light is filtered: about what that leaves"""
WORTH = 1.05
"""Factor by which the variance must fall for sampling to adapt."""
STEPS = 16
"""Steps of a factor of 2 in which `_share_out` counts needs."""


class AdaptiveSampling:
    """Learns from the first passes where samples are needed.

    Where light is to be filtered, `surfaces` tells which pixels are flat: these need fewer.
    """

    def __init__(
        self,
        film: Film,
        columns: SpectralColumns,
        storage: Storage = RAM,
        surfaces: Surfaces | None = None,
    ) -> None:
        pixels = film.width * film.height
        self._film, self._columns, self._surfaces = film, columns, surfaces
        self.moments = storage.zeros((2, 5, pixels))
        """Of either half, of means over bands: sums of radiance; direct and indirect light of the
        first pass of a pair; sums of squared differences of pairs, times the factor on samples"""
        self.sample_scales = storage.zeros((2, 2, pixels), np.int8)
        """Of later passes of either half: log2 of the factors on light samples and gather rays"""

    def learn(self, index: int, estimate: Estimate, plan: SamplingPlan) -> None:
        """Take in pass `index`; after some of the first ones, decide anew."""
        if index >= max(WINDOWS):
            return
        half, is_second = index % 2, index // 2 % 2
        radiance, last, squares = np.split(self.moments[half], (1, 3))
        for part in strips(len(estimate.pixels.direct)):
            light = self._light(estimate, part)
            radiance[:, part] += light.sum(axis=0)
            if is_second:
                factor = np.float32(2.0) ** self.sample_scales[half, :, part]
                squares[:, part] += factor * (light - last[:, part]) ** 2
            else:
                last[:, part] = light
        if (passes := index + 1) in WINDOWS:
            cost = _costs(plan, estimate.pixels.coverage)
            for half in range(2):
                variance = self._variance(self.moments[1 - half], WINDOWS[passes])
                self.sample_scales[half] = _decide(variance, cost)

    def begin_again(self, estimate: Estimate, plan: SamplingPlan) -> None:
        """Forget the pilot passes, of which an estimate was the last, but decide by them at first.

        They are two: one of each half.
        """
        one, two = self.moments
        pilot = np.concatenate([one[:1] + two[:1], one[1:3], (one[1:3] - two[1:3]) ** 2])
        variance = self._variance(pilot, max(WINDOWS.values()))
        self.sample_scales[:] = _decide(variance, _costs(plan, estimate.pixels.coverage))
        self.moments[:] = 0.0

    def _light(self, estimate: Estimate, part: slice) -> NDArray[np.float32]:
        """Return the means over bands of direct and indirect light, (2, P); not of caustics."""
        pixels, via = estimate.pixels, estimate.via_specular
        light = np.stack([pixels.direct[part], pixels.indirect[part]])
        if via is not None:
            light += via[[VIA_DIRECT, VIA_INDIRECT], part]
            if len(via) > FLUORESCENT_INDIRECT:
                light += via[[FLUORESCENT_DIRECT, FLUORESCENT_INDIRECT], part]
        weights = self._columns.weights / self._columns.weights.sum()
        return np.einsum("kpb,b->kp", self._columns.whole(light), weights.astype(np.float32))

    def _variance(self, moments: NDArray[np.float32], window: int) -> NDArray[np.float32]:
        """Return the relative variances of direct and indirect light, (2, P), but for a factor."""
        radiance, image = moments[0], (self._film.height, self._film.width)
        variance = np.empty((2, len(radiance)), np.float32)
        for squares, target in zip(moments[3:], variance, strict=True):
            relative = relative_squares(squares, radiance, radiance.mean()).reshape(image)
            uniform_filter(relative, window, target.reshape(image), mode="nearest")
        if self._surfaces is not None:
            variance[:, self._surfaces()[:, FLAT] != 0.0] *= np.float32(LEFT)
        return variance


def _decide(variance: NDArray[np.float32], cost: NDArray[np.float32]) -> NDArray[np.int8]:
    """Return the log2 scales that lower variance most for the same cost: all (2, P).

    At the least sum of variance · s⁻ᵖ + cost · s, the scale s is ∝ (variance / cost)^(1/(1+p)).
    """
    need = np.log2(np.maximum(variance, 1e-30) / np.maximum(cost, 1e-30)) / (1.0 + POWER)
    sample_scales = _share_out(need, cost)
    if variance.sum() < WORTH * (variance * np.float32(2.0) ** -sample_scales).sum():
        return np.zeros_like(sample_scales)
    return sample_scales


def _share_out(need: NDArray[np.floating], cost: NDArray[np.floating]) -> NDArray[np.int8]:
    """Round `need` plus a constant to powers that cost as much in all as before, or less."""
    levels = np.rint(need * STEPS).astype(np.int32)
    first = int(levels.min())
    places = np.arange(first, int(levels.max()) + 1)
    costs = np.zeros(len(places))
    for part in strips(levels.shape[1]):
        costs += np.bincount((levels[:, part] - first).ravel(), cost[:, part].ravel(), len(places))

    def powers(levels: NDArray, shift: int) -> NDArray:
        return np.clip((levels + shift + STEPS // 2) // STEPS, LEAST, MOST)

    low, high = LEAST * STEPS - int(places[-1]), MOST * STEPS - first
    while high - low > 1:
        middle = (low + high) // 2
        is_cheap = (costs * 2.0 ** powers(places, middle)).sum() <= costs.sum()
        low, high = (middle, high) if is_cheap else (low, middle)
    return powers(levels, low).astype(np.int8)


def _costs(plan: SamplingPlan, coverage: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return what direct and indirect light of pixels cost, (2, P), in light samples."""
    hits = plan.samples * coverage
    return np.stack([plan.samples + hits * plan.lights, GATHER_COST * hits * plan.gathers])


def scale_plan(plan: SamplingPlan, sample_scales: NDArray[np.int8], spreads: bool) -> SamplingPlan:
    """Return a plan with more or fewer light samples and gather rays, by log2 scales (2, P).

    Where camera samples differ, there are more of these, as light samples call for, but not beyond
    gather rays. There are never fewer, which reflectance and emission would suffer from.
    """
    counts = [np.empty_like(part) for part in (plan.samples, plan.lights, plan.gathers)]
    for part in strips(len(plan.samples)):
        lights, gathers = 2.0 ** sample_scales[:, part].astype(np.float32)
        samples = plan.samples[part].astype(np.float32)
        all_lights = lights * samples * plan.lights[part]
        all_gathers = gathers * samples * plan.gathers[part]
        if spreads:
            fewest = np.where(all_gathers > 0.0, np.minimum(all_lights, all_gathers), all_lights)
            most = np.minimum(np.maximum(samples, fewest), MOST_SAMPLES)
            samples = np.clip(lights * samples, samples, most)
        counts[0][part] = samples
        for count, wanted in zip(counts[1:], (all_lights, all_gathers), strict=True):
            count[part] = np.where(wanted > 0.0, np.clip(wanted / samples, 1.0, MOST_SAMPLES), 0.0)
    return plan._replace(samples=counts[0], lights=counts[1], gathers=counts[2])


PILOT_PASSES = 2
"""Passes after which the size of the others is chosen."""
LOOSE = 0.01
"""Error from which on a goal is worth the pilot passes."""
COSTS = {0.125: (0.3, 1.0), 0.25: (0.36, 0.55), 0.5: (0.56, 0.28), 1.0: (1.0, 0.15)}
"""By fractions of the usual samples: the time of a pass over that of a full one, and the passes
needed over those of eighths. About what they are in the Cornell box and `studio`, 128×128."""
COSTS_OF_MANY = {0.125: (0.48, 1.0), 0.25: (0.52, 0.7), 0.5: (0.72, 0.43), 1.0: (1.0, 0.3)}
"""The same where emitters are many: `kitchen`, `living_room` and `vase`,
160×120."""
LEAST_LIGHTS = 16
"""Light samples of a pixel that has more in a full pass, since emitters are many, wide or hidden in
part: fewer leave some out, so that variance falls with the square of their number or faster."""
LEAST_SHARE, PER_EMITTER = 0.25, 2
"""Of light samples elsewhere, and how many there are for each emitter, up to `LEAST_LIGHTS`."""
MOST_LIGHTS = 4
"""Light samples of a pixel up to which one camera sample serves all; more are for penumbrae."""
PHOTONS = 2
"""Photons of a pass, over the usual ones and the fraction of samples, as long as both are few."""


def first_size(goal: Goal | None) -> float:
    """Return the size of the first passes of a render that aims at an error, or at none."""
    return min(COSTS) if goal is not None and goal.limit >= LOOSE else 1.0


def are_many(emitters: int) -> bool:
    """Return whether so many emitters call for as many light samples as small passes keep."""
    return PER_EMITTER * emitters >= LEAST_LIGHTS


def choose_size(needed: float, many: bool = False) -> float:
    """Return the size of passes that costs least, where so many eighths would meet the goal.

    There are `many` emitters, or not.
    """
    costs = COSTS_OF_MANY if many else COSTS
    if not math.isfinite(needed):
        return 1.0

    def time(size: float) -> float:
        seconds, passes = costs[size]
        return seconds * max(needed * passes, LEAST_PASSES)

    return min(costs, key=time)


def photons_of(photons: int, size: float) -> int:
    """Return how many photons a pass of some size emits, where a full one emits `photons`."""
    more = max(photons, min(PHOTONS * photons, ENOUGH_PHOTONS))
    return max(int(min(more * size, photons)), min(photons, LEAST_PHOTONS))


def resize(plan: SamplingPlan, size: float, flat: NDArray[Any], emitters: int) -> SamplingPlan:
    """Return a plan with fewer samples of the camera, or where these are few, of everything.

    Pixels that are not `flat`, (P,), share no light and are not filtered: of theirs,
    `share_on_edges` is kept. Where edges of shadows or specular surfaces may cross a pixel, half of
    those of the camera are; of light samples `LEAST_LIGHTS`, where there are more, and else
    `LEAST_SHARE` or `PER_EMITTER`.
    """
    if size == 1.0:
        return plan
    samples, lights, gathers = (
        np.empty_like(counts) for counts in (plan.samples, plan.lights, plan.gathers)
    )
    for part in strips(len(samples)):
        usual = plan.samples[part]
        wanted = usual * np.where(flat[part] == 0.0, share_on_edges(size), size)
        is_uneven = (usual > SAMPLES) | (wanted * plan.lights[part] > MOST_LIGHTS)
        samples[part] = np.maximum(np.where(is_uneven, np.maximum(wanted, 0.5 * usual), wanted), 1)
        rest = wanted / samples[part]
        lights[part] = _scaled(plan.lights[part], rest)
        all_lights = usual.astype(np.float32) * plan.lights[part]
        least = np.maximum(LEAST_SHARE * all_lights, min(PER_EMITTER * emitters, LEAST_LIGHTS))
        least = np.where(all_lights > LEAST_LIGHTS, LEAST_LIGHTS, np.minimum(least, all_lights))
        lights[part] = np.maximum(lights[part], np.ceil(least / samples[part]))
        gathers[part] = _scaled(plan.gathers[part], rest)
    return plan._replace(samples=samples, lights=lights, gathers=gathers)


def _scaled(counts: NDArray[np.uint8], factor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return scaled counts, of which none becomes 0 that was not."""
    return np.ceil(counts * factor)
