"""Passes of fewer samples for loose errors: less work, the same image, the same bits."""

import math

import numpy as np
import pytest
from helpers.marks import slow

import photonmap as pm
from photonmap.film.budget import LEAST_PASSES, LEAST_PHOTONS, PASS_SAMPLES, Goal
from photonmap.integrators.adaptive_sampling import (
    LEAST_LIGHTS,
    LEAST_SHARE,
    LOOSE,
    MOST_LIGHTS,
    PER_EMITTER,
    choose_size,
    first_size,
    resize,
)
from photonmap.integrators.sampling_plan import SAMPLES
from photonmap.kernels.core.passes import SamplingPlan

OPTIONS = {"bands": "rgb", "size": (64, 64)}


@pytest.fixture(scope="module")
def full(cornell):
    return pm.render(cornell, **OPTIONS, passes=LEAST_PASSES, seed=1)


@pytest.fixture(scope="module")
def loose(cornell):
    return pm.render(cornell, **OPTIONS, error=0.2, seed=2)


def test_a_loose_error_takes_less_work(full, loose):
    assert full.record["error"] < 0.05
    assert full.record["pass_samples"] == 1.0
    assert loose.record["error"] < 0.2
    assert loose.record["passes"] == LEAST_PASSES
    assert loose.record["pass_samples"] == 0.125
    assert loose.record["photons"] == LEAST_PASSES * LEAST_PHOTONS
    assert loose.record["rays"] < 0.5 * full.record["rays"]


def test_the_image_stays_the_same(full, loose):
    for name in ("radiance", "direct", "indirect"):
        error = np.hypot(full.standard_error(name), loose.standard_error(name))
        off = np.abs(loose[name] - full[name]) > 1.96 * error
        assert 0.01 < off.mean() < 0.1, f"{name}: 95% intervals of 8 passes hold 90 to 99%"
        assert loose[name].mean() == pytest.approx(full[name].mean(), rel=0.02)
    np.testing.assert_array_equal(loose.object_id, full.object_id)


def test_passes_repeat_an_error(cornell, loose):
    """The first passes are kept where their size stays."""
    again = pm.render(cornell, **OPTIONS, passes=LEAST_PASSES, pass_samples=0.125, seed=2)
    for name, image in loose.buffers.items():
        np.testing.assert_array_equal(again.buffers[name], image)


def test_pilot_passes_that_are_too_small_are_discarded(cornell):
    """Their rays count as work, but the image is that of full passes."""
    small = {"bands": 1, "size": (16, 16), "seed": 3, "adaptive": False}
    aimed = pm.render(cornell, **small, error=0.02)
    count = aimed.record["passes"]
    full = pm.render(cornell, **small, passes=count)
    assert (aimed.record["pass_samples"], count > LEAST_PASSES) == (1.0, True)
    for name, image in full.buffers.items():
        np.testing.assert_array_equal(aimed.buffers[name], image)
    for name, error in full.errors.items():
        np.testing.assert_array_equal(aimed.errors[name], error)
    assert aimed.record["rays"] > full.record["rays"]


@pytest.mark.parametrize("error", [*slow(0.03), 0.3])
def test_a_resumed_render_keeps_its_size(cornell, tmp_path, error):
    """Whether it was chosen before the interruption or not."""
    small = {"bands": 1, "size": (16, 16), "checkpoint": tmp_path / "state"}
    whole = pm.render(cornell, error=error, **small)
    for passes in (1, 3):
        (tmp_path / "state").unlink()
        with pytest.warns(pm.SceneWarning, match=f"stopped after pass {passes}, before"):
            pm.render(cornell, passes=passes, error=error, **small)
        part = pm.render(cornell, error=error, resume=True, **small)
        assert part.record["pass_samples"] == whole.record["pass_samples"]
        np.testing.assert_array_equal(part.radiance, whole.radiance)


def test_the_cheapest_size_is_chosen():
    needed = dict(zip((LEAST_PASSES, 8, 20, 40, math.inf), (*PASS_SAMPLES, 1.0), strict=True))
    assert {passes: choose_size(passes) for passes in needed} == needed
    many = dict(zip((LEAST_PASSES, 6, 12, 25, math.inf), (*PASS_SAMPLES, 1.0), strict=True))
    assert {passes: choose_size(passes, many=True) for passes in many} == many
    assert first_size(Goal(LOOSE)) == 0.125
    assert first_size(Goal(0.9 * LOOSE)) == first_size(None) == 1.0


@pytest.mark.parametrize("emitters", [1, 5, 20])
@pytest.mark.parametrize("size", PASS_SAMPLES)
def test_as_many_rays_as_the_size_says(size, emitters):
    """Fewer of the camera first, at least one of each kind.

    Of lights at least 16 where there were more, and else a quarter, or two for each emitter; more
    on edges, as in the last pixel.
    """
    counts = np.array([[16, 4, 1, 1, 1, 16], [8, 1, 32, 1, 16, 4], [16, 4, 8, 0, 8, 4]], np.uint8)
    flat = np.array([1, 1, 1, 1, 1, 0], np.float32)
    plan = resize(SamplingPlan(*counts, np.zeros(6, np.float32)), size, flat, emitters)
    rays = plan.samples.astype(int) * [plan.lights, plan.gathers]
    assert (plan.samples >= 1).all()
    scale = np.where(flat, size, min(4 * size, 1.0))
    is_uneven = (counts[0] > SAMPLES) | (counts[0] * scale * counts[1] > MOST_LIGHTS)
    least = np.where(is_uneven, counts[0] * np.maximum(scale, 0.5), counts[0] * scale)
    np.testing.assert_array_equal(plan.samples, np.maximum(least, 1))
    wanted = np.maximum(np.ceil(counts[0] * scale * counts[1:]), counts[1:] > 0)
    lights = counts[0].astype(float) * counts[1]
    least = np.maximum(LEAST_SHARE * lights, min(PER_EMITTER * emitters, LEAST_LIGHTS))
    least = np.where(lights > LEAST_LIGHTS, LEAST_LIGHTS, np.minimum(least, lights))
    least = plan.samples * np.ceil(least / plan.samples)
    wanted[0] = np.maximum(wanted[0], least)
    np.testing.assert_array_equal(rays, wanted)


def test_a_size_that_there_is_not(cornell):
    with pytest.raises(pm.InputError, match=r"pass samples 0\.3 must be 0\.125, 0\.25, 0\.5 or 1"):
        pm.render(cornell, **OPTIONS, passes=1, pass_samples=0.3)
