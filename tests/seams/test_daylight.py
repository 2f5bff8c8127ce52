"""Daylight in renders: what reaches level ground, where the sun is, and how soft shadows are."""

import numpy as np
import pytest
from helpers.scenes import quad

import photonmap as pm
from photonmap.spectra.daylight import SUN_DIAMETER, ClearSky

BANDS = 5
GROUND = pm.Material("ground", 0.0)
DOWN = pm.Camera((0.0, 1.0, 0.001), (0.0, 0.0, 0.0), fov=10.0)


def ground(half=10.0):
    corners = [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]
    return quad(*corners, GROUND, "ground")


def irradiance(lights, meshes=(), camera=DOWN, **settings):
    """Return the direct irradiance of the ground by pixel and band, and its standard error."""
    scene = pm.Scene([ground(), *meshes], lights, camera)
    settings = {"bands": BANDS, "size": (16, 16), "passes": 16, **settings}
    result = pm.render(scene, **settings)
    return np.pi * result.shading, np.pi * result.standard_error("shading")


@pytest.mark.parametrize(("turbidity", "elevation"), [(2.5, 25.0), (5.0, 65.0)])
def test_level_ground_gets_the_light_of_the_model(turbidity, elevation):
    model, bands = ClearSky(turbidity, elevation), pm.Bands.parse(str(BANDS))
    found, error = irradiance([pm.SkyLight(turbidity, elevation, 130.0)])
    wanted = bands.average(model.skylight())
    spread = np.sqrt((error**2).sum(axis=(0, 1))) / error[..., 0].size
    assert (np.abs(found.mean(axis=(0, 1)) - wanted) < 5.0 * spread + 2e-3 * wanted).all()
    found, _ = irradiance([pm.SunLight(turbidity, elevation, 130.0)])
    wanted = bands.average(model.sun()) * np.sin(np.radians(elevation))
    np.testing.assert_allclose(found.mean(axis=(0, 1)), wanted, rtol=1e-4)


def test_in_rgb_a_sky_keeps_its_colours():
    """RGB of the light, and bands of it projected to RGB, within what few bands leave."""
    found, _ = irradiance([pm.SkyLight(3.0, 40.0)], bands="rgb")
    wanted = np.pi * np.asarray(pm.Bands.rgb().emission(pm.SkyLight(3.0, 40.0).color))
    np.testing.assert_allclose(found.mean(axis=(0, 1)), wanted, rtol=0.02)


@pytest.mark.parametrize(
    ("azimuth", "towards"), [(0.0, (0, 0, -1)), (90.0, (1, 0, 0)), (200.0, None)]
)
def test_the_sun_stands_where_it_is_asked_for(azimuth, towards):
    sun, sky = (kind(3.0, 30.0, azimuth) for kind in (pm.SunLight, pm.SkyLight))
    back = -np.array(sun.direction)
    assert back[1] == pytest.approx(0.5)
    if towards:
        wanted = np.cos(np.pi / 6) * np.array(towards) + (0, 0.5, 0)
        np.testing.assert_allclose(back, wanted, atol=1e-12)
    brightest = np.unravel_index(np.argmax(sky.luminance()), (256, 512))
    polar, turn = ((np.array(brightest) + 0.5) * np.pi / 256).tolist()
    x, z = np.sin(polar) * np.sin(turn - np.pi), -np.sin(polar) * np.cos(turn - np.pi)
    # Haze shifts the brightest place a little towards the horizon.
    assert np.dot(back, (x, np.cos(polar), z)) > np.cos(np.radians(8.0))


def test_the_edge_of_a_shadow_is_that_of_a_disc():
    """An edge covers a segment of the disc: its area is a closed form; straight from above."""
    angle, tall = 8.0, 1.0
    sun = pm.DirectionalLight((0.0, -1.0, 0.0), 2.0, angle=angle)
    roof = quad((0, tall, 5), (5, tall, 5), (5, tall, -5), (0, tall, -5), GROUND, "roof")
    camera = pm.Camera((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov=16.0)
    found, error = irradiance([sun], [roof], camera, bands=1, size=(33, 33), pixel="center")
    radius = tall * np.tan(np.radians(0.5 * angle))
    at = np.tan(np.radians(8.0)) * 0.9 * (2.0 * (np.arange(33) + 0.5) / 33 - 1.0)
    reach = np.clip(at / radius, -1.0, 1.0)
    hidden = 0.5 + (np.arcsin(reach) + reach * np.sqrt(1.0 - reach**2)) / np.pi
    wanted = 2.0 * (1.0 - hidden)
    row, spread = found[..., 0].mean(axis=0), np.sqrt((error[..., 0] ** 2).mean(axis=0) / 33)
    assert (np.abs(row - wanted) < 5.0 * spread + 4e-3).all()
    assert spread[16] > 0.0
    sharp, _ = irradiance([pm.DirectionalLight((0, -1, 0), 2.0)], [roof], camera, bands=1, passes=2)
    assert set(np.unique(sharp.round(4))) <= {0.0, 2.0}


def test_the_sun_is_as_large_as_the_sun():
    edge = pm.SunLight().emitter().parameters["edge"]
    assert np.degrees(2.0 * np.arccos(edge)) == pytest.approx(SUN_DIAMETER, rel=1e-6)


def test_files_have_skies_and_suns(tmp_path):
    scene = pm.Scene(
        [ground()], [pm.SkyLight(2.5, 30.0, 45.0), pm.SunLight(2.5, 30.0, 45.0, 0.5)], DOWN
    )
    pm.save_scene(scene, tmp_path / "yard.obj")
    lights = pm.load_scene(tmp_path / "yard.obj").lights
    assert [type(light) for light in lights] == [pm.SkyLight, pm.SunLight]
    assert lights[0].turbidity == 2.5
    assert lights[1].scale == 0.5
    (tmp_path / "yard.toml").write_text(
        (tmp_path / "yard.toml").read_text().replace("elevation = 30", "elevation = 2", 1)
    )
    with pytest.raises(
        pm.InputError, match=r"yard\.toml:\d+: .*elevation; give degrees from 5 to 90"
    ):
        pm.load_scene(tmp_path / "yard.obj")
