"""Bell's random field: its kernel, its regions, and mean field."""

import numpy as np

from photonmap.evaluate.methods import bell
from photonmap.evaluate.methods.bell import GaussianKernel, _corners


def test_corners_surround_their_point():
    """Shares are positive, add up to 1, and are linear: corners weighted by them are the point."""
    features = np.random.default_rng(0).normal(0.0, 3.0, (400, 4))
    corners, shares = _corners(features)
    assert shares.min() > -1e-12
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    found = (corners * shares[..., None]).sum(axis=1)
    design = np.column_stack([features, np.ones(400)])
    assert np.abs(design @ np.linalg.lstsq(design, found)[0] - found).max() < 1e-9


def test_the_kernel_is_a_gaussian():
    """Of the right width: sums over all pairs with another width are further away."""
    rng = np.random.default_rng(1)
    features = rng.uniform(0.0, 2.0, (1000, 3))
    values = np.column_stack([features[:, 0] > 1.0, np.sin(features[:, 1])])
    found = GaussianKernel(features).apply(values)
    squares = ((features[:, None] - features) ** 2).sum(axis=-1)
    misses = []
    for width in (1.0, 0.7, 1.6):
        exact = np.exp(-0.5 * squares / width**2)
        scale = 1.0 / np.sqrt(exact.sum(axis=1, keepdims=True))
        misses.append(np.abs(scale * (exact @ (scale * values)) - found).mean())
    assert misses[0] < 0.02
    assert min(misses[1:]) > 2.0 * misses[0]


def test_far_points_do_not_see_each_other():
    features = np.array([[0.0, 0.0], [0.0, 0.0], [50.0, 0.0]])
    found = GaussianKernel(features).apply(np.array([[1.0], [3.0], [8.0]]))
    np.testing.assert_allclose(found[:, 0], [2.0, 2.0, 8.0])


def test_regions_are_connected_and_shading_joins_them():
    labels = np.array([[0, 0, 1, 0], [0, 1, 1, 0], [-1, -1, 2, 0]])
    parts = bell.connected_regions(labels)
    assert (parts < 0).sum() == 2
    assert len(np.unique(parts[parts >= 0])) == 4
    assert parts[0, 0] != parts[0, 3]
    truth = np.array([0.3, -0.7, 1.1, 0.2])
    image = np.where(parts >= 0, truth[parts] + 0.25, 9.0)
    found = bell.matched_intensities(image, parts, np.zeros(4))
    np.testing.assert_allclose(found - found[0], truth - truth[0], atol=1e-4)


def test_mean_field_outvotes_a_lone_pixel():
    kernel = GaussianKernel(np.zeros((9, 2)))
    costs = np.tile([0.0, 1.0], (9, 1))
    costs[4] = 1.0, 0.0
    distances = 5.0 * (1.0 - np.eye(2))
    assert (bell._likely_labels(costs, distances, kernel) == 0).all()
    assert bell._likely_labels(costs, 0.0 * distances, kernel)[4] == 1
