"""The stated bias: none where nothing is averaged, and about right where supports are too wide."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.film.bias import EVERY, FIRST, is_repeated
from photonmap.film.replicates import replicate_size

SIZE = (32, 32)


def test_pairs_of_passes_are_probed():
    """The second of a pair is in the next replicate."""
    probed = [index for index in range(100) if is_repeated(index)]
    assert probed == [FIRST, FIRST + 1, FIRST + EVERY, FIRST + EVERY + 4, 76, 84]
    assert len({index // replicate_size(index) for index in probed[2:4]}) == 2


@pytest.mark.parametrize(
    ("options", "bias"),
    [({"passes": FIRST}, None), ({"method": "path"}, 0.0), ({"effects": "emission,direct"}, 0.0)],
)
def test_bias_is_unknown_before_it_is_measured_and_0_where_there_is_none(cornell, options, bias):
    run = pm.render(cornell, bands="rgb", size=SIZE, **{"passes": 16, **options})
    assert run.record["bias"] == bias
    assert run.record["error"] == run.record["standard_error"]
    if bias == 0.0:
        low, high = run.interval("radiance")
        assert (low <= high).all()


def coarse(cornell, seed, photons=2048):
    """The Cornell box with an eighth of the photons, so cells 2.8 times as wide."""
    run = pm.render(cornell, bands="rgb", size=SIZE, passes=16, photons=photons, seed=seed)
    record = run.record
    assert record["error"] == pytest.approx(np.hypot(record["standard_error"], record["bias"]))
    return run


def test_the_error_holds_both(cornell):
    """Noise hides the bias in a quarter of the runs."""
    assert any(coarse(cornell, seed, photons=512).record["bias"] > 0.0 for seed in range(4))


def block_sums(image, side):
    height, width = image.shape
    return image.reshape(height // side, side, width // side, side).sum(axis=(1, 3), dtype=float)


def test_blocks_say_where_the_bias_is(cornell):
    """They add up to the bias of the whole image, whose two halves multiply to no noise.

    After the last pass that was probed: by the radiance of later ones, the sum would differ.
    """
    run = pm.render(cornell, bands=1, size=SIZE, passes=14, photons=1024)
    blocks = run.bias("indirect")
    assert blocks.value.shape == blocks.error.shape == (4, 4)
    assert blocks.side == 8
    valid = (run.coverage == 1.0) & ~run.emission.any(axis=-1) & ~run.unresolved
    pixels = block_sums(valid, 8)
    value = block_sums(np.where(valid, run.radiance[..., 0], 0.0), 8)
    norm = value**2 + 0.01 * (pixels * value.sum() / pixels.sum()) ** 2
    square = (blocks.value.astype(float) ** 2 - blocks.error.astype(float) ** 2) * pixels**2
    whole = np.sqrt(max(np.average(square / norm, weights=pixels), 0.0))
    assert whole == pytest.approx(run.record["bias"], rel=2e-3)
    np.testing.assert_array_equal(run.bias("radiance").value, blocks.value)
    assert not run.bias("direct").value.any()
    rms = np.sqrt(np.mean(blocks.value.astype(float) ** 2))
    of_shading = rms / run.reflectance
    # Student's t of 13 degrees with those of neighbours: 18.4, 15.1 and 22.0
    quantiles = {
        "radiance": (2.09769, rms),
        "direct": (2.13064, 0.0),
        "shading": (2.07403, of_shading),
    }
    for name, (quantile, bias) in quantiles.items():
        low, high = run.interval(name)
        apart = quantile * np.hypot(run.standard_error(name), bias)
        np.testing.assert_allclose(high - low, 2.0 * apart, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose((low + high) / 2.0, run.buffers[name], rtol=1e-4, atol=1e-6)
    with pytest.raises(ValueError, match="level 95 is no probability"):
        run.interval("radiance", 95)
    with pytest.raises(ValueError, match="indirect"):
        run.bias("shading")


def test_blocks_are_unknown_where_no_bias_was_measured(cornell):
    run = pm.render(cornell, bands="rgb", size=SIZE, passes=2)
    assert run.record["bias_blocks"] is None
    with pytest.raises(ValueError, match="14 passes"):
        run.bias("indirect")


def test_blocks_of_merged_runs_are_weighted_by_passes(cornell):
    runs = [
        pm.render(cornell, bands="rgb", size=SIZE, passes=passes, photons=1024, seed=passes)
        for passes in (14, 16)
    ]
    parts, merged = [run.bias("indirect") for run in runs], pm.merge(runs).bias("indirect")
    value = (14 * parts[0].value + 16 * parts[1].value) / 30
    np.testing.assert_allclose(merged.value, value, rtol=1e-3, atol=1e-3 * np.abs(value).max())
    error = np.hypot(14 * parts[0].error, 16 * parts[1].error) / 30
    np.testing.assert_allclose(merged.error, error, rtol=1e-3, atol=1e-3 * error.max())


@pytest.mark.slow
def test_the_bias_of_wide_supports_is_stated(cornell):
    """Over blocks of 8x8 pixels, within a factor of 2 of that against many paths.

    By 24 seeds, a block's bias is hardly known better than noise: by 56, its correlation is 0.69.
    """
    truth = pm.render(cornell, bands="rgb", size=SIZE, passes=2000, method="path", seed=99)
    runs = [coarse(cornell, seed) for seed in range(56)]
    stated = np.sqrt(np.mean([run.record["bias"] ** 2 for run in runs]))
    valid = (truth.coverage == 1.0) & ~truth.emission.any(axis=-1)

    def blocks(image):
        masked = np.where(valid[..., None], image, 0.0).astype(float)
        return masked.reshape(4, 8, 4, 8, 3).sum(axis=(1, 3))

    halves = [np.mean([blocks(run.radiance) for run in half], axis=0)
              for half in (runs[::2], runs[1::2])]  # fmt: skip
    value = blocks(truth.radiance)
    pixels = blocks(np.ones_like(truth.radiance))
    norm = value**2 + 0.01 * (pixels * value.sum((0, 1)) / pixels.sum((0, 1))) ** 2
    square = (halves[0] - value) * (halves[1] - value) / norm
    true = np.sqrt(np.average(square, weights=pixels))
    assert true / 2.0 < stated < 2.0 * true

    where = np.mean([run.bias("indirect").value for run in runs], axis=0)
    really = (np.mean(halves, axis=0) - value).mean(axis=-1) / pixels[..., 0]
    assert np.corrcoef(where.ravel(), really.ravel())[0, 1] > 0.5
    assert 0.5 < (where * really).sum() / (where**2).sum() < 2.0
