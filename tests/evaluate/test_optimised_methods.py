"""Methods that lower an energy: the energy, its parts, and images whose decomposition they find."""

import numpy as np
import pytest
from helpers.mondrians import ALL, COLORS, errors, mondrian, run
from scipy.optimize import check_grad

from photonmap.evaluate.methods import bell, gehler, shen
from photonmap.evaluate.methods.bell import GaussianKernel, _corners

BRIGHT = [(1.0, 0.5, 0.3), (0.1, 0.25, 0.15), (0.4, 0.3, 0.8)]


@pytest.mark.parametrize(
    ("name", "share", "scene", "settings"),
    [
        ("shen", 0.05, {}, {"rounds": 1000.0}),
        ("gehler", 0.001, {}, {"count": 3.0}),
        ("serra", 0.01, {"times": 2}, {}),
        ("bell", 0.001, {"colors": BRIGHT}, {}),
    ],
)
def test_mondrians_under_a_gradient(name, share, scene, settings):
    """Most of the error of either baseline is gone, whatever is in pixels that do not count."""
    reflectance, shading = mondrian(**scene)
    image = reflectance * shading[..., None]
    mask = ALL.copy()
    mask[5:9, 12:15] = False
    blind = [errors(run(f"constant-{layer}", image), reflectance, shading)
             for layer in ("shading", "reflectance")]  # fmt: skip
    found = errors(run(name, image, **settings), reflectance, shading)
    assert found[0] < share * blind[0][0]
    assert found[1] < share * blind[1][1]
    spoilt = np.where(mask[..., None], image, 7.0)
    held = errors(run(name, spoilt, mask, **settings), reflectance, shading, mask)
    assert held[0] < share * blind[0][0]
    assert held[1] < share * blind[1][1]


def test_shen_gives_one_material_one_reflectance():
    shading = mondrian()[1]
    image = COLORS[0] * shading[..., None]
    found = run("shen", image, rounds=3000.0)
    np.testing.assert_allclose(found.reflectance, found.reflectance[:1, :1] * ALL[..., None],
                               rtol=1e-3)  # fmt: skip
    few = run("shen", image, rounds=10.0)
    assert np.ptp(few.reflectance[..., 0]) > 10 * np.ptp(found.reflectance[..., 0])


def test_shen_weighs_neighbours_by_their_likeness():
    reflectance, shading = mondrian()
    mask = ALL.copy()
    mask[0, 0] = mask[11, 4] = False
    weights = shen._weights(reflectance * shading[..., None], mask)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    shift = {corner: place for place, corner in enumerate(shen._SHIFTS)}
    left, right = weights[shift[1, 0]], weights[shift[1, 2]]
    assert (left[1:-1, 10] < 0.2 * right[1:-1, 10]).all()  # the first column of a stripe
    assert (right[1:-1, 9] < 0.2 * left[1:-1, 9]).all()
    assert right[11, 3] == 0.0
    assert weights[shift[0, 1]][0].max() == 0.0


def test_the_gradient_of_gehlers_energy():
    rng = np.random.default_rng(0)
    count = 20
    direction = rng.uniform(0.2, 1.0, (count, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    pairs = np.stack([np.arange(1, count), np.arange(count - 1)])
    field = gehler._Field(
        rng.uniform(0.5, 1.0, count), direction, pairs, rng.normal(size=count - 1)
    )
    centres = rng.uniform(0.1, 1.0, (count, 3))
    for weights in np.eye(3):
        miss = check_grad(
            lambda x, w=weights: gehler._energy(x, field, centres, w)[0],
            lambda x, w=weights: gehler._energy(x, field, centres, w)[1],
            rng.normal(0.0, 0.3, count),
        )
        assert miss < 1e-5


def test_gehlers_energy_by_hand():
    """Two pixels: r = 1 and 2, |I| = 2 and 2, so that s = 2 and 1."""
    field = gehler._Field(
        np.array([2.0, 2.0]), np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([[1], [0]]),
        np.array([0.5]),
    )  # fmt: skip
    log_r, centres = np.log([1.0, 2.0]), np.array([[0.0, 0.0], [0.0, 5.0]])
    shares = [gehler._energy(log_r, field, centres, tuple(row))[0] for row in np.eye(3)]
    np.testing.assert_allclose(shares, [1.0, (np.log(2.0) - 0.5) ** 2, 1.0 + 9.0])


def test_gehlers_clusters():
    colors = np.repeat(COLORS, (5, 9, 30), axis=0)
    means = gehler.first_means(colors, 10)
    found = means[gehler.nearest_means(colors, means)]
    np.testing.assert_allclose(found, colors)
    assert (gehler.means_of(colors, np.zeros(44, int), means)[1:] == means[1:]).all()


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
