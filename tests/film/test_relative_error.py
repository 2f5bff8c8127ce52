"""One definition of valid pixels and one of relative errors, wherever they are stated."""

from copy import copy

import numpy as np
import pytest
from helpers.estimates import empty_pixels

import photonmap as pm
from photonmap.dataset.files.derived_buffers import with_derived
from photonmap.film.moments import Accumulator
from photonmap.film.relative_error import dark_floor, relative_squares, squared_norm, valid_pixels
from photonmap.kernels.core.passes import EMPTY, FOUND
from photonmap.kernels.film.moments import is_valid
from photonmap.results.merge import relative_error
from photonmap.runtime.workers import Workers
from photonmap.study.errors import counted_pixels, stated_error

BANDS = 2
CASES = [
    (coverage, emits, found)
    for coverage in (0.0, 0.5, 1.0)
    for emits in (False, True)
    for found in (0, EMPTY, FOUND, EMPTY | FOUND)
]
"""Coverage, whether anything emits, and what gather rays found, pixel by pixel."""


def passes():
    rng = np.random.default_rng(3)
    for _ in range(3):
        pixels = empty_pixels(len(CASES), BANDS)
        for index, (coverage, emits, found) in enumerate(CASES):
            pixels.coverage[index], pixels.lookups[index] = coverage, found
            pixels.emission[index, 1] = 0.3 if emits else 0.0
        pixels.direct[:] = rng.random(pixels.direct.shape)
        yield pixels


@pytest.fixture(scope="module")
def moments():
    with Workers(1) as workers:
        moments = Accumulator(len(CASES), BANDS, workers)
        for pixels in passes():
            moments.add(pixels)
        yield moments


@pytest.mark.parametrize("lit", [False, True])
def test_pixels_are_valid_in_kernels_as_in_images(moments, lit):
    expected = [
        coverage == 1.0 and not emits and not (lit and found == EMPTY)
        for coverage, emits, found in CASES
    ]
    np.testing.assert_array_equal(moments.valid(lit), expected)
    of_kernel = [is_valid(moments._moments, lit, pixel) for pixel in range(len(CASES))]
    np.testing.assert_array_equal(of_kernel, expected)


@pytest.mark.parametrize("lit", [False, True])
def test_moments_and_images_state_the_same_error(moments, lit):
    buffers, errors = moments.finish(1.0)
    unresolved = moments.unresolved() & lit
    valid = valid_pixels(buffers["coverage"], buffers["emission"], unresolved)
    squares = errors["radiance"][valid].astype(float) ** 2
    relative = relative_squares(squares, buffers["radiance"][valid].astype(float))
    assert moments.error(lit=lit) == pytest.approx(np.sqrt(relative.mean()), rel=1e-5)


@pytest.fixture(scope="module")
def result():
    """A render with pixels that nothing resolves, made so."""
    result = pm.render(pm.scenes.cornell_box(), bands=BANDS, size=(16, 12), passes=3, photons=900)
    result.buffers["unresolved"] = result.unresolved.copy()
    result.buffers["unresolved"][6:] = True
    return result


def test_records_studies_and_data_sets_agree(result):
    valid = valid_pixels(result.coverage, result.emission, result.unresolved)
    assert 0 < valid.sum() < 6 * 16
    np.testing.assert_array_equal(counted_pixels(result), valid)
    np.testing.assert_array_equal(with_derived(result).buffers["valid"], valid)
    assert stated_error(result, "radiance", valid) == pytest.approx(relative_error(result))


def test_a_render_records_the_error_of_its_images():
    result = pm.render(pm.scenes.cornell_box(), bands=BANDS, size=(16, 12), passes=3, photons=900)
    assert result.record["standard_error"] == pytest.approx(relative_error(result), rel=1e-5)


def test_where_every_pixel_emits_there_is_no_error(result):
    lamp = copy(result)
    lamp.buffers = {**result.buffers, "emission": np.ones_like(result.emission)}
    assert relative_error(lamp) == 0.0


def test_black_bands_have_no_error():
    values = np.array([[0.0, 2.0], [0.0, 4.0]])
    np.testing.assert_allclose(dark_floor(values.mean(axis=0)), [0.0, 0.09])
    np.testing.assert_allclose(squared_norm(values), [[0.0, 4.09], [0.0, 16.09]])
    relative = relative_squares(np.ones((2, 2)), values)
    np.testing.assert_allclose(relative, [[0.0, 1 / 4.09], [0.0, 1 / 16.09]])
