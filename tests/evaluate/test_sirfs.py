"""SIRFS: its gradients, its priors, and a bump whose light and shape are known."""

import numpy as np
import pytest
from scipy.stats import norm

from photonmap import evaluate
from photonmap.evaluate.methods import sirfs
from photonmap.evaluate.methods.method import View, find_method
from photonmap.evaluate.methods.sirfs import (
    Objective,
    Surface,
    as_json,
    depth_of,
    harmonics,
    load_priors,
    pyramid,
    whitened,
)

TERMS = ("smooth", "entropy", "absolute", "curvature", "facing", "light")
SIZE = 12, 15


def bump(size, height):
    y, x = np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in size), indexing="ij")
    return height * np.exp(-2.5 * (x**2 + y**2))


@pytest.mark.parametrize("term", TERMS)
def test_gradients(term):
    """Against central differences in random directions, of depth and of light."""
    rng = np.random.default_rng(0)
    mask = rng.uniform(size=SIZE) < 0.9
    image, depth = rng.normal(-1.0, 0.5, (*SIZE, 3)), bump(SIZE, 4.0) + rng.normal(size=SIZE)
    light = np.array(load_priors().light)[:, None] + rng.normal(0.0, 0.3, (9, 3))
    weights = {name: float(name == term) for name in TERMS}
    objective = Objective(image, mask, load_priors(), weights)
    _, by_depth, by_light = objective(depth, light)
    step = 1e-6
    for _ in range(4):
        along, turned = rng.normal(size=SIZE), rng.normal(size=(9, 3))
        ends = [objective(depth + s * along, light + s * turned)[0] for s in (step, -step)]
        expected = (by_depth * along).sum() + (by_light * turned).sum()
        assert (ends[0] - ends[1]) / (2.0 * step) == pytest.approx(expected, rel=2e-3, abs=1e-7)


def test_a_sphere_has_the_curvature_of_its_radius():
    y, x = np.mgrid[-10:11, -10:11].astype(float)
    surface = Surface(np.sqrt(60.0**2 - x**2 - y**2))
    inner = surface.curvature().reshape(21, 21)[2:-2, 2:-2]
    np.testing.assert_allclose(inner, -1.0 / 60.0, rtol=1e-3)
    normals = surface.normals().reshape(21, 21, 3)[2:-2, 2:-2]
    np.testing.assert_allclose(normals[..., 0], x[2:-2, 2:-2] / 60.0, atol=1e-3)
    np.testing.assert_allclose(normals[..., 1], y[2:-2, 2:-2] / 60.0, atol=1e-3)


def test_mixtures_cost_what_they_say():
    weights = np.zeros(16)
    weights[7] = 1.0  # one Gaussian
    squared = np.array([0.1, 0.5, 2.0])
    table, pair = sirfs.cost_table(weights, 1), np.ones((1, 2), bool)
    cost, pull = np.transpose(
        [
            (cost, gradient[0, 1, 0])
            for cost, gradient in (
                sirfs.difference_cost(np.array([[[0.0], [root]]]), pair, table)
                for root in np.sqrt(squared)
            )
        ]
    )
    scale = sirfs.SCALES[7]
    expected = norm.logpdf(0.0, scale=scale) - norm.logpdf(np.sqrt(squared), scale=scale)
    np.testing.assert_allclose(cost, expected, rtol=1e-3)
    np.testing.assert_allclose(pull, np.sqrt(squared) / scale**2, rtol=2e-2)


def test_mixtures_are_learnt():
    rng = np.random.default_rng(0)
    scales = np.where(rng.uniform(size=20_000) < 0.7, sirfs.SCALES[2], sirfs.SCALES[12])
    weights = sirfs.learn_mixture(
        (scales[:, None] * rng.normal(size=(20_000, 3))) ** 2 @ np.ones(3), 3
    )
    assert weights[1:4].sum() == pytest.approx(0.7, abs=0.02)
    assert weights[11:14].sum() == pytest.approx(0.3, abs=0.02)


def test_windows_hold_each_pair_once():
    numbers = np.arange(30).reshape(5, 6)
    pairs = [
        frozenset(pair)
        for one, other in sirfs.windows(np.ones((5, 6), bool))
        for pair in zip(numbers[one].ravel(), numbers[other].ravel(), strict=True)
    ]
    expected = {
        frozenset((a, b))
        for a in range(30)
        for b in range(a)
        if abs(a // 6 - b // 6) <= 2 and abs(a % 6 - b % 6) <= 2
    }
    assert len(pairs) == len(set(pairs))
    assert set(pairs) == expected


def test_whitening_is_its_own_transpose():
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(2, 7, 4))
    assert (whitened(one, (0.3, 2.0)) * other).sum() == pytest.approx(
        (one * whitened(other, (0.3, 2.0))).sum()
    )


def test_the_pyramid_reaches_every_depth():
    """Constants come from any level, and single pixels from the finest."""
    levels = pyramid(*SIZE)
    for level in levels:
        flat = (level @ np.ones(level.shape[1])).reshape(SIZE)
        np.testing.assert_allclose(flat, flat[0, 0])
    assert levels[0].shape == (180, 180)
    parts = [np.zeros(level.shape[1]) for level in levels]
    parts[0][17] = 1.0
    assert np.flatnonzero(depth_of(parts, levels, SIZE)).tolist() == [17]


def test_priors_are_kept_as_text():
    priors = load_priors()
    assert sum(priors.edges) == pytest.approx(1.0, abs=1e-3)
    assert sum(priors.bends) == pytest.approx(1.0, abs=1e-3)
    assert '"edges"' in as_json(priors)
    np.linalg.cholesky(np.array(priors.light_precision))


def test_a_bump_of_one_colour_in_likely_light():
    """Most of the error of both baselines is gone; the estimates multiply to the image."""
    size, bands = (20, 24), 6
    light = np.repeat(np.array(load_priors().light)[:, None], bands, axis=1)
    normals = Surface(bump(size, 6.0)).normals()
    shading = np.exp((harmonics(normals) @ light).reshape(*size, bands))
    reflectance = np.full((*size, bands), 0.4)
    mask = np.ones(size, bool)
    view = View("bump", reflectance * shading / shading.max(), mask)
    method = find_method("sirfs")
    found = method.estimate(view, **{**method.defaults, "steps": 400.0})
    product = found.reflectance * found.shading
    np.testing.assert_allclose(product / view.image, (product / view.image)[0, 0, 0])
    blind = evaluate.si_mse(reflectance, view.image)
    assert evaluate.si_mse(reflectance, found.reflectance) < 0.1 * blind
    flat = evaluate.si_mse(shading, np.ones_like(shading))
    assert evaluate.si_mse(shading, found.shading) < 0.1 * flat


def test_pairs_cost_what_the_mixture_says():
    rng = np.random.default_rng(0)
    image, mask = rng.normal(size=(*SIZE, 3)), rng.uniform(size=SIZE) < 0.8
    weights = np.array(load_priors().edges)

    def cost(squared):
        parts = weights * sirfs.SCALES**-3.0 * np.exp(-squared[:, None] / (2 * sirfs.SCALES**2))
        return -np.log(parts.sum(axis=1))

    squares = [
        ((image[other] - image[one]) ** 2).sum(axis=-1)[mask[one] & mask[other]]
        for one, other in sirfs.windows(mask)
    ]
    found = sirfs.difference_cost(image, mask, sirfs.cost_table(weights, 3))[0]
    wanted = (cost(np.concatenate(squares)) - cost(np.zeros(1))).mean()
    assert found == pytest.approx(wanted, rel=1e-4)
