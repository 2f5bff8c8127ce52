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
chromaticity is that of all bands, C − 1 of them; the 99th percentile of intensity is 1; clusters
start from splits at medians; stage 2 is solved by ten rounds of reweighted least squares and keeps
the median of log reflectance; mean field stops early where no probability moves by 0.001.

**The kernel** sums over all pairs of points in time linear in their number: A. Adams, J.
Baek and M. A. Davis, "Fast high-dimensional filtering using the permutohedral lattice",
Eurographics 2010. Values at points in d dimensions are spread to the d + 1 corners of the simplex
around each, blurred along the d + 1 directions of the lattice, and gathered again.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.gehler import first_means, means_of, nearest_means
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import neighbours
from photonmap.evaluate.metrics.arrays import Floats, Mask, blurred_within

_Keys = NDArray[np.int64]
_Codes = NDArray[np.uint64]


class GaussianKernel:
    """The matrix k_ij = exp(−|f_i − f_j|² / 2) for f (P, d), up to a factor, as D^−½ k D^−½."""

    def __init__(self, features: Floats) -> None:
        from scipy.sparse import csr_array

        points, dimensions = features.shape
        corners, weights = _corners(features)
        nodes, node_of = np.unique(_codes(corners), return_inverse=True)
        rows = np.repeat(np.arange(points), dimensions + 1)
        entries = (weights.ravel(), (rows, node_of.ravel()))
        self._gather = csr_array(entries, shape=(points, len(nodes)))
        self._spread = csr_array(self._gather.T)
        ahead = (dimensions + 1) * np.eye(dimensions + 1, dimensions, dtype=np.int64) - 1
        self._blurs = [_blur(nodes, step) for step in _codes(ahead)]
        self._scale = np.ones((points, 1))
        self._scale = 1.0 / np.sqrt(self.apply(self._scale))

    def apply(self, values: Floats) -> Floats:
        """Return the weighted sums of values (P, L) over all points, for each point."""
        nodes = self._spread @ (self._scale * values)
        for blur in self._blurs:
            nodes = blur @ nodes
        return np.asarray(self._scale * (self._gather @ nodes))


def _corners(features: Floats) -> tuple[_Keys, Floats]:
    """Return the simplex around each point: corners (P, d + 1, d) and weights (P, d + 1).

    Points are moved to the hyperplane Σ x = 0 in d + 1 dimensions, where corners have integer
    coordinates that all leave the same remainder by d + 1.
    """
    points, d = features.shape
    axis = np.arange(1, d + 1)
    # Blurring has a variance of (d + 1)² / 2 on the lattice, spreading and gathering (d + 1)² / 6
    scaled = features * ((d + 1) * np.sqrt(2.0 / 3.0) / np.sqrt(axis * (axis + 1.0)))
    above = np.cumsum(scaled[:, ::-1], axis=1)[:, ::-1]
    raised = np.zeros((points, d + 1))
    raised[:, :d] = above
    raised[:, 1:] -= axis * scaled
    origin = np.rint(raised / (d + 1)).astype(np.int64) * (d + 1)
    excess = origin.sum(axis=1) // (d + 1)
    order = np.argsort(-(raised - origin), axis=1, kind="stable")
    rank = np.argsort(order, axis=1, kind="stable") + excess[:, None]
    turns = (rank < 0).astype(np.int64) - (rank > d)
    rank += turns * (d + 1)
    origin += turns * (d + 1)
    sorted_rest = np.take_along_axis(raised - origin, np.argsort(rank, axis=1), axis=1) / (d + 1)
    weights = np.empty((points, d + 1))
    weights[:, 1:] = (sorted_rest[:, :-1] - sorted_rest[:, 1:])[:, ::-1]
    weights[:, 0] = 1.0 - weights[:, 1:].sum(axis=1)
    remainder = np.arange(d + 1)[None, :, None]
    wraps = rank[:, None, :] > d - remainder
    corners = origin[:, None, :] + remainder - (d + 1) * wraps
    return corners[..., :d], weights


