"""Running moments against NumPy over the stacked passes."""

import numpy as np
import pytest
from helpers.estimates import empty_pixels

from photonmap.film.moments import Accumulator, flat
from photonmap.film.replicates import ONE_PASS
from photonmap.kernels.core.passes import EMPTY, FIRST_CAUSTIC, FOUND, VIA_CAUSTIC
from photonmap.kernels.film.add_pass import add_pass, make_chunk_scratch
from photonmap.kernels.film.moments import GOAL_BUFFERS
from photonmap.runtime.workers import Workers

SIZE, BANDS, PASSES = 50, 3, 7


@pytest.fixture
def stacked():
    rng = np.random.default_rng(3)
    passes = []
    for _ in range(PASSES):
        pixels = empty_pixels(SIZE, BANDS)
        for name in ("emission", "direct", "indirect", "reflectance"):
            getattr(pixels, name)[:] = rng.random((SIZE, BANDS)) + 0.1
        pixels.emission[10:] = 0.0
        pixels.reflectance[40:] = 0.0
        pixels.direct[40:] = pixels.indirect[40:] = 0.0
        pixels.irradiance_direct[:] = rng.random((SIZE, BANDS))
        pixels.irradiance_indirect[:] = rng.random((SIZE, BANDS))
        pixels.coverage[:] = 1.0
        pixels.coverage[:5] = 0.25
        passes.append(pixels)
    with Workers(2) as workers:
        moments = Accumulator(SIZE, BANDS, workers)
        for pixels in passes:
            moments.add(pixels)
        yield passes, moments


def stack(passes, name):
    return np.array([getattr(pixels, name) for pixels in passes], float)


def standard_error(values):
    return values.std(axis=0, ddof=1) / np.sqrt(len(values))


