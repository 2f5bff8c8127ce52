"""Illuminations: which light group takes which colour and share, and lights drawn at random."""

from collections import Counter

import numpy as np
import pytest
from helpers.generated import lit, unlit

from photonmap.dataset.scenes.build import draw_illumination
from photonmap.dataset.scenes.exposure import LEVEL, deal, set_levels
from photonmap.dataset.scenes.illumination import (
    CLEAR_SKY,
    ILLUMINATIONS,
    MAIN_SHARE,
    NAMED,
    ULTRAVIOLET,
    Illumination,
    choose_illumination,
    is_sky,
    light_spectrum,
)
from photonmap.dataset.scenes.random_lights import (
    LEAST_SHARE,
    MOST_LIGHTS,
    RANDOM,
    RandomLights,
    draw_lamp,
    draw_shares,
    draw_sky,
)
from photonmap.errors import InputError
from photonmap.spectra.observer import luminance

DRAWS = 4000


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


def test_illuminations_are_of_luminance_one_but_for_ultraviolet_of_radiance_one():
    for (name,) in ULTRAVIOLET.values():
        light = light_spectrum(name)
        assert np.trapezoid(light.values, light.wavelengths) == pytest.approx(300.0)
        assert luminance(light) < 0.01
    for kind in set(NAMED) - set(ULTRAVIOLET):
        for seed in range(4):
            for name in choose_illumination(kind, random(seed)).colors:
                assert luminance(light_spectrum(name)) == pytest.approx(1.0)


def test_shares_are_those_of_the_mean_irradiance_and_the_median_is_the_level():
    received = {
        "first": random(1).uniform(0.1, 3.0, 300),
        "second": random(2).uniform(0.0, 1.0, 300),
    }
    for shares, expected in (((), (MAIN_SHARE, 1.0 - MAIN_SHARE)), ((0.2, 0.8), (0.2, 0.8))):
        set_ = set_levels(Illumination("mine", ("HPS", "A"), shares), received)
        sent = [level * received[group] for _, level, [group] in set_]
        assert np.median(sum(sent)) == pytest.approx(LEVEL)
        parts = np.array([each.mean() for each in sent])
        np.testing.assert_allclose(parts / parts.sum(), expected, rtol=1e-9)
    [(color, level, groups)] = set_levels(Illumination("mine", ("D65",)), received)
    assert (color, groups) == ("D65", ["first"])
    assert level == pytest.approx(LEVEL / np.median(received["first"]))


@pytest.mark.parametrize(
    ("colors", "groups", "lit"),
    [
        (("HPS",), ("window", "lamp"), {"lamp": "HPS"}),
        (("D65",), ("window", "lamp"), {"window": "D65"}),
        (("D65",), ("lamp", "window"), {"lamp": "D65"}),
        (("planck:9000", "A"), ("lamp", "window"), {"lamp": "A", "window": "planck:9000"}),
        (("A", "planck:9000"), ("window", "lamp"), {"lamp": "A", "window": "planck:9000"}),
        (
            ("planck:2300", "HPS"),
            ("window", "lamp", "lamp 2"),
            {"lamp": "planck:2300", "lamp 2": "HPS"},
        ),
        (("HPS",), ("key light", "side light"), {"key light": "HPS"}),
        (
            ("A", "daylight:5000", "HPS"),
            ("lamp", "window", "lamp 2", "lamp 3"),
            {"lamp": "A", "window": "daylight:5000", "lamp 2": "HPS"},
        ),
    ],
)
def test_windows_take_the_colour_of_a_sky(colors, groups, lit):
    dealt = deal(Illumination("mine", colors), groups)
    assert {named[0]: color for color, _, named in dealt} == lit
    usual = (1.0 - MAIN_SHARE) / (len(colors) - 1) if len(colors) > 1 else 1.0
    for _, share, named in dealt:
        first = named[0] == min(lit, key=groups.index) and len(colors) > 1
        assert share == pytest.approx(MAIN_SHARE if first else usual)


