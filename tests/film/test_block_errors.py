"""Errors of blocks' means: against NumPy, calibrated over many seeds, and kept by files."""

import numpy as np
import pytest
from helpers.estimates import empty_pixels
from helpers.scenes import balls_in_box
from scipy import stats

import photonmap as pm
from photonmap.film.blocks import SIDE, BlockMoments, block_means, block_minima
from photonmap.film.pooling import pool_errors
from photonmap.kernels.core.passes import FIRST_CAUSTIC, VIA_CAUSTIC, VIA_DIRECT, VIA_INDIRECT, Film

WIDTH, HEIGHT, BANDS, COUNT = 20, 13, 2, 5
PASSES, SEEDS = 16, 32
pytestmark = pytest.mark.filterwarnings("ignore:.*successive reflections")


def brute_force(image, reduce):
    rows, columns = range(0, image.shape[0], SIDE), range(0, image.shape[1], SIDE)
    return np.array(
        [[reduce(image[y : y + SIDE, x : x + SIDE], axis=(0, 1)) for x in columns] for y in rows]
    )


def random_passes(smooth):
    """Passes of white noise, and what they saw in smooth surfaces."""
    rng = np.random.default_rng(7)
    for _ in range(COUNT):
        pixels = empty_pixels(WIDTH * HEIGHT, BANDS)
        pixels.direct[:], pixels.indirect[:] = rng.random((2, *pixels.indirect.shape))
        seen = rng.random((5, WIDTH * HEIGHT, BANDS), np.float32)
        yield pixels, seen if smooth else None


@pytest.mark.parametrize("shape", [(HEIGHT, WIDTH), (16, 8, 3), (1, 1, 1), (7, 9, 2)])
def test_blocks_at_the_edges_have_what_is_left(shape):
    image = np.random.default_rng(1).random(shape, np.float32)
    np.testing.assert_allclose(block_means(image, SIDE), brute_force(image, np.mean), rtol=1e-6)
    np.testing.assert_array_equal(block_minima(image, SIDE), brute_force(image, np.min))


@pytest.mark.parametrize("smooth", [False, True])
def test_errors_are_those_of_the_blocks_of_each_pass(smooth):
    moments = BlockMoments(Film(WIDTH, HEIGHT, True), BANDS, smooth)
    stacked = {"direct": [], "indirect": [], "caustics": []}
    for pixels, seen in random_passes(smooth):
        moments.add(pixels, seen)
        caustics = seen[FIRST_CAUSTIC] + seen[VIA_CAUSTIC] if smooth else 0.0
        via_direct, beyond = seen[[VIA_DIRECT, VIA_INDIRECT]] if smooth else (0.0, 0.0)
        stacked["direct"].append(pixels.direct + via_direct)
        stacked["indirect"].append(pixels.indirect + beyond + caustics)
        stacked["caustics"].append(np.broadcast_to(caustics, pixels.indirect.shape))
    errors = moments.finish(2.0)
    assert set(errors) == {"direct", "indirect", *(["caustics"] if smooth else [])}
    for name, error in errors.items():
        images = np.reshape(stacked[name], (COUNT, HEIGHT, WIDTH, BANDS))
        means = np.array([brute_force(image, np.mean) for image in images])
        expected = 2.0 * means.std(axis=0, ddof=1) / np.sqrt(COUNT)
        np.testing.assert_allclose(error, expected, rtol=1e-5)


def test_runs_are_pooled():
    values = np.random.default_rng(2).random((9, 4))
    runs = [values[:3], values[3:4], values[4:]]
    counts = [np.float64(len(run)) for run in runs]
    errors = [run.std(axis=0, ddof=len(run) > 1) / np.sqrt(len(run)) for run in runs]
    pooled = pool_errors(counts, [run.mean(axis=0) for run in runs], errors)
    np.testing.assert_allclose(pooled, values.std(axis=0, ddof=1) / 3.0)


def rendered(**settings):
    """A box with a mirror and a glass ball."""
    return pm.render(balls_in_box(), bands="rgb", **settings)


@pytest.fixture(scope="module")
def run():
    return rendered(size=(20, 13), passes=2)


@pytest.fixture(scope="module")
def runs():
    """Renders of many seeds."""
    return [rendered(size=(48, 48), passes=PASSES, seed=seed) for seed in range(SEEDS)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["direct", "caustics", "indirect"])
def test_intervals_of_blocks_cover_the_truth(runs, name):
    """Deviations from the other seeds' mean are Student's t: their spread, and 95% intervals."""
    values = np.array([run.block_mean(name) for run in runs], float)
    errors = np.array([run.block_error(name) for run in runs], float)
    assert values.shape == errors.shape == (SEEDS, 6, 6, 3)
    others = (values.sum(axis=0) - values) / (SEEDS - 1)
    t = (values - others) / np.sqrt(1.0 + 1.0 / (SEEDS - 1)) / errors
    t = t[:, values.any(axis=0)]  # no block of a lamp, which reflects nothing
    covered = (np.abs(t) < stats.t.ppf(0.975, PASSES - 1)).mean()
    assert 0.93 <= covered <= 0.97
    assert 0.9 <= stats.norm.ppf(stats.t.cdf(t, PASSES - 1)).std() <= 1.1


def test_files_keep_them(run, tmp_path):
    run.save(tmp_path / "image.exr")
    loaded = pm.load_result(tmp_path / "image.exr")
    assert set(loaded.block_errors) == {"direct", "indirect", "caustics"}
    for name, error in run.block_errors.items():
        assert error.dtype == np.float32
        np.testing.assert_array_equal(loaded.block_errors[name], error)
        np.testing.assert_array_equal(loaded.block_error(name), run.block_error(name))
    part = run.select(["radiance", "caustics"])
    assert set(part.block_errors) == {"caustics"}


def test_what_has_none_is_told(run):
    with pytest.raises(
        ValueError, match="'radiance' has no standard error of blocks: there is one of 'direct'"
    ):
        run.block_error("radiance")
    with pytest.raises(ValueError, match="'nothing' was not among the buffers"):
        run.block_error("nothing")
    with pytest.raises(ValueError, match="'nothing' was not among the buffers"):
        run.block_mean("nothing")
    once = pm.render(pm.scenes.cornell_box(), bands=1, size=(8, 8), passes=1)
    with pytest.raises(ValueError, match="after a single pass there is none"):
        once.block_error("indirect")
