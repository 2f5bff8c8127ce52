"""Sums over all pairs of points, weighted by a Gaussian, in time linear in their number.

A. Adams, J. Baek and M. A. Davis, "Fast high-dimensional filtering using the permutohedral
lattice", Eurographics 2010. Values at points in d dimensions are spread to the d + 1 corners of
the simplex around each, blurred along the d + 1 directions of the lattice, and gathered again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats

_Keys = NDArray[np.int64]
_Codes = NDArray[np.uint64]


class GaussianKernel:
    """The matrix k_ij = exp(−|f_i − f_j|² / 2), up to a factor, scaled to D^−½ k D^−½.

    Parameters
    ----------
    features : (P, d) f
    """

    def __init__(self, features: Floats) -> None:
        from scipy.sparse import csr_array

        points, dimensions = features.shape
        corners, shares = _corners(features)
        nodes, node_of = np.unique(_codes(corners), return_inverse=True)
        rows = np.repeat(np.arange(points), dimensions + 1)
        entries = (shares.ravel(), (rows, node_of.ravel()))
        self._gather = csr_array(entries, shape=(points, len(nodes)))
        self._spread = csr_array(self._gather.T)
        self._blurs = [_blur(nodes, step) for step in _codes(_directions(dimensions))]
        self._scale = np.ones((points, 1))
        self._scale = 1.0 / np.sqrt(self.apply(self._scale))

    def apply(self, values: Floats) -> Floats:
        """Return the weighted sums of values (P, L) over all points, for each point."""
        nodes = self._spread @ (self._scale * values)
        for blur in self._blurs:
            nodes = blur @ nodes
        return np.asarray(self._scale * (self._gather @ nodes))


def _corners(features: Floats) -> tuple[_Keys, Floats]:
    """Return the simplex around each point: corners (P, d + 1, d) and shares (P, d + 1).

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
    shares = np.empty((points, d + 1))
    shares[:, 1:] = (sorted_rest[:, :-1] - sorted_rest[:, 1:])[:, ::-1]
    shares[:, 0] = 1.0 - shares[:, 1:].sum(axis=1)
    remainder = np.arange(d + 1)[None, :, None]
    wraps = rank[:, None, :] > d - remainder
    corners = origin[:, None, :] + remainder - (d + 1) * wraps
    return corners[..., :d], shares


def _directions(d: int) -> _Keys:
    """Return the steps from a node to its neighbours ahead, (d + 1, d)."""
    return (d + 1) * np.eye(d + 1, d, dtype=np.int64) - 1


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
    place = np.minimum(np.searchsorted(nodes, wanted), count - 1)
    there = np.flatnonzero(nodes[place] == wanted)
    ahead = csr_array((np.full(len(there), 0.25), (there, place[there])), shape=(count, count))
    return csr_array(0.5 * eye_array(count) + ahead + ahead.T)
