"""Filtered light: less noise, errors that hold, and the same bits as ever."""

from types import SimpleNamespace

import numpy as np
import pytest
from helpers.scenes import quad
from scipy.ndimage import uniform_filter

import photonmap as pm
from photonmap.film.light_filter import LightFilter
from photonmap.film.moments import Accumulator
from photonmap.kernels.core.passes import Film, Pixels
from photonmap.results.merge import REQUIRED
from photonmap.runtime.workers import Workers

SIDE, PASSES = 64, 16


def filtered(*lights, rng, kind="direct", reflectance=0.5, passes=PASSES):
    """Moments of a flat surface under some lights: before and after, the whole and each light.

    Of each, what reaches pixels, (P, N), and the noise of a pass.
    """
    size, bands = lights[0][0].shape
    plane = np.zeros((size, 7), np.float32)
    plane[:, 0], plane[:, 1] = np.divmod(np.arange(size), SIDE)
    plane[:, 5:] = 1.0
    nothing = np.zeros((size, bands), np.float32)
    whole = np.full((size, bands), reflectance, np.float32)
    count = 1 + len(lights) * (len(lights) > 1)
    with Workers(2) as workers:
        moments = [Accumulator(size, bands, workers) for _ in range(count)]
        kept = LightFilter([kind], Film(SIDE, SIDE, True), workers, lambda: plane)
        kept.follow(moments)
        for index in range(passes):
            groups = [reflectance * (light + noise(rng, (size, 1))) for light, noise in lights]
            for light, own in enumerate([sum(groups), *groups][:count]):
                pixels = Pixels(
                    nothing, nothing, nothing, whole, nothing, nothing,
                    np.ones(size, np.float32), np.zeros(size, np.uint8), plane,
                )._replace(**{kind: own.astype(np.float32)})  # fmt: skip
                kept.add(pixels, light, index, 1.0)
                moments[light].add(pixels)
        images = [[each.finish(1.0) for each in stage] for stage in (moments, kept.apply())]
    return [[SimpleNamespace(value=b[kind], error=e[kind]) for b, e in s] for s in images]


def normal(rng, shape):
    return 0.1 * rng.standard_normal(shape)


def rare(rng, shape):
    """Of mean 0: one pass in eight meets what the others miss."""
    return 0.7 * (rng.random(shape) < 0.125) - 0.0875


@pytest.mark.parametrize(("noise", "passes"), [(normal, PASSES), (normal, 4), (rare, PASSES)])
def test_even_light_has_less_noise_as_errors_state(noise, passes):
    light = np.ones((SIDE * SIDE, 2)) * [1.0, 2.0]
    (before,), (after,) = filtered((light, noise), rng=np.random.default_rng(1), passes=passes)
    off = after.value - 0.5 * light
    assert (off**2).mean() < 0.11 * ((before.value - 0.5 * light) ** 2).mean()
    assert 0.85 < (off**2).mean() / (after.error**2).mean() < 1.15
    assert 0.93 < (np.abs(off) < 1.96 * after.error).mean() < 0.98


@pytest.mark.parametrize(("across", "passes"), [(3, PASSES), (3, 4), (7, PASSES)])
def test_errors_hold_where_neighbours_share_noise(across, passes):
    """As those of indirect light do."""
    even = np.ones((SIDE * SIDE, 1))

    def shared(rng, shape):
        noise = rng.standard_normal((SIDE, SIDE))
        return 0.1 * across * uniform_filter(noise, across, mode="wrap").reshape(shape)

    rng = np.random.default_rng(4)
    (before,), (after,) = filtered((even, shared), rng=rng, kind="indirect", passes=passes)
    off = after.value - 0.5 * even
    assert (off**2).mean() < 0.9 * ((before.value - 0.5 * even) ** 2).mean()
    assert 0.85 < (off**2).mean() / (after.error**2).mean() < 1.15
    least = 0.93 if passes == PASSES else 0.9  # as the variance of four values is uncertain
    assert least < (np.abs(off) < 1.96 * after.error).mean() < 0.98


@pytest.mark.parametrize("width", [0.5, 2.0, 6.0])
def test_edges_of_shadows_stay(width):
    """Of any width, and where one side has no noise."""
    across = np.arange(SIDE * SIDE) % SIDE - SIDE / 2 + 0.5
    light = 1.2 + np.tanh(across / width)[:, None]
    quiet = (across > 2.0 * width)[:, None]

    def noise(rng, shape):
        return np.where(quiet, 0.0, normal(rng, shape))

    (before,), (after,) = filtered((light, noise), rng=np.random.default_rng(2))
    far = (across > 2.0 * width + 6.0)[:, None]
    np.testing.assert_array_equal(after.value[far], before.value[far])
    z, plain = (
        np.abs(each.value - 0.5 * light)[~far] / np.maximum(each.error[~far], 1e-6)
        for each in (after, before)
    )
    assert (z < 1.96).mean() > 0.92
    assert (z > 4.0).sum() <= (plain > 4.0).sum()


