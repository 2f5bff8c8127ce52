"""SIRFS: the most likely shape, reflectance and light that explain a shaded image.

J. T. Barron and J. Malik, "Color constancy, intrinsic images, and shape estimation", ECCV 2012,
and for what it builds on "Shape, albedo, and illumination from a single image of an unknown
object", CVPR 2012. For a log image I, depth Z and light L,

    minimise g(I − S(Z, L)) + f(Z) + h(L)                      (1)

S, the log shading, is linear in the spherical harmonics of normals up to order 2, with nine
coefficients for each band. The priors:

- reflectance g: differences in windows of 5×5 pixels come from a Gaussian scale mixture; few
  values occur (Rényi's quadratic entropy); values themselves are likely or not
- shape f: differences of mean curvature in windows of 5×5 come from a Gaussian scale mixture;
  surfaces face the camera
- light h: coefficients are normally distributed

L-BFGS descends in a pyramid of Z and in L. Differences are Gaussian scale mixtures: many are small,
and some large.

What differs. The priors were learnt on scenes of this data set's kind with other seeds (`learn`),
not on those of Grosse et al. Bands are exchangeable, so that any number of them will do: the
brightness of a colour, its mean over bands, and its deviations from that have one variance each,
and so have the coefficients of light; values of reflectance are normal instead of splines over
colours; the entropy is that of a grid of pixels instead of all. There is no term for occluding
contours, as these images are not of one object on nothing. Of the four weights a few values were
tried on seven images of the scenes of the priors; the paper's come from a search.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey

SCALES = np.logspace(-2.0, 1.5, 16)
"""Standard deviations of the Gaussians; only their weights are learnt. Rendered reflectances are
exactly equal on a surface: without a least scale, the cost would have a cusp there that no descent
gets past."""
_NEAR = 1e-8  # Added to squared lengths, whose logarithm is taken
_LEAST, _MOST, _STEPS = float(np.log(_NEAR)), float(np.log(1e4)), 16384
_STEP = (_MOST - _LEAST) / (_STEPS - 1)
_ROUNDS = 200
_NEGLIGIBLE = 1e-6


def cost_table(weights: Floats, dimensions: int) -> Floats:
    """Return the cost −log Σ_k a_k σ_k^−d exp(−q / 2σ_k²) of squared lengths q of d numbers.

    It is 0 for no difference, and tabulated over log q, between whose entries it is linear; weights
    a_k are (16,).
    """
    table = -_log_density(np.exp(np.linspace(_LEAST, _MOST, _STEPS)), weights, dimensions)
    return np.asarray(table - table[0])


def learn_mixture(squared: Floats, dimensions: int) -> Floats:
    """Return the weights (16,) of a mixture for a sample of squared lengths, by EM."""
    weights = np.full(len(SCALES), 1.0 / len(SCALES))
    logs = _log_parts(np.maximum(squared, _NEAR), dimensions)
    logs -= logs.max(axis=1, keepdims=True)
    parts = np.exp(logs)
    for _ in range(_ROUNDS):
        joint = parts * weights
        weights = (joint / joint.sum(axis=1, keepdims=True)).mean(axis=0)
    return np.where(weights > _NEGLIGIBLE, weights, 0.0)


def _log_parts(squared: Floats, dimensions: int) -> Floats:
    """Return log σ_k^−d exp(−q / 2σ_k²): (Q, 16)."""
    return np.asarray(
        -dimensions * np.log(SCALES) - squared[:, None] / (2.0 * SCALES**2), np.float64
    )


def _log_density(squared: Floats, weights: Floats, dimensions: int) -> Floats:
    logs = _log_parts(squared, dimensions) + np.log(np.maximum(weights, 1e-300))
    largest = logs.max(axis=1)
    return np.asarray(largest + np.log(np.exp(logs - largest[:, None]).sum(axis=1)), np.float64)


def windows(mask: Mask, reach: int = 2) -> Iterator[tuple[tuple[slice, slice], ...]]:
    """Yield the places of all pairs of pixels in windows of 2 reach + 1, each pair once.

    For an image, `image[one]` and `image[other]` are the members of pairs that are a shift apart.
    """
    height, width = mask.shape
    for y in range(reach + 1):
        for x in range(-reach, reach + 1):
            if (y, x) > (0, 0) and y < height and abs(x) < width:
                rows = slice(0, height - y), slice(y, height)
                left, right = (
                    slice(max(-x, 0), width - max(x, 0)),
                    slice(max(x, 0), width + min(x, 0)),
                )
                yield (rows[0], left), (rows[1], right)


def difference_cost(image: Floats, mask: Mask, table: Floats) -> tuple[float, Floats]:
    """Return the mean cost, by `cost_table`, of differences in windows of 5×5, and its gradient."""
    total, count = 0.0, 0
    gradient = np.zeros_like(image)
    for one, other in windows(mask):
        cost, pairs = _compiled()(
            (image[one], image[other]),
            (mask[one], mask[other]),
            table,
            (gradient[one], gradient[other]),
        )
        total += cost
        count += pairs
    count = max(count, 1)
    return total / count, gradient / count


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """Return `_add_pairs`, compiled when it is first needed."""
    from numba import njit

    return njit(_add_pairs)


def _add_pairs(images: Any, masks: Any, table: Floats, gradients: Any) -> tuple[float, int]:
    """Return the cost and number of pairs of pixels a shift apart, and add to their gradients."""
    total, count = 0.0, 0
    for y in range(masks[0].shape[0]):
        for x in range(masks[0].shape[1]):
            if not (masks[0][y, x] and masks[1][y, x]):
                continue
            squared = 0.0
            for band in range(images[0].shape[2]):
                squared += (images[1][y, x, band] - images[0][y, x, band]) ** 2
            kept = squared + _NEAR
            position = min(max((np.log(kept) - _LEAST) / _STEP, 0.0), _STEPS - 1.001)
            index = int(position)
            rise = table[index + 1] - table[index]
            total += table[index] + rise * (position - index)
            count += 1
            pull = 2.0 * rise / (_STEP * kept)
            for band in range(images[0].shape[2]):
                change = pull * (images[1][y, x, band] - images[0][y, x, band])
                gradients[1][y, x, band] += change
                gradients[0][y, x, band] -= change
    return total, count


FILE = "sirfs_priors.json"


@dataclass(frozen=True)
class Priors:
    """What is likely."""

    edges: list[float]
    """(16,) weights of the mixture of differences of reflectance, in units of `edge_spread`"""
    bends: list[float]  # (16,) weights of the mixture of differences of mean curvature
    edge_spread: list[float]
    """standard deviations of differences of log reflectance: brightness, deviations"""
    reflectance: list[float]
    """mean and standard deviation of brightness, and standard deviation of deviations"""
    light: list[float]  # (9,) mean of coefficients, mean over bands
    light_precision: list[list[float]]  # (9, 9) inverse of their covariance
    light_deviation: list[float]  # (9,) standard deviation of bands from their mean


def load_priors() -> Priors:
    """Return the priors that the package comes with."""
    text = files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return Priors(**json.loads(text))


def as_json(priors: Priors) -> str:
    """Return priors as text, a line each."""
    rows = (f" {json.dumps(name)}: {json.dumps(_rounded(v))}" for name, v in asdict(priors).items())
    return "{\n" + ",\n".join(rows) + "\n}"


def _rounded(value: Any) -> Any:
    return [_rounded(v) for v in value] if isinstance(value, list) else float(f"{value:.6g}")


def whitened(colors: Floats, spread: Any) -> Floats:
    """Return (…, C) with brightness over one standard deviation and deviations over another.

    The map is linear and its own transpose.
    """
    mean = colors.mean(axis=-1, keepdims=True)
    return np.asarray(mean / spread[0] + (colors - mean) / spread[1])


_SMOOTH, _SLOPE, _BEND = (1.0, 2.0, 1.0), (-1.0, 0.0, 1.0), (1.0, -2.0, 1.0)


class Filters(NamedTuple):
    """Derivatives of (P,) depths of all pixels of an image as sparse matrices."""

    x: Any
    y: Any
    xx: Any
    xy: Any
    yy: Any


@lru_cache(maxsize=4)
def filters(height: int, width: int) -> Filters:
    """Return the derivatives of 3×3 pixels; beyond the border, depths repeat."""
    from scipy.sparse import csr_array, diags_array, kron

    def along(count: int, weights: tuple[float, ...], scale: float) -> Any:
        rows = [
            np.full(count - abs(k), w * scale) for k, w in zip((-1, 0, 1), weights, strict=True)
        ]
        matrix = diags_array(rows, offsets=(-1, 0, 1), shape=(count, count)).tolil()
        matrix[0, 0] += weights[0] * scale
        matrix[-1, -1] += weights[2] * scale
        return matrix

    def both(down: tuple[float, ...], right: tuple[float, ...], scales: tuple[float, float]) -> Any:
        return csr_array(kron(along(height, down, scales[0]), along(width, right, scales[1])))

    return Filters(
        both(_SMOOTH, _SLOPE, (0.25, 0.5)),
        both(_SLOPE, _SMOOTH, (0.5, 0.25)),
        both(_SMOOTH, _BEND, (0.25, 1.0)),
        both(_SLOPE, _SLOPE, (0.5, 0.5)),
        both(_BEND, _SMOOTH, (1.0, 0.25)),
    )


class Surface:
    """Slopes and normals of a depth map (H, W), pixels towards the camera."""

    def __init__(self, depth: Floats) -> None:
        self.shape = depth.shape
        flat = depth.ravel()
        self._filters = filters(*depth.shape)
        self.p, self.q = self._filters.x @ flat, self._filters.y @ flat
        self._bends = tuple(matrix @ flat for matrix in self._filters[2:])
        self.squared = 1.0 + self.p**2 + self.q**2
        self._length = np.sqrt(self.squared)

    def normals(self) -> Floats:
        """Return (P, 3) unit normals: right, down, towards the camera."""
        return np.stack([-self.p, -self.q, np.ones_like(self.p)], axis=1) / self._length[:, None]

    def curvature(self) -> Floats:
        """Return the mean curvature of each pixel: (P,)."""
        xx, xy, yy = self._bends
        p, q = self.p, self.q
        bent = (1.0 + p**2) * yy - 2.0 * p * q * xy + (1.0 + q**2) * xx
        return np.asarray(bent / (2.0 * self.squared * self._length))

    def of_normals(self, by_normal: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by normals (P, 3)."""
        normals = self.normals()
        tangent = by_normal - (by_normal * normals).sum(axis=1, keepdims=True) * normals
        tangent /= self._length[:, None]
        return self.of_slopes(-tangent[:, 0], -tangent[:, 1])

    def of_slopes(self, by_p: Floats, by_q: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by slopes."""
        return np.asarray(self._filters.x.T @ by_p + self._filters.y.T @ by_q).reshape(self.shape)

    def of_curvature(self, by_curvature: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by mean curvature (P,)."""
        xx, xy, yy = self._bends
        p, q = self.p, self.q
        scale = by_curvature / (self.squared * self._length)
        curvature = by_curvature * self.curvature()
        by_p = scale * (p * yy - q * xy) - 3.0 * curvature * p / self.squared
        by_q = scale * (q * xx - p * xy) - 3.0 * curvature * q / self.squared
        bends = (
            self._filters.xx.T @ (0.5 * scale * (1.0 + q**2))
            - self._filters.xy.T @ (scale * p * q)
            + self._filters.yy.T @ (0.5 * scale * (1.0 + p**2))
        )
        return self.of_slopes(by_p, by_q) + bends.reshape(self.shape)


HARMONICS = 9


def harmonics(normals: Floats) -> Floats:
    """Return (P, 9) for normals (P, 3)."""
    x, y, z = normals.T
    rows = [np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3.0 * z * z - 1.0]
    return np.stack(rows, axis=1)


def by_normals(normals: Floats, by_harmonics: Floats) -> Floats:
    """Return the gradient by normals (P, 3) of what has a gradient by harmonics (P, 9)."""
    x, y, z = normals.T
    g = by_harmonics.T
    return np.stack(
        [
            g[1] + y * g[4] + z * g[5] + 2.0 * x * g[7],
            g[2] + x * g[4] + z * g[6] - 2.0 * y * g[7],
            g[3] + x * g[5] + y * g[6] + 6.0 * z * g[8],
        ],
        axis=1,
    )


BEND = 10.0  # Unit of curvature in its prior, pixels
_SAMPLED = 400  # Number of pixels whose reflectances the entropy compares
_KERNEL = 1.0  # Width σ of the entropy's kernel, in units of the spread of differences


class Objective:
    """The cost (1) of a log image (H, W, C) within a mask, terms averaged over pixels.

    Weights are those of "smooth", "entropy", "absolute", "curvature", "facing" and "light".
    """

    def __init__(
        self, log_image: Floats, mask: Mask, priors: Priors, weights: dict[str, float]
    ) -> None:
        self._image, self._mask, self._priors, self._weights = log_image, mask, priors, weights
        self._edges = cost_table(np.array(priors.edges), log_image.shape[2])
        self._bends = cost_table(np.array(priors.bends), 1)
        inside = np.flatnonzero(mask)
        self._sampled = inside[np.linspace(0, len(inside) - 1, _SAMPLED).astype(np.int64)]

    def shading(self, depth: Floats, light: Floats) -> Floats:
        """Return the log shading (H, W, C) of a depth map in a light (9, C)."""
        return (harmonics(Surface(depth).normals()) @ light).reshape(self._image.shape)

    def __call__(self, depth: Floats, light: Floats) -> tuple[float, Floats, Floats]:
        """Return the cost, and its gradients by depth (H, W) and light (9, C)."""
        surface = Surface(depth)
        normals = surface.normals()
        basis = harmonics(normals)
        reflectance = self._image - (basis @ light).reshape(self._image.shape)
        cost, by_reflectance = self._reflectance_cost(reflectance)
        by_shading = -by_reflectance.reshape(-1, light.shape[1])
        by_depth = surface.of_normals(by_normals(normals, by_shading @ light.T))
        shape_cost, by_shape = self._shape_cost(surface)
        light_cost, by_light = self._light_cost(light)
        return (
            cost + shape_cost + light_cost,
            by_depth + by_shape,
            basis.T @ by_shading + by_light,
        )

    def _reflectance_cost(self, reflectance: Floats) -> tuple[float, Floats]:
        """Return the cost of log reflectance (H, W, C), and its gradient."""
        spread = self._priors.edge_spread
        white = whitened(reflectance, spread)
        smooth, gradient = difference_cost(white, self._mask, self._edges)
        cost, gradient = self._weights["smooth"] * smooth, self._weights["smooth"] * gradient
        flat = white.reshape(-1, white.shape[2])
        entropy, by_sample = _entropy(flat[self._sampled])
        cost += self._weights["entropy"] * entropy
        by_flat = gradient.reshape(flat.shape)
        np.add.at(by_flat, self._sampled, self._weights["entropy"] * by_sample)
        gradient = whitened(by_flat.reshape(white.shape), spread)
        absolute, by_value = self._absolute(reflectance)
        return (
            cost + self._weights["absolute"] * absolute,
            gradient + self._weights["absolute"] * by_value,
        )

    def _absolute(self, reflectance: Floats) -> tuple[float, Floats]:
        """Return the cost of values: normal in brightness and in deviations from it."""
        mean, brightness, deviation = self._priors.reflectance
        white = whitened(reflectance - mean, (brightness, deviation))
        white = np.where(self._mask[..., None], white, 0.0)
        count = int(self._mask.sum())
        return 0.5 * float((white**2).sum()) / count, whitened(
            white, (brightness, deviation)
        ) / count

    def _shape_cost(self, surface: Surface) -> tuple[float, Floats]:
        curvature = BEND * surface.curvature().reshape(*surface.shape, 1)
        bent, by_curvature = difference_cost(curvature, self._mask, self._bends)
        count = surface.squared.size
        facing = 0.5 * float(np.log(surface.squared).sum()) / count
        slopes = (surface.p / surface.squared / count, surface.q / surface.squared / count)
        gradient = self._weights["curvature"] * surface.of_curvature(BEND * by_curvature.ravel())
        gradient += self._weights["facing"] * surface.of_slopes(*slopes)
        return self._weights["curvature"] * bent + self._weights["facing"] * facing, gradient

    def _light_cost(self, light: Floats) -> tuple[float, Floats]:
        mean = light.mean(axis=1)
        away = mean - np.array(self._priors.light)
        pulled = np.array(self._priors.light_precision) @ away
        deviations = (light - mean[:, None]) / np.array(self._priors.light_deviation)[:, None]
        weight, bands = self._weights["light"], light.shape[1]
        cost = 0.5 * weight * float(away @ pulled + (deviations**2).sum())
        scaled = deviations / np.array(self._priors.light_deviation)[:, None]
        centred = scaled - scaled.mean(axis=1, keepdims=True)
        return cost, weight * (pulled[:, None] / bands + centred)


def _entropy(colors: Floats) -> tuple[float, Floats]:
    """Return Rényi's quadratic entropy of colours (K, C) up to a constant, and its gradient."""
    squared = (colors**2).sum(axis=1)
    apart = np.maximum(squared[:, None] + squared[None] - 2.0 * colors @ colors.T, 0.0)
    near = np.exp(-apart / (4.0 * _KERNEL**2))
    total = float(near.sum())
    pull = colors * near.sum(axis=1)[:, None] - near @ colors
    return -float(np.log(total / near.size)), pull / (_KERNEL**2 * total)


_COARSEST = 4  # Side of the smallest level of the pyramid, about, pixels


def estimate(view: View, steps: float, **weights: float) -> Estimate:
    """Return the decomposition after at most some steps of L-BFGS; for weights, see `Objective`."""
    from scipy.optimize import minimize

    white = float(np.percentile(to_grey(view.image)[view.mask], 99.0))
    log_image = np.log(np.maximum(view.image / white, FLOOR))
    priors = load_priors()
    objective = Objective(log_image, view.mask, priors, weights)
    levels = pyramid(*view.mask.shape)
    sizes = [level.shape[1] for level in levels]
    light = np.repeat(np.array(priors.light)[:, None], log_image.shape[2], axis=1)

    def cost(values: Floats) -> tuple[float, Floats]:
        parts = np.split(values, np.cumsum(sizes))
        total, by_depth, by_light = objective(
            depth_of(parts[:-1], levels, view.mask.shape), parts[-1].reshape(HARMONICS, -1)
        )
        gradients = [level.T @ by_depth.ravel() for level in levels]
        return total, np.concatenate([*gradients, by_light.ravel()])

    start = np.concatenate([np.zeros(sum(sizes)), light.ravel()])
    found = minimize(cost, start, method="L-BFGS-B", jac=True,
                     options={"maxiter": round(steps), "gtol": 1e-10, "ftol": 1e-8})  # fmt: skip
    parts = np.split(found.x, np.cumsum(sizes))
    depth = depth_of(parts[:-1], levels, view.mask.shape)
    shading = np.exp(objective.shading(depth, parts[-1].reshape(HARMONICS, -1)))
    return Estimate(np.exp(log_image) / shading, shading, shading)


def depth_of(parts: list[Floats], levels: tuple[Any, ...], shape: tuple[int, ...]) -> Floats:
    """Return the depth (H, W) that a pyramid adds up to."""
    return np.asarray(
        sum(level @ part for level, part in zip(levels, parts, strict=True)), np.float64
    ).reshape(shape)


@lru_cache(maxsize=2)
def pyramid(height: int, width: int) -> tuple[Any, ...]:
    """Return matrices that bring levels of halved size to the image's, by linear interpolation.

    Each level counts √2 times as much as the one below, so that L-BFGS bends large surfaces first.
    """
    from scipy.sparse import csr_array, kron

    levels, step = [], 1
    while step == 1 or min(height, width) // step >= _COARSEST:
        matrix = kron(_interpolation(height, step), _interpolation(width, step))
        levels.append(csr_array(matrix * float(np.sqrt(2.0 * step))))
        step *= 2
    return tuple(levels)


def _interpolation(count: int, step: int) -> Any:
    """Return the matrix from knots `step` apart to `count` pixels."""
    from scipy.sparse import csr_array

    knots = -(-(count - 1) // step) + 1
    position = np.arange(count) / step
    left = np.minimum(position.astype(np.int64), max(knots - 2, 0))
    weight = position - left
    rows = np.tile(np.arange(count), 2)
    columns = np.concatenate([left, np.minimum(left + 1, knots - 1)])
    return csr_array(
        (np.concatenate([1.0 - weight, weight]), (rows, columns)), shape=(count, knots)
    )


METHODS = (
    Method("sirfs", estimate,
           {"steps": 300.0, "smooth": 4.0, "entropy": 1.0, "absolute": 0.1, "curvature": 1.0,
            "facing": 0.1, "light": 0.1}),
)  # fmt: skip
