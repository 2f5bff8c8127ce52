"""Bell's random field: pixels that are alike, wherever they are, share few reflectances.

S. Bell, K. Bala and N. Snavely, "Intrinsic images in the wild", SIGGRAPH 2014. Each pixel has one
of 20 reflectances R_x, cluster means of the image's intensity (times 0.5) and chromaticity; its
shading is grey, s_i = |I_i| / |R_x|, with |·| the mean over bands. The energy of labels x is

    E(x) = w_p Σ_{i<j} ψ_ij + w_s Σ_i ψ_i + w_l Σ_i λ_i
    ψ_ij = |log R_xi − log R_xj|_1 exp(−|f_i − f_j|² / 2)
    f_i = (position / (θ_p d), |I_i| / θ_l, chromaticity / θ_c)
    ψ_i = (log s_i − log s̄_i)²,  λ_i = |log s_i − log ½|

over all pairs of pixels, d being the image's diagonal. s̄ is the shading of the round before,
blurred by 0.1 d / round; the first round has no ψ_i. Rounds have two stages. (1) Ten steps of mean
field, in which the kernel is filtered on a permutohedral lattice and normalised symmetrically
(Krähenbühl and Koltun 2013), lower E. (2) With labels held, the intensities of reflectances
change to lower Σ |log s_i − log s_j| over neighbours whose labels differ; in the last round each
connected region has an intensity of its own.

Weights are those that the authors state for their best result on their photographs: 25 rounds,
w_p = 10000, w_s = 20000, w_l = 500, θ_p = θ_l = 0.1, θ_c = 0.025. Left open, and chosen here:
chromaticity is that of all bands, C − 1 of them; the 99th percentile
of intensity is 1; clusters start from splits at medians; stage 2
is solved by ten rounds of reweighted least squares and keeps the median of log reflectance; mean
field stops early where no probability moves by 0.001.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.clusters import first_means, means_of, nearest_means
from photonmap.evaluate.methods.lattice import GaussianKernel
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.metrics.arrays import Floats, Mask

_Labels = NDArray[np.int64]

_REWEIGHTED = 10
"""Of reweighted least squares."""
_LEAST_RESIDUAL = 1e-3
"""Residual of log shading below which weights stay the same."""
_HOLD = 1e-6
"""Weight that holds intensities where they were, for regions that touch no other."""


def connected_regions(labels: _Labels) -> _Labels:
    """Return the numbers of 4-connected parts of equal labels (H, W); −1 for negative labels."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = _neighbours(np.arange(labels.size).reshape(labels.shape))
    same = labels.ravel()[first] == labels.ravel()[second]
    links = (np.ones(same.sum()), (first[same], second[same]))
    _, parts = connected_components(coo_array(links, shape=(labels.size,) * 2), directed=False)
    inside = labels.ravel() >= 0
    regions = np.full(labels.size, -1, np.int64)
    regions[inside] = np.unique(parts[inside], return_inverse=True)[1]
    return regions.reshape(labels.shape)


def matched_intensities(log_image: Floats, regions: _Labels, start: Floats) -> Floats:
    """Return log intensities of regions that lower Σ |log s_i − log s_j| across their borders.

    Parameters
    ----------
    log_image : (H, W)
    regions : (H, W) numbers of regions, negative where there is none
    start : (R,) log intensities; the median over pixels stays that of these
    """
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.linalg import spsolve

    first, second = _neighbours(np.arange(regions.size).reshape(regions.shape))
    of = regions.ravel()
    across = (of[first] >= 0) & (of[second] >= 0) & (of[first] != of[second])
    a, b = of[first[across]], of[second[across]]
    step = (log_image.ravel()[first] - log_image.ravel()[second])[across]
    count = len(start)
    found = start
    for _ in range(_REWEIGHTED):
        weight = 1.0 / np.maximum(np.abs(step - found[a] + found[b]), _LEAST_RESIDUAL)
        degree = np.bincount(a, weight, count) + np.bincount(b, weight, count) + _HOLD
        links = coo_array((np.tile(weight, 2), (np.append(a, b), np.append(b, a))), (count,) * 2)
        wanted = np.bincount(a, weight * step, count) - np.bincount(b, weight * step, count)
        matrix = (diags_array(degree) - links).tocsc()
        found = np.atleast_1d(spsolve(matrix, wanted + _HOLD * start))
    inside = of[of >= 0]
    return np.asarray(found + np.median(start[inside]) - np.median(found[inside]))


def _neighbours(numbers: _Labels) -> tuple[_Labels, _Labels]:
    """Return the numbers of pixels (H, W) and of those below and to the right of them."""
    first = np.concatenate([numbers[:-1].ravel(), numbers[:, :-1].ravel()])
    return first, np.concatenate([numbers[1:].ravel(), numbers[:, 1:].ravel()])


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


METHODS = (
    Method("bell", estimate, {"rounds": 25.0, "pairwise": 1e4, "smooth": 2e4, "level": 500.0}),
)
