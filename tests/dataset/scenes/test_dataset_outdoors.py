"""Gardens, terraces and streets: their lights, and what the sun and the sky bring."""

import numpy as np
import pytest
from helpers.generated import appearance, lit, unlit

import photonmap as pm
from photonmap.dataset.report.diversity import nearest_neighbours
from photonmap.dataset.scenes.build import draw_illumination
from photonmap.dataset.scenes.exposure import LEVEL
from photonmap.dataset.scenes.illumination import CLEAR_SKY, Illumination, clear_sky, is_sky
from photonmap.dataset.scenes.outdoors import OUTDOORS
from photonmap.dataset.scenes.random_lights import MOST_LIGHTS
from photonmap.errors import InputError
from photonmap.scene.daylight import OvercastLight, SkyLight, SunLight
from photonmap.spectra.observer import luminance

each_place = pytest.mark.parametrize("name", OUTDOORS)


@each_place
def test_a_clear_sky_has_its_sun(name):
    """Both of one haze and hour, and at one factor of the model's watts."""
    chosen = draw_illumination(name, 0, CLEAR_SKY)
    sky, sun = unlit(name).lit(chosen).lights
    assert isinstance(sky, SkyLight)
    assert isinstance(sun, SunLight)
    named = clear_sky(chosen.colors[0])
    for light in (sky, sun):
        assert (light.turbidity, light.elevation) == (named.turbidity, named.elevation)
    assert (sky.azimuth, sky.scale) == (sun.azimuth, sun.scale)
    assert sky.scale > 0.0
    assert np.array(sun.direction)[2] < 0.26, "it shines onto the house, or past it"


@each_place
def test_other_skies_are_overcast_and_lamps_light_the_night(name):
    place = unlit(name)
    white = place.lit(Illumination("white", ("D65",)))
    assert [type(light) for light in white.lights] == [OvercastLight]
    night = place.lit(Illumination("night", ("HPS", "LED-B3")))
    assert not night.lights
    burning = {m.material.name for m in night.meshes if luminance(m.material.emission) > 0.0}
    assert burning == {"lamp", "lamp 2"}
    dusk = place.lit(Illumination("dusk", ("planck:2300", "daylight:12000")))
    assert [light.name for light in dusk.lights] == ["sky"]
    assert len(place.received) >= MOST_LIGHTS


def test_hours_and_haze_differ_between_seeds():
    drawn = [draw_illumination("garden", seed, CLEAR_SKY) for seed in range(12)]
    assert len({each.colors for each in drawn}) == 12
    assert drawn == [draw_illumination("garden", seed, CLEAR_SKY) for seed in range(12)]
    assert all(is_sky(each.colors[0]) for each in drawn)
    assert len({unlit("garden", seed).sky.azimuth for seed in range(2)}) == 2
    with pytest.raises(InputError, match="turbidity 1 is out of range; give 2 to 10"):
        unlit("terrace").lit(Illumination("clearest", ("sky:1,40",)))


@each_place
def test_the_sun_and_the_sky_are_measured_before_the_render(name):
    """By shadow rays: the mean irradiance of what the camera sees, and the median of these rays.

    Half may lie in the sun and half in shadow, so the median of the render is no measure.
    """
    chosen = draw_illumination(name, 0, CLEAR_SKY)
    scene = unlit(name).lit(chosen)
    expected = unlit(name).sky.received(chosen.colors[0]) * scene.lights[0].scale
    assert np.median(expected) == pytest.approx(LEVEL)
    result = pm.render(scene, bands=3, size=(32, 24), passes=2, per_light=True, method="path")
    assert result.record["light_groups"] == ["sky", "sun"]
    seen = result.coverage == 1.0
    assert seen.mean() > 0.4
    bands = result.direct[seen].sum(axis=-1) / result.reflectance[seen].sum(axis=-1)
    assert np.pi * bands.mean() == pytest.approx(expected.mean(), rel=0.3)
    shares = {group: result.per_light[group]["direct"].sum() for group in ("sky", "sun")}
    assert min(shares.values()) > 0.02 * sum(shares.values())


def test_rooms_show_a_clear_sky_in_their_windows():
    scene = lit("bedroom", 0, CLEAR_SKY)
    assert not any(luminance(mesh.material.emission) > 0.0 for mesh in scene.meshes)
    assert {mesh.name.split()[0] for mesh in scene.meshes if mesh.material.portal} == {"window"}
    (sky,) = scene.lights
    assert isinstance(sky, SkyLight)
    assert sky.group == "window"
    assert sky.color(450.0) > sky.color(650.0)


@pytest.mark.parametrize("light", ["D65", "sky:3,20"])
def test_light_through_windows_is_measured_before_the_render(light):
    """The mean direct irradiance of what the camera sees, by shadow rays and by the renderer."""
    room = unlit("bedroom")
    scene = room.lit(Illumination("day", (light,)))
    level = scene.lights[0].scale if light != "D65" else luminance(scene.lights[0].radiance)
    result = pm.render(scene, bands=3, size=(32, 24), passes=4, method="path")
    seen = (result.coverage == 1.0) & ~result.emission.any(axis=-1)
    found = np.pi * result.shading[seen].mean()
    assert level * room.sky.received(light).mean() == pytest.approx(found, rel=0.2)


def test_seeds_differ():
    maps = [appearance("garden", seed) for seed in range(2)]
    assert np.median(nearest_neighbours([each.depth for each in maps])) < 0.85
    assert np.median(nearest_neighbours([each.reflectance for each in maps])) < 0.75