def test_means_and_errors(stacked):
    passes, moments = stacked
    buffers, errors = moments.finish(2.0)
    for name in ("emission", "direct", "indirect"):
        values = stack(passes, name)
        np.testing.assert_allclose(buffers[name], 2.0 * values.mean(axis=0), rtol=1e-6)
        np.testing.assert_allclose(errors[name], 2.0 * standard_error(values), rtol=1e-4, atol=1e-9)
    reflectance = stack(passes, "reflectance")
    np.testing.assert_allclose(buffers["reflectance"], reflectance.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(errors["reflectance"], standard_error(reflectance), rtol=1e-4)
    radiance = sum(stack(passes, name) for name in ("emission", "direct", "indirect"))
    np.testing.assert_allclose(errors["radiance"], 2.0 * standard_error(radiance), rtol=1e-4)
    np.testing.assert_array_equal(
        buffers["radiance"], (buffers["emission"] + buffers["direct"]) + buffers["indirect"]
    )


def test_shading_is_a_ratio_of_sums_or_the_mean_irradiance(stacked):
    passes, moments = stacked
    buffers, errors = moments.finish(1.0)
    diffuse = stack(passes, "direct") + stack(passes, "indirect")
    reflectance = stack(passes, "reflectance")
    ratio = diffuse.mean(axis=0)[:40] / reflectance.mean(axis=0)[:40]
    np.testing.assert_allclose(buffers["shading"][:40], ratio, rtol=1e-5)
    # The delta method: the error of a ratio is that of its linearisation.
    rest = (diffuse[:, :40] - ratio * reflectance[:, :40]) / reflectance.mean(axis=0)[:40]
    np.testing.assert_allclose(errors["shading"][:40], standard_error(rest), rtol=1e-3)
    irradiance = stack(passes, "irradiance_direct") + stack(passes, "irradiance_indirect")
    np.testing.assert_allclose(
        buffers["shading"][40:], irradiance.mean(axis=0)[40:] / np.pi, rtol=1e-5
    )
    np.testing.assert_allclose(
        errors["shading"][40:], standard_error(irradiance / np.pi)[40:], rtol=1e-4
    )


def test_constants_have_no_error(stacked):
    passes, _ = stacked
    with Workers(1) as workers:
        moments = Accumulator(SIZE, BANDS, workers)
        for _ in range(5):
            moments.add(passes[0])
        _, errors = moments.finish(1.0)
        assert all((error == 0.0).all() for error in errors.values())
        assert moments.error() == 0.0


def test_error_counts_covered_pixels_that_do_not_emit(stacked):
    passes, moments = stacked
    radiance = stack(passes, "direct")[:, 10:] + stack(passes, "indirect")[:, 10:]
    mean = radiance.mean(axis=0)
    relative = standard_error(radiance) ** 2 / (mean**2 + 0.01 * mean.mean(axis=0) ** 2)
    assert moments.error() == pytest.approx(np.sqrt(relative.mean()), rel=1e-5)


def test_each_pixel_counts_its_own_passes(stacked):
    """The first 20 pixels took in all passes, the others none, one or three of them."""
    passes, _ = stacked
    ends = {0: PASSES, 20: 0, 30: 1, 40: 3}
    with Workers(1) as workers:
        moments = Accumulator(SIZE, BANDS, workers)
        own, scratch = flat(moments.parts[0]), make_chunk_scratch(BANDS)
        for index, pixels in enumerate(passes):
            for (first, count), last in zip(ends.items(), (20, 30, 40, SIZE), strict=True):
                if index < count:
                    add_pass(own, None, flat(pixels), None, ONE_PASS, first, last, scratch)
            moments.count += 1
        buffers, errors = moments.finish(2.0)
        assert moments.error() == np.inf
    np.testing.assert_array_equal(moments.counts, np.repeat([7, 0, 1, 3], [20, 10, 10, 10]))
    for name in ("emission", "direct", "indirect", "radiance"):
        assert (buffers[name][20:30] == 0.0).all()
        assert np.isinf(errors[name][20:40]).all()
    assert np.isinf(errors["shading"][20:40]).all()
    for pixels, count in ((slice(0, 20), 7), (slice(40, SIZE), 3)):
        values = 2.0 * stack(passes[:count], "direct")[:, pixels]
        np.testing.assert_allclose(buffers["direct"][pixels], values.mean(axis=0), rtol=1e-6)
        np.testing.assert_allclose(
            errors["direct"][pixels], standard_error(values), rtol=1e-4, atol=1e-9
        )
    irradiance = stack(passes[:3], "irradiance_direct") + stack(passes[:3], "irradiance_indirect")
    np.testing.assert_allclose(
        errors["shading"][40:], 2.0 * standard_error(irradiance / np.pi)[40:], rtol=1e-4
    )


def test_covariance_of_the_means(stacked):
    passes, moments = stacked
    light, reflectance = (
        stack(passes, "direct") + stack(passes, "indirect"),
        stack(passes, "reflectance"),
    )
    deviations = [v - v.mean(axis=0) for v in (3.0 * light, reflectance)]
    covariance = (deviations[0] * deviations[1]).sum(axis=0) / (PASSES * (PASSES - 1))
    np.testing.assert_allclose(moments.finish(3.0)[0]["covariance"], covariance, atol=1e-6)


@pytest.mark.parametrize("name", GOAL_BUFFERS)
@pytest.mark.parametrize("weights", [[1.0, 1.0, 1.0], [1.0, 4.0, 2.0]])
def test_errors_of_any_buffer(stacked, name, weights):
    """Root mean squares and percentiles, over bands as often as columns stand for them."""
    passes, _ = stacked
    rng = np.random.default_rng(8)
    with Workers(2) as workers:
        glows = name == "fluorescence"
        moments = Accumulator(SIZE, BANDS, workers, True, np.array(weights), fluorescent=glows)
        for pixels in passes:
            seen = rng.random((9 if glows else 5, SIZE, BANDS), dtype=np.float32)
            seen[FIRST_CAUSTIC, 40:] = 0.0  # where nothing is reflected
            moments.add(pixels, seen)
        buffers, errors = moments.finish(1.0)
        valid = np.arange(SIZE) >= 10
        value, error = buffers[name][valid].astype(float), errors[name][valid].astype(float)
        relative = error / np.sqrt(value**2 + 0.01 * value.mean(axis=0) ** 2)
        every = np.repeat(relative, np.array(weights, int), axis=1).ravel()
        assert moments.error(name) == pytest.approx(np.sqrt((every**2).mean()), rel=1e-5)
        for percentile in (50.0, 95.0, 100.0):
            expected = np.percentile(every, percentile, method="inverted_cdf")
            assert moments.error(name, percentile) == pytest.approx(expected, rel=1e-5)


def test_pixels_without_photons_are_left_out(stacked):
    passes, _ = stacked
    for pixels in passes:
        pixels.lookups[10:30], pixels.lookups[30:] = EMPTY, EMPTY | FOUND
    with Workers(1) as workers:
        moments = Accumulator(SIZE, BANDS, workers)
        for pixels in passes:
            moments.add(pixels)
        assert moments.unresolved().sum() == 20
        for lit, first in ((True, 30), (False, 10)):
            radiance = (stack(passes, "direct") + stack(passes, "indirect"))[:, first:]
            mean = radiance.mean(axis=0)
            relative = standard_error(radiance) ** 2 / (mean**2 + 0.01 * mean.mean(axis=0) ** 2)
            assert moments.error(lit=lit) == pytest.approx(np.sqrt(relative.mean()), rel=1e-5)


def test_light_of_surfaces_that_no_sample_met_is_residual(stacked):
    """Photons connected to the camera may add it to a pixel whose reflectance is still 0."""
    passes, _ = stacked
    rng = np.random.default_rng(5)
    with Workers(1) as workers:
        moments = Accumulator(SIZE, BANDS, workers, specular=True)
        for pixels in passes:
            seen = rng.random((VIA_CAUSTIC + 1, SIZE, BANDS)).astype(np.float32)
            seen[:, 30:] = 0.0
            pixels.indirect[45:] = rng.random((5, BANDS))
            moments.add(pixels, seen)
        buffers, errors = moments.finish(2.0)
    rest = buffers["radiance"] - buffers["emission"] - buffers["residual"]
    np.testing.assert_allclose(rest, buffers["reflectance"] * buffers["shading"], atol=1e-5)
    np.testing.assert_array_equal(buffers["residual"][45:], buffers["indirect"][45:])
    np.testing.assert_array_equal(errors["residual"][45:], errors["radiance"][45:])
    assert (buffers["residual"][30:45] == 0.0).all()


def test_no_error_is_stated_where_every_pixel_emits():
    with Workers(1) as workers:
        moments = Accumulator(SIZE, BANDS, workers)
        for _ in range(2):
            assert not moments.states_error()
            pixels = empty_pixels(SIZE, BANDS)
            pixels.coverage[:] = 1.0
            pixels.emission[1:] = 1.0
            moments.add(pixels)
        assert moments.states_error()
        pixels.emission[:] = 1.0
        moments.add(pixels)
        assert not moments.states_error()
