"""Data sets of fluorescent materials: what fluoresces, the buffer in files, and what is checked."""

from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.files.derived_buffers import as_rgb, with_derived
from photonmap.dataset.files.image_files import SHOWN, previews
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import load_preset, with_illuminations
from photonmap.dataset.jobs.verify import check_identities
from photonmap.dataset.models.materials import FLUORESCENT, Palette, surface_of
from photonmap.dataset.scenes.build import build_scene
from photonmap.dataset.scenes.illumination import Illumination, light_spectrum

pytestmark = pytest.mark.filterwarnings("ignore:fluorescence is excited")


def palette(materials):
    return Palette(np.random.Generator(np.random.PCG64(3)), materials)


def test_white_textiles_and_half_of_the_saturated_chips_fluoresce():
    plain, glowing = palette("lambertian"), palette("fluorescent")
    assert glowing.grey(9).fluorescence is not None
    assert glowing.grey(6).fluorescence is None
    names = [(plain.fabric().name, glowing.fabric()) for _ in range(5)]
    assert all(FLUORESCENT + name == cloth.name for name, cloth in names)
    accents = [(plain.accent().name, glowing.accent()) for _ in range(40)]
    assert all(name in chip.name for name, chip in accents)  # the same chips are drawn
    assert 8 < sum(chip.fluorescence is not None for _, chip in accents) < 32
    assert surface_of(glowing.grey(9).name).lighter(-2.0).material().fluorescence is not None


def test_drawn_lights_are_known_in_all_bands():
    """Lamps were measured from 380 nm on; named illuminations draw others in ultraviolet bands."""
    common = CommonSettings((8, 8), "300:780:20", "0.1", materials="fluorescent")
    drawn = ["colored", "two_mixed", "random_3"]
    preset = with_illuminations(load_preset("small"), drawn)
    for job in plan_jobs(preset, [], common):
        for color in job.colors:
            assert light_spectrum(color).wavelengths[0] <= 300.0
    preset = replace(preset, illuminations=(Illumination("mine", ("HPS",)),))
    with pytest.raises(pm.InputError, match="'mine', light 'HPS': the curve covers 380-780 nm, bu"):
        plan_jobs(preset, [], common)


@pytest.mark.parametrize("light", ["white", "black_light", "led_405"])
def test_the_parts_of_an_image_add_up_under_lights_with_ultraviolet(light):
    scene = build_scene("tower", 1, light, "fluorescent")
    assert any(mesh.material.fluorescence for mesh in scene.meshes)
    result = pm.render(scene, bands="300:780:20", size=(24, 18), passes=2)
    whole = with_derived(result, scene)
    assert result.fluorescence.max() > 0.0
    assert not list(check_identities(whole))
    rgb = as_rgb(whole)
    parts = rgb.emission + rgb.reflectance * rgb.shading + rgb.buffers["fluorescence"]
    np.testing.assert_allclose(rgb.radiance, parts + rgb.residual, atol=1e-6)
    assert previews(whole, rgb, SHOWN)["fluorescence"].shape == (18, 24, 3)
    if light == "black_light":  # all that is visible was excited; the lamp itself is at 368 nm
        seen = np.abs(result.bands.centroids - 550.0) < 100.0
        close = [result.radiance[..., seen].sum(), result.fluorescence[..., seen].sum()]
        assert close[1] > 0.3 * close[0]
