"""Running moments against NumPy over the stacked passes."""

import numpy as np
import pytest

from photonmap.accumulate import Accumulator
from photonmap.passes import empty_pixels
from photonmap.workers import Workers

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