def test_light_groups_add_up_and_each_keeps_its_shadows():
    """Also where the noise of another hides them in the whole."""
    across = np.arange(SIDE * SIDE) % SIDE - SIDE / 2 + 0.5
    shadow = np.where(across > 0.0, 0.02, 0.0)[:, None]

    def quiet(rng, shape):
        return np.where(across[:, None] > 0.0, 0.01 * normal(rng, shape), 0.0)

    even = np.ones((SIDE * SIDE, 1))
    before, after = filtered((even, normal), (shadow, quiet), rng=np.random.default_rng(3))
    # but for what blocks return by each light's own variance: results hold the sums
    np.testing.assert_allclose(after[0].value, after[1].value + after[2].value, 1e-4)
    for plain, own, light in zip(before, after, (even + shadow, even, shadow), strict=True):
        off = np.abs(own.value - 0.5 * light)
        assert (off**2).mean() < 0.5 * ((plain.value - 0.5 * light) ** 2).mean()
        assert 0.92 < (off <= 1.96 * own.error + 1e-9).mean() < 0.99
    assert not after[2].value[across < 0.0].any()


@pytest.fixture(scope="module")
def settings():
    """Of a plate that shades a floor, under a lamp."""
    plate = quad((-0.4, 0.5, 0.4), (0.4, 0.5, 0.4), (0.4, 0.5, -0.4), (-0.4, 0.5, -0.4))
    floor = quad((-3, 0, 3), (3, 0, 3), (3, 0, -3), (-3, 0, -3))
    lamp = pm.Material("lamp", 0.0, (6.0, 5.0, 4.0))
    lamp = quad((-0.5, 2, -0.5), (0.5, 2, -0.5), (0.5, 2, 0.5), (-0.5, 2, 0.5), lamp, "lamp")
    scene = pm.Scene([plate, floor, lamp], camera=pm.Camera((0.0, 1.8, 2.5), (0.0, 0.2, 0.0)))
    return {"scene": scene, "bands": 3, "size": (48, 36), "photons": 4096}


def test_renders_add_up_and_stay_where_they_are_not_filtered(settings):
    options = {**settings, "passes": 20, "adaptive": False}  # so that samples are the same
    own, plain = (pm.render(**options, filter_light=on) for on in (True, False))
    np.testing.assert_array_equal(own.radiance, (own.emission + own.direct) + own.indirect)
    np.testing.assert_allclose(own.reflectance * own.shading, own.direct + own.indirect, 1e-5)
    stays = np.ones(own.direct.shape[:2], bool)
    for name in ("direct", "indirect"):
        same = (own.errors[name] == plain.errors[name]).all(axis=-1)
        assert own.record["light_filter"][name]["pixels"] >= (~same).sum() > 100
        np.testing.assert_array_equal(own.buffers[name][same], plain.buffers[name][same])
        assert own.errors[name][~same].mean() < plain.errors[name][~same].mean()
        np.testing.assert_allclose(own.block_mean(name), plain.block_mean(name), 1e-5)
        np.testing.assert_array_equal(own.buffers[f"{name}_unfiltered"], plain.buffers[name])
        stays &= same
    for name in ("shading", "radiance"):
        np.testing.assert_array_equal(own.buffers[name][stays], plain.buffers[name][stays])
        assert own.errors[name][~stays].mean() < plain.errors[name][~stays].mean()


def test_filtered_renders_have_the_same_bits_by_any_way(settings, tmp_path):
    options = {**settings, "filter_light": True}
    whole = pm.render(**options, passes=22, threads=1)
    for passes, resume in ((17, False), (22, True)):
        parted = pm.render(
            **options, passes=passes, threads=3, checkpoint=tmp_path / "a.checkpoint", resume=resume
        )
    assert whole.arrays.keys() == parted.arrays.keys()
    for name, image in whole.arrays.items():
        np.testing.assert_array_equal(image, parted.arrays[name], name)


def test_a_goal_is_met_by_filtered_light(settings):
    options = {**settings, "error": "direct:0.0062", "pass_samples": 1.0}
    own, plain = (pm.render(**options, filter_light=on).record for on in (True, False))
    assert own["passes"] < plain["passes"]
    assert own["goal"]["reached"] <= 0.0062


@pytest.mark.parametrize(
    "option",
    [
        {"method": "path"},
        {"passes": 3},
        {"effects": "indirect,emission"},
    ],
)
def test_what_is_not_filtered_says_why(settings, option):
    options = {**settings, "passes": 16, "size": 8, "filter_light": True, **option}
    made = pm.render(**options).record["light_filter"]
    for kind in ("direct",) if "effects" in option else ("direct", "indirect"):
        assert not made[kind]["on"]
        assert made[kind]["why"]


def test_runs_are_not_merged_without_their_plain_means(settings):
    parts = [pm.render(**settings, passes=8, seed=seed).select(REQUIRED) for seed in range(2)]
    with pytest.raises(pm.InputError, match=r"unfiltered.* are missing"):
        pm.merge(parts)
