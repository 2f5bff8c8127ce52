"""The random field in which pixels that share names or shades share reflectance."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats

_LEAST_SHARE = 0.02
"""Memberships below this do not tie a pixel to a description."""
_HELD = 1e-9
"""Weight of log reflectances of 0, which decides the constant that all else leaves open."""


class Descriptors(NamedTuple):
    """What is known of the P pixels of a mask."""

    ridge: NDArray[np.int64]
    """(P,) number of the ridge, k"""
    names: Floats
    """(P, N) memberships μ, with a sum of 1"""


def log_reflectance(
    log_image: Floats, descriptors: Descriptors, pairs: NDArray[np.int64], tie: float
) -> Floats:
    """Return log reflectance (P,), which minimises the energy of the package's docstring.

    Parameters
    ----------
    log_image : (P,) log of grey values
    pairs : (2, E) neighbours, as `poisson.neighbours` returns them
    tie : weight λ of all pairs that share ridge and name
    """
    from scipy.sparse import csc_array, diags_array, vstack
    from scipy.sparse.linalg import splu

    count = len(log_image)
    second, first = pairs
    ties = _ties(descriptors, tie)
    steps = _incidence(second, first, np.ones(len(second)), count + ties.nodes)
    spokes = _incidence(ties.pixels, count + ties.ends, ties.weights, count + ties.nodes)
    system = csc_array(vstack([steps, spokes]))
    unlike = 1.0 - likeness(descriptors, pairs)
    wanted = np.concatenate(
        [unlike * (log_image[second] - log_image[first]), np.zeros(len(ties.pixels))]
    )
    matrix = system.T @ system + diags_array(np.full(count + ties.nodes, _HELD))
    factors = splu(
        csc_array(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factors.solve(system.T @ wanted)[:count])


def likeness(descriptors: Descriptors, pairs: NDArray[np.int64]) -> Floats:
    """Return a_ij of pairs (2, E): 1 where both have one ridge or one name, 0 where neither."""
    second, first = pairs
    ridge, names = descriptors
    one_name = np.minimum(names[second], names[first]).sum(axis=1)
    return np.where(ridge[second] == ridge[first], 1.0, one_name)


class _Ties(NamedTuple):
    """Pixels tied to the reflectances of descriptions, K of which exist."""

    pixels: NDArray[np.int64]
    """(T,)"""
    ends: NDArray[np.int64]
    """(T,) number of the description"""
    weights: Floats
    """(T,) square roots of the weights"""
    nodes: int
    """K"""


def _ties(descriptors: Descriptors, tie: float) -> _Ties:
    """Return the ties of pixels to pairs of a ridge and a name."""
    ridge, names = descriptors
    pixels, name = np.nonzero(names > _LEAST_SHARE)
    described, ends = np.unique(ridge[pixels] * names.shape[1] + name, return_inverse=True)
    return _Ties(pixels, ends, np.sqrt(tie * names[pixels, name]), len(described))


def _incidence(
    plus: NDArray[np.int64], minus: NDArray[np.int64], weights: Floats, width: int
) -> Any:
    """Return the sparse matrix of weighted differences between two entries each."""
    from scipy.sparse import csc_array

    rows = np.tile(np.arange(len(plus)), 2)
    columns = np.concatenate([plus, minus])
    values = np.concatenate([weights, -weights])
    return csc_array((values, (rows, columns)), shape=(len(plus), width))
