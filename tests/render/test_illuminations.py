"""Scenes that differ in the spectra of their lights alone, rendered together."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.compile.illuminations import combine, gather
from photonmap.render_illuminations import render_illuminations
from photonmap.settings import Options
from photonmap.spectra.bands import Bands

BANDS = Bands.parse(4)
RED, BLUE = (pm.Spectrum([380.0, 780.0], values) for values in ([0.2, 2.0], [3.0, 1.0]))
CAMERA = pm.Camera((0.0, 1.2, 1.2), (0.0, 0.0, 0.0), fov=40.0)


def square(name, height, material):
    """Return a square that faces up, or down if it is above the camera."""
    corners = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]) + [0.0, height, 0.0]
    faces = np.array([[0, 2, 1], [0, 3, 2]])
    return pm.Mesh(corners, faces[:, ::-1] if height else faces, material, name)


def scene(lamp, sky=0.0, floor=0.5):
    """Return a floor below a lamp and a dome; what is 0 is off."""
    meshes = [
        square("floor", 0.0, pm.Material("floor", floor)),
        square("lamp", 2.0, pm.Material("lit" if lamp else "off", 0.3, lamp)),
    ]
    return pm.Scene(meshes, [pm.DomeLight(sky, "sky")] if sky else [], CAMERA)


def render(*scenes, **budget):
    options = Options(bands=4, size=(8, 6), photons=256, per_light=True, threads=1, **budget)
    return list(render_illuminations(scenes, options))


def test_light_is_that_of_groups_times_a_factor_in_each_band():
    one, two = render(scene(RED), scene(BLUE, RED * 0.5), passes=9)
    assert list(one.per_light) == ["lit"]
    assert list(two.per_light) == ["lit", "sky"]
    ratio = (BANDS.emission(BLUE) / BANDS.emission(RED)).astype(np.float32)
    for name in ("direct@lit", "indirect@lit", "shading@lit"):
        assert np.allclose(two.buffers[name], ratio * one.buffers[name], rtol=1e-5)
        assert np.allclose(two.errors[name], ratio * one.errors[name], rtol=1e-3)
    assert np.array_equal(one.radiance, one.emission + one.direct + one.indirect)
    assert np.array_equal(two.direct, two.buffers["direct@lit"] + two.buffers["direct@sky"])
    assert two.record["materials"] == ["floor", "lit"]
    alone = np.hypot(two.errors["direct@lit"], two.errors["direct@sky"])
    assert (two.errors["direct"] < 1.5 * alone + 1e-9).all()


def test_passes_go_on_until_the_worst_meets_the_goal():
    results = render(scene(RED), scene(BLUE, RED), scene(0.0, RED), error="direct:0.3")
    assert len({result.record["passes"] for result in results}) == 1
    for result in results:
        assert result.record["goal"]["reached"] <= 0.3


def test_what_differs_otherwise_is_not_combined():
    violet, red = (pm.Spectrum([450.0, 650.0], values) for values in ([1.0, 0.0], [0.0, 1.0]))
    glowing = pm.Material("glowing", 0.5, fluorescence=pm.Fluorescence(violet, red, 0.5))
    others = [scene(RED, floor=0.4), scene((1.0, 0.5, 0.2)), scene(0.0, RED)]
    assert all(combine([scene(RED), other], BANDS) is None for other in others)
    glow = pm.Scene(
        [square("floor", 0.0, glowing), square("lamp", 2.0, pm.Material("l", 0.0, RED))]
    )
    assert combine([glow, glow], BANDS) is None
    assert gather([scene(RED), others[0], scene(BLUE), scene(0.0, RED)], BANDS) == [
        [0, 2],
        [1],
        [3],
    ]
    both, uneven = scene(RED, RED), scene(RED * 4.0, RED)
    assert gather([scene(RED), both, scene(0.0, BLUE), uneven], BANDS) == [[0, 1, 2], [3]]


@pytest.mark.slow
def test_images_and_errors_are_those_of_renders_by_themselves():
    """Over seeds, errors say how far images spread, and means are those of renders alone."""
    scenes = scene(RED), scene(BLUE, RED * 0.5)
    options = {"bands": 4, "size": (8, 6), "photons": 256, "per_light": True, "passes": 16}
    for number in range(2):
        pairs = [
            (render(*scenes, passes=16, seed=seed)[number],
             pm.render(scenes[number], seed=100 + seed, threads=1, **options))
            for seed in range(12)
        ]  # fmt: skip
        for name in ("direct", "indirect", "shading"):
            both = [np.array([pair[k].buffers[name] for pair in pairs]) for k in range(2)]
            errors = np.array([pair[0].errors[name] for pair in pairs], np.float64)
            spread = both[0].std(axis=0, ddof=1)
            seen = (spread > 0.0) & (errors > 0.0).all(axis=0)
            told = np.sqrt((errors**2).mean(axis=0))[seen].mean()
            assert told == pytest.approx(spread[seen].mean(), rel=0.15)
            off = both[0].mean() / both[1].mean() - 1.0
            noise = np.hypot(*(each.mean(axis=(1, 2, 3)).std() / each.mean() for each in both))
            assert abs(off) < 4.0 * noise / np.sqrt(len(pairs))
