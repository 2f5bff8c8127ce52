"""Names and shades of colour: pixels that share one of them share reflectance. Our reading.

M. Serra, O. Penacchio, R. Benavente and M. Vanrell, "Names and shades of color for intrinsic image
estimation", CVPR 2012. Only the abstract of this paper could be read. It says that two descriptors
of surfaces, the name of a colour and its shade, the latter "capturing gradual color surface
variations" that follow from how images form, are combined in a Markov random field. Both
descriptors were published before by the same group, and are built from there:

- names: the parametric fuzzy sets of Benavente, Vanrell and Baldrich 2008
- shades: ridges of the histogram of colours, by Vazquez et al. 2011

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

**Names.** The degree to which each of the eleven basic colour names fits a colour.

R. Benavente, M. Vanrell and R. Baldrich, "Parametric fuzzy sets for automatic color naming",
Journal of the Optical Society of America A 25(10), 2008. In CIELAB, of which six ranges of
lightness have parameters of their own, a chromatic name is a wedge of hues outside of an ellipse
around grey:

    μ_name(p) = S(u_1, β_1) S(u_2, β_2) E(p),  S(u, β) = 1 / (1 + exp(−β u))
    E(p) = 1 / (1 + exp(−β_e ((v_1 / e_1)² + (v_2 / e_2)² − 1)))

where p = (a*, b*) from the ellipse's centre, v is p along its axes, and u_1 and u_2 are distances
from the two lines that bound the wedge; neighbouring wedges share theirs. What chromatic names
leave of 1 goes to black, grey and white by sigmoids of L*. `color_names.json` has the parameters,
which the authors fitted to how people named colours, as code of their group states them (nefesi, of
the Computer Vision Center in Barcelona); angles are in degrees. sRGB's own red and blue, far from
the samples that people named, are orange and purple by it.

**Ridges.** Ridges in the histogram of an image's colours: those of one surface, lighter and darker.

E. Vazquez, R. Baldrich, J. van de Weijer and M. Vanrell, "Describing reflectances for color
segmentation robust to shadows, highlights, and textures", PAMI 33(5), 2011 (ridge-based
distribution analysis). With H the histogram, smoothed at the scale of differentiation, and w the
first eigenvector of ∇H ∇Hᵀ, smoothed at the scale of integration, turned uphill, creaseness is

    κ = −div(w)

which is large on a ridge, however high it is (multilocal creaseness by the structure tensor, of
López, Lloret, Serrat and Villanueva 2000). Ridges flood the colours around them.

Chosen here: axes are square roots, which keep lines through black straight and give dark colours
more cells; H is a logarithm of counts; cells whose κ exceeds a threshold are ridges, and those that
touch are one, except near black, where all ridges meet; a colour belongs to the nearest ridge,
without a flood.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import factorised, neighbours, weighted_differences
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.spectra.color_difference import lab_of_xyz
from photonmap.spectra.observer import observer

CHROMATIC = ("red", "orange", "brown", "yellow", "green", "blue", "purple", "pink")
NAMES = (*CHROMATIC, "black", "grey", "white")
_BLACK, _WHITE = (28.28, 0.71), (79.65, 0.31)
"""L* at which grey becomes black and white, and how steeply."""


def memberships(colors: Floats) -> Floats:
    """Return how well each of `NAMES` fits colours (P, 3) in linear sRGB: (P, 11), with a sum of 1.

    Values are clipped to [0, 1]; 1 is white.
    """
    lab = lab_of_xyz(np.clip(colors, 0.0, 1.0) @ observer().rgb_to_xyz.T)
    found = np.zeros((len(lab), len(NAMES)))
    lightest = [level.lightness for level in _levels()][:-1]
    level_of = np.searchsorted(lightest, lab[:, 0])  # the first whose range ends above L*
    for number, level in enumerate(_levels()):
        within = level_of == number
        found[within, : len(CHROMATIC)] = _chromatic(lab[within, 1:], level)
    achromatic = np.maximum(1.0 - found.sum(axis=1), 0.0)
    black, white = (steep * (lab[:, 0] - middle) for middle, steep in (_BLACK, _WHITE))
    grades = _sigmoid(-black), _sigmoid(black) * _sigmoid(-white), _sigmoid(white)
    found[:, len(CHROMATIC) :] = achromatic[:, None] * np.stack(grades, axis=1)
    return found / found.sum(axis=1, keepdims=True)


class _Level(NamedTuple):
    """Parameters of a range of lightness; lengths are in CIELAB, angles in degrees."""

    lightness: float  # where the range ends
    center: tuple[float, float]  # of the ellipse around grey
    axes: tuple[float, float]  # e_1 and e_2
    tilt: float  # of the first axis from that of a*
    steepness: float  # β_e
    boundaries: list[tuple[str, float, float]]
    """of each name, its hue where it begins, with β; it ends where the next one begins"""


@cache
def _levels() -> tuple[_Level, ...]:
    """Return all ranges of lightness, the darkest first."""
    text = (files(__package__) / "color_names.json").read_text(encoding="utf-8")
    return tuple(_Level(**level) for level in json.loads(text))


def _chromatic(ab: Floats, level: _Level) -> Floats:
    """Return the memberships (P, 8) of colours a*, b* (P, 2) in one range of lightness."""
    shifted = ab - level.center
    tilt = np.radians(level.tilt)
    along = shifted @ np.array([(np.cos(tilt), -np.sin(tilt)), (np.sin(tilt), np.cos(tilt))])
    outside = _sigmoid(level.steepness * (((along / level.axes) ** 2).sum(axis=1) - 1.0))
    names, degrees, steepness = zip(*level.boundaries, strict=True)
    hues = np.radians(degrees)
    past = np.array(steepness) * (shifted @ np.stack([-np.sin(hues), np.cos(hues)]))
    wedges = _sigmoid(past) * _sigmoid(-np.roll(past, -1, axis=1))
    found = np.zeros((len(ab), len(CHROMATIC)))
    found[:, [CHROMATIC.index(name) for name in names]] = wedges * outside[:, None]
    return found


def _sigmoid(values: Floats) -> Floats:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(values, -700.0, 700.0))))


_CELLS = 64  # Along each axis
_BRIGHTEST = 99.5  # Percentile of the largest band at which the axes end
_MARGIN = 3  # Empty cells beyond each end
_DIFFERENTIATION, _INTEGRATION = 0.7, 1.0
"""Scales, in cells."""
_CREASED = 1.7  # Least κ of a ridge; it is at most 3
_DENSE = 0.5  # Least smoothed count of a ridge
_NEAR_BLACK = 0.3  # Share of an axis within which no cell is a ridge
_TOUCHING = np.ones((3, 3, 3), bool)


def ridge_numbers(colors: Floats) -> NDArray[np.int64]:
    """Return the ridge of each linear RGB colour (P, 3) above 0; 0 for all if there is none."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter, label

    brightest = float(np.percentile(colors.max(axis=1), _BRIGHTEST))
    coordinates = np.sqrt(np.clip(colors / brightest, 0.0, 1.0)) * (_CELLS - 1)
    cells = tuple(np.rint(coordinates).astype(np.int64).T + _MARGIN)
    counts = np.zeros((_CELLS + 2 * _MARGIN,) * 3)
    np.add.at(counts, cells, 1.0)
    density = gaussian_filter(counts, _DIFFERENTIATION)
    creaseness = _creaseness(np.log1p(density))
    from_black = np.linalg.norm(np.indices(counts.shape) - _MARGIN, axis=0) / _CELLS
    ridges = (creaseness > _CREASED) & (density > _DENSE) & (from_black > _NEAR_BLACK)
    numbers, count = label(ridges, _TOUCHING)
    if count == 0:
        return np.zeros(len(colors), np.int64)
    nearest = distance_transform_edt(~ridges, return_distances=False, return_indices=True)
    return np.asarray(numbers[tuple(nearest)][cells], np.int64)


