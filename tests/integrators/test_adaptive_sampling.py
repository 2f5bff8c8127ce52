"""Sampling goes where the error is: less error for the rays traced, no bias, the same bits."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within
from helpers.estimates import empty_pixels
from helpers.marks import slow
from helpers.scenes import quad

import photonmap as pm
from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.integrators.adaptive_sampling import (
    LEAST,
    MOST,
    PILOT_PASSES,
    WINDOWS,
    AdaptiveSampling,
    _share_out,
    scale_plan,
)
from photonmap.kernels.core.passes import Estimate, Film, SamplingPlan
from photonmap.kernels.film.pixels import FLAT

EIGHT = max(WINDOWS)
OPTIONS = {"bands": "rgb", "size": (48, 48)}


@pytest.fixture(scope="module")
def ball():
    """A ball on a wide floor under a lamp: most of the image is floor without a shadow."""
    sphere = trimesh.creation.icosphere(3, 1.0)
    floor = quad((-20, 0, -20), (-20, 0, 20), (20, 0, 20), (20, 0, -20))
    ball = pm.Mesh(sphere.vertices + [0.0, 1.0, 0.0], sphere.faces, pm.Material("ball", 0.5))
    lamp = pm.Material("lamp", 0.0, 20.0)
    light = quad((4, 6, -1), (6, 6, -1), (6, 6, 1), (4, 6, 1), lamp, "lamp")
    return pm.Scene([floor, ball, light], [], pm.Camera((0, 8, 16), (0, 0, 0), fov=40), "ball")


@pytest.fixture(scope="module", params=["box", *slow("center")])
def pair(request, ball):
    options = {**OPTIONS, "pixel": request.param, "passes": 64}
    return [pm.render(ball, **options, adaptive=adaptive, seed=adaptive) for adaptive in (0, 1)]


def test_variance_falls_by_more_than_rays_rise(pair):
    """The plan keeps the rays that it counts on; more of them are traced, as fewer miss."""
    even, scale_plan = (result.record for result in pair)
    rays = scale_plan["rays"] / even["rays"]
    assert rays < 1.2
    assert rays * (scale_plan["standard_error"] / even["standard_error"]) ** 2 < 0.85


def test_the_image_stays_the_same(pair):
    even, scale_plan = pair
    error = np.hypot(even.standard_error("radiance"), scale_plan.standard_error("radiance"))
    assert_within(scale_plan.radiance, even.radiance, error, sigmas=6.0)
    # Pixels share photons, so that errors of sums follow from theirs for direct light alone.
    total = np.sqrt(sum((run.errors["direct"].astype(float) ** 2).sum() for run in pair))
    assert abs(scale_plan.direct.sum(dtype=float) - even.direct.sum(dtype=float)) < 4.0 * total
    blocks = [run.block_mean("indirect") for run in pair]
    error = np.hypot(*(run.block_error("indirect") for run in pair))
    assert_within(*blocks, error, sigmas=6.0)


def test_a_resumed_render_goes_on_as_it_was_focused(ball, tmp_path):
    first, last = WINDOWS
    whole = pm.render(ball, **OPTIONS, passes=last + 3)
    for passes in (first - 1, first + 2, last + 1, last + 3):
        parts = pm.render(
            ball, **OPTIONS, passes=passes, checkpoint=tmp_path / "ball.checkpoint",
            resume=passes >= first,
        )  # fmt: skip
    for name, image in whole.buffers.items():
        np.testing.assert_array_equal(parts.buffers[name], image)


def learn(spread, size=16, passes=EIGHT, surfaces=None):
    """What is learnt from passes whose direct and indirect light have these spreads, (2, P).

    If they are trial passes, by what is begun again.
    """
    random, pixels = np.random.default_rng(5), size * size
    film, columns = Film(size, size, True), SpectralColumns(np.zeros(1, np.intp))
    plan = SamplingPlan(*np.full((3, pixels), 8, np.uint8), np.ones(pixels, np.float32))
    adaptive = AdaptiveSampling(film, columns, surfaces=surfaces)
    for index in range(passes):
        estimate = Estimate(empty_pixels(pixels, 1), None)
        estimate.pixels.coverage[:] = 1.0
        light = 10.0 + spread * random.standard_normal((2, pixels))
        estimate.pixels.direct[:, 0], estimate.pixels.indirect[:, 0] = light
        adaptive.learn(index, estimate, plan)
    if passes == PILOT_PASSES:
        adaptive.begin_again(estimate, plan)
        assert not adaptive.moments.any()
    return plan, adaptive.sample_scales


def test_where_the_error_is_even_nothing_changes():
    assert not learn(np.full((2, 256), 0.3))[1].any()


def test_light_samples_and_gather_rays_are_decided_on_apart():
    column = np.arange(256) % 16
    noisy = np.stack([column < 4, column >= 12])
    plan, scales = learn(np.where(noisy, 4.0, 0.1))
    inner = ~np.isin(column, (3, 4, 5, 10, 11, 12))  # where windows hold either kind alone
    for half in scales:
        assert (half[noisy & inner] >= 0).all()
        assert (half[noisy & inner] > 0).mean() > 0.9, "what two passes show is noisy itself"
        assert (half[~noisy & inner] == LEAST).all()
        scaled = scale_plan(plan, half, spreads=True)
        for scale, counts in zip(half, (scaled.lights, scaled.gathers), strict=True):
            np.testing.assert_array_equal(scaled.samples.astype(int) * counts, 64 * 2.0**scale)


def test_trial_passes_decide_for_both_halves():
    left = np.arange(256) % 16 < 8
    _, (one, two) = learn(np.where(left, 4.0, 0.1) * np.ones((2, 1)), passes=PILOT_PASSES)
    np.testing.assert_array_equal(one, two)
    far = np.abs(np.arange(256) % 16 - 7.5) > 3.0
    assert one[:, left & far].mean() > 0.3
    assert (one[:, ~left & far] == LEAST).all()


def test_flat_pixels_need_less_where_light_is_filtered():
    plane = np.zeros((256, 7), np.float32)
    plane[:, FLAT] = left = np.arange(256) % 16 < 8
    scales = learn(np.full((2, 256), 0.3), surfaces=lambda: plane)[1]
    assert scales[..., left].mean() < -0.3
    assert scales[..., ~left].mean() > 0.3


def test_scales_cost_no_more_than_before():
    random = np.random.default_rng(3)
    need, cost = random.normal(0.0, 2.0, (2, 63)), random.uniform(1.0, 50.0, (2, 63))
    sample_scales = _share_out(need, cost)
    assert LEAST <= sample_scales.min() <= sample_scales.max() <= MOST
    assert 0.9 * cost.sum() < (cost * 2.0**sample_scales).sum() <= cost.sum()