def _codes(corners: _Keys) -> _Codes:
    """Return a number for each node (…, d), linear in its coordinates and modulo 2^64.

    Two of n nodes share a number with a probability of about n² / 2^65.
    """
    odd = np.full(corners.shape[-1], 0x9E3779B97F4A7C15, np.uint64).cumprod()
    return np.asarray((corners.astype(np.uint64) * odd).sum(axis=-1))


def _blur(nodes: _Codes, step: np.uint64) -> Any:
    """Return the matrix that averages each node, ½, with the two `step` away, ¼ each."""
    from scipy.sparse import csr_array, eye_array

    count = len(nodes)
    wanted = nodes + step
    index = np.minimum(np.searchsorted(nodes, wanted), count - 1)
    there = np.flatnonzero(nodes[index] == wanted)
    ahead = csr_array((np.full(len(there), 0.25), (there, index[there])), shape=(count, count))
    return csr_array(0.5 * eye_array(count) + ahead + ahead.T)


_Labels = NDArray[np.int64]

_REWEIGHTED = 10  # Of reweighted least squares
_LEAST_RESIDUAL = 1e-3  # Residual of log shading below which weights stay the same
_HOLD = 1e-6  # Weight that holds intensities where they were, for regions that touch no other


def connected_regions(labels: _Labels) -> _Labels:
    """Return the numbers of 4-connected parts of equal labels (H, W); −1 for negative labels."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    second, first = neighbours(np.ones(labels.shape, bool))
    same = labels.ravel()[first] == labels.ravel()[second]
    links = (np.ones(same.sum()), (first[same], second[same]))
    _, parts = connected_components(coo_array(links, shape=(labels.size,) * 2), directed=False)
    inside = labels.ravel() >= 0
    regions = np.full(labels.size, -1, np.int64)
    regions[inside] = np.unique(parts[inside], return_inverse=True)[1]
    return regions.reshape(labels.shape)


def matched_intensities(log_image: Floats, regions: _Labels, start: Floats) -> Floats:
    """Return log intensities of regions that lower Σ |log s_i − log s_j| across their borders.

    The log image is (H, W), and so are the numbers of regions, negative where there is none; the
    median over pixels stays that of the log intensities (R,) to start from.
    """
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.linalg import spsolve

    second, first = neighbours(np.ones(regions.shape, bool))
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


_CLUSTERS = 20
_POSITION, _INTENSITY, _CHROMATICITY = 0.1, 0.1, 0.025
"""θ_p, θ_l and θ_c."""
_INTENSITY_SCALE = 0.5  # Weight of intensity where clusters are found
_BLUR = 0.1
_GREY = 0.5
_WHITE = 99.0  # Percentile of intensity that is 1 for all these numbers
_STEPS = 10  # Largest number of steps of mean field in a round
_SETTLED = 1e-3  # Change of all probabilities below which mean field ends
_KMEANS_ROUNDS = 20


class _Reflectances(NamedTuple):
    """The L reflectances among which pixels choose."""

    log_intensity: Floats  # (L,)
    log_chromaticity: Floats  # (L, C) of bands over their mean


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
            sigma = _BLUR * np.hypot(*mask.shape) / (index + 1)
            target = blurred_within(shading[..., None], mask, sigma)[..., 0]
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
    position = np.argwhere(mask) / (_POSITION * np.hypot(height, width))
    intensity = image.mean(axis=-1)[mask] / _INTENSITY
    chromaticity = _chromaticities(image[mask])[:, :-1] / _CHROMATICITY
    return np.column_stack([position, intensity, chromaticity])


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

    Costs (P, L) are those of each label, without pairs; distances (L, L) those of pairs of labels,
    times the kernel.
    """
    from scipy.special import softmax

    likely = softmax(-costs, axis=1)
    for _ in range(_STEPS):
        moved = softmax(-costs - kernel.apply(likely) @ distances, axis=1)
        settled = np.abs(moved - likely).max() < _SETTLED
        likely = moved
        if settled:
            break
    return np.asarray(likely.argmax(axis=1), np.int64)


METHODS = (
    Method("bell", estimate, {"rounds": 25.0, "pairwise": 1e4, "smooth": 2e4, "level": 500.0}),
)