def _creaseness(heights: Floats) -> Floats:
    """Return κ of a histogram (X, Y, Z), between −3 and 3."""
    from scipy.ndimage import gaussian_filter

    slopes = np.stack(list(np.gradient(heights)), axis=-1)
    tensor = slopes[..., :, None] * slopes[..., None, :]
    tensor = gaussian_filter(tensor, _INTEGRATION, axes=(0, 1, 2))
    sloping = slopes.any(axis=-1)
    steepest = np.linalg.eigh(tensor[sloping])[1][..., -1]
    field = np.zeros_like(slopes)
    uphill = np.sign((steepest * slopes[sloping]).sum(axis=-1, keepdims=True))
    field[sloping] = steepest * uphill
    return -np.sum([np.gradient(field[..., axis], axis=axis) for axis in range(3)], axis=0)


_LEAST_SHARE = 0.02  # Memberships below this do not tie a pixel to a description
_HELD = 1e-9
"""Weight of log reflectances of 0, which decides the constant that all else leaves open."""


class Descriptors(NamedTuple):
    """What is known of the P pixels of a mask."""

    ridge: NDArray[np.int64]  # (P,) number of the ridge, k
    names: Floats  # (P, N) memberships μ, with a sum of 1


def log_reflectance(
    log_image: Floats, descriptors: Descriptors, pairs: NDArray[np.int64], tie: float
) -> Floats:
    """Return log reflectance (P,), which minimises the energy of the package's docstring.

    The log of grey values is (P,); pairs (2, E) are those of `poisson.neighbours`; λ is the weight
    of all pairs that share ridge and name: of pixels tied to a reflectance for each.
    """
    from scipy.sparse import csc_array, diags_array, vstack

    count = len(log_image)
    second, first = pairs
    ridge, names = descriptors
    pixels, name = np.nonzero(names > _LEAST_SHARE)
    described, ends = np.unique(ridge[pixels] * names.shape[1] + name, return_inverse=True)
    weights, width = np.sqrt(tie * names[pixels, name]), count + len(described)
    steps = weighted_differences(second, first, np.ones(len(second)), width)
    spokes = weighted_differences(pixels, count + ends, weights, width)
    system = csc_array(vstack([steps, spokes]))
    unlike = 1.0 - likeness(descriptors, pairs)
    wanted = np.concatenate(
        [unlike * (log_image[second] - log_image[first]), np.zeros(len(pixels))]
    )
    factors = factorised(system.T @ system + diags_array(np.full(width, _HELD)))
    return np.asarray(factors.solve(system.T @ wanted)[:count])


def likeness(descriptors: Descriptors, pairs: NDArray[np.int64]) -> Floats:
    """Return a_ij of pairs (2, E): 1 where both have one ridge or one name, 0 where neither."""
    second, first = pairs
    ridge, names = descriptors
    one_name = np.minimum(names[second], names[first]).sum(axis=1)
    return np.where(ridge[second] == ridge[first], 1.0, one_name)


_WHITEST = 99.0  # Percentile of grey values that names take for white


def estimate(view: View, tie: float) -> Estimate:
    """Return the decomposition for the weight λ of ties between pixels anywhere."""
    mask = view.mask
    grey = view.grey[mask]
    colors = _as_rgb(np.maximum(view.image[mask], FLOOR)) / np.percentile(grey, _WHITEST)
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