def is_lit(mesh):
    """Return whether it emits, or shows the sky."""
    return mesh.material.portal or luminance(mesh.material.emission) > 0.0


@pytest.mark.parametrize("name", ["bedroom", "kitchen"])
@pytest.mark.parametrize("light", ["two_mixed", "colored"])
def test_windows_are_dark_where_no_light_is_a_sky(name, light):
    """Not orange where the room is lit by sodium: with two lamps as with one."""
    colors = draw_illumination(name, 0, light).colors
    room = unlit(name)
    for sodium in (colors if not any(map(is_sky, colors)) else ("HPS",), ("HPS", "LED-B3")):
        scene = room.lit(Illumination("night", sodium))
        emitting = {m.name for m in scene.meshes if is_lit(m)}
        assert emitting
        assert not scene.lights
        assert not any(each.startswith("window") for each in emitting)


def test_given_shares_stay_with_their_colours():
    mine = Illumination("mine", ("A", "D65", "HPS"), (0.1, 0.7, 0.2))
    dealt = deal(mine, ("window", "lamp", "lamp 2"))
    assert dealt == [("A", 0.1, ["lamp"]), ("D65", 0.7, ["window"]), ("HPS", 0.2, ["lamp 2"])]


def test_spare_lamps_burn_with_the_first():
    [(_, _, groups)] = deal(Illumination("mine", ("HPS",)), ("window", "lamp", "lamp 2", "lamp 3"))
    assert groups == ["lamp", "lamp 2", "lamp 3"]
    received = {"window": np.ones(1), "lamp": np.ones(1), "lamp 2": np.ones(1)}
    [(_, level, _)] = set_levels(Illumination("mine", ("HPS",)), received)
    assert level == pytest.approx(0.5 * LEVEL)


@pytest.mark.parametrize("name", ["castle", "kitchen", "gallery", "bedroom"])
def test_scenes_have_a_group_for_every_light_that_is_drawn(name):
    assert len(unlit(name).received) >= MOST_LIGHTS
    scene = lit(name, 0, f"random_{MOST_LIGHTS}")
    assert len({id(m.material) for m in scene.meshes if is_lit(m)}) == MOST_LIGHTS
    windows = [m for m in scene.meshes if m.name.startswith("window")]
    assert len({m.material.name for m in windows if m.material.portal}) == bool(windows)
    assert len(scene.lights) == bool(windows)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), r"illumination 'x' has the colours \(\); give one or more in a tuple"),
        (("D65",), "has the colours 'D65'; give one or more in a tuple"),
        ((("A", "D65"), (0.5,)), "has 2 colours and 1 shares; give one share for each colour"),
        ((("A", "D65"), (0.5, 0.6)), "positive numbers that add up to 1"),
        ((("A", "D65"), (1.5, -0.5)), "positive numbers that add up to 1"),
    ],
)
def test_bad_illuminations(arguments, message):
    with pytest.raises(InputError, match=message):
        Illumination("x", *(arguments or ((),)))


def test_more_colours_than_groups():
    with pytest.raises(InputError, match=r"3 colours, but there are 2 light groups \(a, b\)"):
        deal(Illumination("x", ("D65", "A", "D50")), ("a", "b"))


@pytest.mark.parametrize(("least", "most"), [(0, 2), (3, 2), (1, MOST_LIGHTS + 1)])
def test_bad_numbers_of_lights(least, most):
    with pytest.raises(InputError, match="give two numbers from 1 to 4, the lower one first"):
        RandomLights("x", least, most)


def test_random_lights_are_deterministic_and_differ_between_seeds():
    first = [draw_illumination("study", seed, "random") for seed in range(20)]
    assert first == [draw_illumination("study", seed, "random") for seed in range(20)]
    assert len({each.colors for each in first}) == 20
    assert draw_illumination("study", 0, "random_3") != draw_illumination("jug", 0, "random_3")


