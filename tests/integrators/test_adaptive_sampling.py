"""Sampling goes where the error is: less error for the rays traced, no bias, the same bits."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within
from helpers.marks import slow
from helpers.scenes import quad

import photonmap as pm
from photonmap.integrators.adaptive_sampling import LEAST, MOST, WARM_UP_PASSES, _share_out

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
    whole = pm.render(ball, **OPTIONS, passes=WARM_UP_PASSES + 3)
    for passes in (WARM_UP_PASSES - 2, WARM_UP_PASSES + 1, WARM_UP_PASSES + 3):
        parts = pm.render(
            ball, **OPTIONS, passes=passes, checkpoint=tmp_path / "ball.checkpoint",
            resume=passes >= WARM_UP_PASSES,
        )  # fmt: skip
    for name, image in whole.buffers.items():
        np.testing.assert_array_equal(parts.buffers[name], image)


def test_where_the_error_is_even_nothing_changes(cornell):
    options = {"bands": "rgb", "size": (16, 16), "passes": WARM_UP_PASSES}
    even = pm.render(cornell, **options, adaptive=False)
    np.testing.assert_array_equal(pm.render(cornell, **options).radiance, even.radiance)


def test_powers_cost_no_more_than_before():
    random = np.random.default_rng(3)
    need, cost = random.normal(0.0, 2.0, (9, 7)), random.uniform(1.0, 50.0, (9, 7))
    sample_scales = _share_out(need, cost)
    assert LEAST <= sample_scales.min() <= sample_scales.max() <= MOST
    assert 0.9 * cost.sum() < (cost * 2.0**sample_scales).sum() <= cost.sum()
