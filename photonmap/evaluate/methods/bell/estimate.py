"""The rounds of Bell's method; the package's docstring has the equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.bell.lattice import GaussianKernel
from photonmap.evaluate.methods.bell.regions import connected_regions, matched_intensities
from photonmap.evaluate.methods.clusters import first_means, means_of, nearest_means
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.metrics.arrays import Floats, Mask

_CLUSTERS = 20
_POSITION, _INTENSITY, _CHROMATICITY = 0.1, 0.1, 0.025
"""θ_p, θ_l and θ_c."""
_INTENSITY_SCALE = 0.5
"""Weight of intensity where clusters are found."""
_BLUR = 0.1
_GREY = 0.5
_WHITE = 99.0
"""Percentile of intensity that is 1 for all these numbers."""
_STEPS = 10
"""Largest number of steps of mean field in a round."""
_SETTLED = 1e-3
"""Change of all probabilities below which mean field ends."""
_KMEANS_ROUNDS = 20

_Labels = NDArray[np.int64]


class _Reflectances(NamedTuple):
    """The L reflectances among which pixels choose."""

    log_intensity: Floats
    """(L,)"""
    log_chromaticity: Floats
    """(L, C) of bands over their mean"""


def estimate(view: View, rounds: float, pairwise: float, smooth: float, level: float) -> Estimate:
    """Return the decomposition after some rounds, for weights w_p, w_s and w_l."""
    mask = view.mask
    white = np.percentile(view.grey[mask], _WHITE)
    image = np.maximum(view.image / white, FLOOR)
    intensity = image.mean(axis=-1)
    colors = image[mask]
    log_intensity = np.log(intensity[mask])
    kernel = GaussianKernel(_features(image, mask))
    reflectances = _first_reflectances(colors)
    count = round(rounds)
    shading = np.zeros(mask.shape)
    for index in range(count):
        log_shading = log_intensity[:, None] - reflectances.log_intensity
        costs = level * np.abs(log_shading - np.log(_GREY))
        if index > 0:
            target = _blurred(shading, mask, _BLUR * np.hypot(*mask.shape) / (index + 1))
            costs += smooth * (log_shading - target[mask][:, None]) ** 2
        labels = _likely_labels(costs, pairwise * _distances(reflectances), kernel)
        chosen = np.full(mask.shape, -1, np.int64)
        chosen[mask] = labels
        regions, start = chosen, reflectances.log_intensity
        if index == count - 1:
            regions = connected_regions(chosen)
            start = np.zeros(regions.max() + 1)
            start[regions[mask]] = reflectances.log_intensity[labels]
        matched = matched_intensities(np.log(intensity), regions, start)
        shading = np.where(mask, np.log(intensity) - matched[regions], 0.0)
        reflectances = reflectances._replace(log_intensity=matched)
    return with_grey_shading(view, np.exp(shading))


def _features(image: Floats, mask: Mask) -> Floats:
    """Return f (P, 2 + C): position, intensity and all chromaticities but one."""
    height, width = mask.shape
    place = np.argwhere(mask) / (_POSITION * np.hypot(height, width))
    intensity = image.mean(axis=-1)[mask] / _INTENSITY
    chromaticity = _chromaticities(image[mask])[:, :-1] / _CHROMATICITY
    return np.column_stack([place, intensity, chromaticity])


def _chromaticities(colors: Floats) -> Floats:
    """Return colours (P, C) with a sum of 1."""
    return np.asarray(colors / colors.sum(axis=-1, keepdims=True))


def _first_reflectances(colors: Floats) -> _Reflectances:
    """Return the cluster means of colours (P, C), in intensity and chromaticity."""
    chromaticity = _chromaticities(colors)
    points = np.column_stack([_INTENSITY_SCALE * colors.mean(axis=-1), chromaticity])
    means = first_means(points, _CLUSTERS)
    for _ in range(_KMEANS_ROUNDS):
        means = means_of(points, nearest_means(points, means), means)
    bands = colors.shape[1]
    return _Reflectances(np.log(means[:, 0] / _INTENSITY_SCALE), np.log(bands * means[:, 1:]))


def _distances(reflectances: _Reflectances) -> Floats:
    """Return |log R_x − log R_y|_1 of all pairs of reflectances (L, L)."""
    logs = reflectances.log_intensity[:, None] + reflectances.log_chromaticity
    return np.abs(logs[:, None] - logs).sum(axis=-1)


def _likely_labels(costs: Floats, distances: Floats, kernel: GaussianKernel) -> _Labels:
    """Return the labels (P,) that mean field finds most likely.

    Parameters
    ----------
    costs : (P, L) of each label, without pairs
    distances : (L, L) costs of pairs of labels, times the kernel
    """
    likely = _softmax(-costs)
    for _ in range(_STEPS):
        moved = _softmax(-costs - kernel.apply(likely) @ distances)
        settled = np.abs(moved - likely).max() < _SETTLED
        likely = moved
        if settled:
            break
    return np.asarray(likely.argmax(axis=1), np.int64)


def _softmax(logs: Floats) -> Floats:
    """Return probabilities (P, L) whose logarithms differ from `logs` by a constant."""
    powers = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(powers / powers.sum(axis=1, keepdims=True))


def _blurred(image: Floats, mask: Mask, sigma: float) -> Floats:
    """Return an image (H, W) averaged by a Gaussian over the pixels of a mask."""
    from scipy.ndimage import gaussian_filter

    weight = gaussian_filter(mask.astype(np.float64), sigma)
    return gaussian_filter(np.where(mask, image, 0.0), sigma) / np.where(mask, weight, 1.0)


METHOD = Method("bell", estimate, {"rounds": 25.0, "pairwise": 1e4, "smooth": 2e4, "level": 500.0})