def test_numbers_of_lights_are_uniform_and_one_of_several_is_a_sky():
    rng = random(5)
    drawn = [choose_illumination("random", rng) for _ in range(DRAWS)]
    counts = Counter(len(each.colors) for each in drawn)
    assert sorted(counts) == list(range(1, MOST_LIGHTS + 1))
    expected = DRAWS / MOST_LIGHTS
    for count in counts.values():
        assert abs(count - expected) < 4.0 * np.sqrt(expected)
    for each in drawn:
        assert sum(map(is_sky, each.colors)) >= (len(each.colors) > 1)
        assert len(set(each.colors)) == len(each.colors) == len(each.shares)
    alone = [is_sky(each.colors[0]) for each in drawn if len(each.colors) == 1]
    assert np.mean(alone) == pytest.approx(0.54, abs=0.05), "half, and the cooler black bodies"
    assert {len(RANDOM["random_3"].draw(rng)[0]) for _ in range(50)} == {3}


@pytest.mark.parametrize("count", [2, 3, 4])
def test_shares_are_uniform_above_the_least(count):
    """Moments of Dirichlet(1, …, 1): mean 1 / n and variance (n − 1) / n² / (n + 1)."""
    rng = random(count)
    shares = np.array([draw_shares(rng, count) for _ in range(DRAWS)])
    assert shares.min() >= LEAST_SHARE - 1e-3
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-9)
    free = (shares - LEAST_SHARE) / (1.0 - count * LEAST_SHARE)
    np.testing.assert_allclose(free.mean(axis=0), 1.0 / count, atol=0.02)
    variance = (count - 1) / count**2 / (count + 1)
    np.testing.assert_allclose(free.var(axis=0), variance, rtol=0.1)
    if count == 2:
        steps = np.sort(free[:, 0])
        assert np.abs(steps - (np.arange(DRAWS) + 0.5) / DRAWS).max() < 1.63 / np.sqrt(DRAWS)


def test_families_of_lamps_are_equally_frequent(monkeypatch):
    monkeypatch.delenv("PHOTONMAP_ILLUMINANTS", raising=False)
    rng = random(7)
    names = [draw_lamp(rng) for _ in range(DRAWS)]
    black = np.array([float(n.removeprefix("planck:")) for n in names if n.startswith("planck:")])
    heads = Counter(n[:4] if n.startswith("LED-") else n.rstrip("0123456789.") for n in names)
    for count in (len(black), heads["LED-"], heads["FL"], heads["HP"]):
        assert abs(count - DRAWS / 5) < 4.0 * np.sqrt(DRAWS / 5)
    mired = 1e6 / black
    low, high = 1e6 / 8000.0, 1e6 / 1800.0
    assert mired.mean() == pytest.approx(0.5 * (low + high), rel=0.02)
    assert mired.std() == pytest.approx((high - low) / np.sqrt(12.0), rel=0.05)
    skies = np.array([float(draw_sky(rng).removeprefix("daylight:")) for _ in range(500)])
    assert 4000.0 <= skies.min() < 4300.0
    assert 18000.0 < skies.max() <= 25000.0


def test_measured_lights_of_the_user_are_drawn(tmp_path, monkeypatch):
    from photonmap.dataset.scenes import random_lights
    from photonmap.spectra.curves import SpectrumSet

    mine = SpectrumSet([300, 1000], [[1, 2]], ("my lamp",))
    monkeypatch.setenv("PHOTONMAP_ILLUMINANTS", str(tmp_path / "set.mat"))
    monkeypatch.setattr(random_lights, "measured_illuminants", lambda: mine)
    rng = random(1)
    assert "sfu:my lamp" in {draw_lamp(rng) for _ in range(400)}


def test_the_fixed_illuminations_stay():
    assert ILLUMINATIONS == ("white", "colored", "two_planckian", "two_mixed")
    assert set(NAMED) == {*ILLUMINATIONS, *RANDOM, CLEAR_SKY, *ULTRAVIOLET}
