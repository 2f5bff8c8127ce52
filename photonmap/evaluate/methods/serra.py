"""Names and shades of colour: pixels that share one of them share reflectance. Our reading.

M. Serra, O. Penacchio, R. Benavente and M. Vanrell, "Names and shades of color for intrinsic image
estimation", CVPR 2012. Only the abstract of this paper could be read. It says that two descriptors
of surfaces, the name of a colour and its shade, the latter "capturing gradual color surface
variations" that follow from how images form, are combined in a Markov random field. Both
descriptors were published before by the same group, and are built from there:

- names: the parametric fuzzy sets of Benavente, Vanrell and Baldrich 2008 (`color_descriptors`)
- shades: ridges of the histogram of colours, by Vazquez et al. 2011 (`color_descriptors`)

How the field combines them is ours. With l = log I of grey values, log reflectance r minimises

    E(r, ρ) = Σ_{i~j} (r_i − r_j − (1 − a_ij) (l_i − l_j))² + λ Σ_i Σ_n μ_n(i) (r_i − ρ_{k(i),n})²
    a_ij = 1 if k(i) = k(j), else Σ_n min(μ_n(i), μ_n(j))

over neighbours i ~ j, the ridge k(i) of a pixel, and its memberships μ_n(i) in names n, which add
up to 1. Neighbours on one ridge, or of one name, have one reflectance, and what differs is shading;
for others, what differs is reflectance. All pixels of the image that share both ridge and name are
tied to one reflectance ρ, which is the same as to tie each two of them with weights
λ μ_n(i) μ_n(j) / Σ μ_n. Shading is grey. E is quadratic: its field is Gaussian, and a sparse linear
system gives its most likely state.

λ and the settings of ridges were chosen by LMSE on scenes with other seeds, in white light and in
that of two bulbs. Of other bands than RGB, thirds are averaged to blue, green and red. What this
method scores is not what the authors' code would.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.color_descriptors import memberships, ridge_numbers
from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import neighbours
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


_WHITE = 99.0
"""Percentile of grey values that names take for white."""


def estimate(view: View, tie: float) -> Estimate:
    """Return the decomposition for the weight λ of ties between pixels anywhere."""
    mask = view.mask
    grey = view.grey[mask]
    colors = _as_rgb(np.maximum(view.image[mask], FLOOR)) / np.percentile(grey, _WHITE)
    descriptors = Descriptors(ridge_numbers(colors), memberships(colors))
    log_image = np.log(grey)
    reflectance = log_reflectance(log_image, descriptors, neighbours(mask), tie)
    shading = np.ones(mask.shape)
    shading[mask] = np.exp(log_image - reflectance)
    return with_grey_shading(view, shading)


def _as_rgb(colors: Floats) -> Floats:
    """Return RGB (P, 3) of bands (P, C), which go from blue to red unless there are three."""
    bands = colors.shape[1]
    if bands == 3:
        return colors
    thirds = np.array_split(colors, 3, axis=1) if bands > 3 else [colors] * 3
    return np.stack([third.mean(axis=1) for third in reversed(thirds)], axis=1)


METHODS = (Method("serra", estimate, {"tie": 0.3}),)
