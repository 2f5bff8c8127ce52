"""Glossy surfaces: which effects they call for, buffers, files and bad input."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.scenes import ball_room, closed_box

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()

SMALL = {"bands": 3, "size": (12, 12), "threads": 2}


def test_bands_that_a_lobe_tells_apart_are_not_merged():
    grey = ball_room(pm.Material.metal(glossy=0.5))
    gold = ball_room(pm.Material.metal(glossy=(0.95, 0.8, 0.5)))
    one, three = (pm.render(scene, **SMALL, passes=2) for scene in (grey, gold))
    assert one.record["effects"]["band_merging"]["on"]
    assert not three.record["effects"]["band_merging"]["on"]


def test_only_a_scene_that_calls_for_it_has_scattering():
    assert compile_scene(ball_room(), RGB).scattering is None
    plan = plan_effects(compile_scene(ball_room(pm.Material.metal()), RGB), "auto", 3, 3)
    assert plan.on("glossy")
    assert not plan.on("non_lambertian")
    plaster = pm.Material("plaster", diffuse_roughness=0.5)
    plan = plan_effects(compile_scene(ball_room(plaster), RGB), "auto", 3, 3)
    assert plan.on("non_lambertian")
    assert not plan.on("glossy")


def test_without_gloss_the_base_is_left():
    effects = [name for name in EFFECTS if name != "glossy"]
    bare = pm.render(ball_room(pm.Material.plastic()), **SMALL, passes=2, effects=effects)
    diffuse = pm.render(ball_room(pm.Material()), **SMALL, passes=2)
    np.testing.assert_array_equal(bare.radiance, diffuse.radiance)
    assert bare.record["partial"]


def test_a_scene_of_metal_alone_has_indirect_light():
    metal = pm.Material.metal(glossy=0.8, roughness=0.6)
    scene = pm.Scene([closed_box(metal)], [pm.PointLight((0.0, 0.0, 0.0), 1.0)])
    assert plan_effects(compile_scene(scene, RGB), "auto", 3, 3).on("indirect")


@pytest.mark.parametrize(
    "other",
    [{"ior": 1.5, "transmission": 0.5, "coat": 0.5}, {"mirror": 0.2}, {"diffuse_roughness": 0.5}],
)
def test_lobes_that_do_not_go_together_are_refused(other):
    material = replace(pm.Material.plastic("cup"), **other)
    with pytest.raises(InputError, match=r"material 'cup': \w+ does not go with \w+: .*; "):
        compile_scene(ball_room(material), RGB)


def test_roughness_out_of_range_is_refused():
    with pytest.raises(InputError, match=r"roughness: 1\.5 is not a roughness"):
        compile_scene(ball_room(pm.Material.metal(roughness=1.5)), RGB)


def test_files_keep_gloss(tmp_path):
    path = tmp_path / "scene.obj"
    pm.save_scene(ball_room(pm.Material.metal("gold", (0.95, 0.8, 0.5), 0.25)), path)
    found = [m.material for m in pm.load_scene(path).meshes if m.name == "ball 0"]
    assert found[0].glossy == (0.95, 0.8, 0.5)
    assert found[0].roughness == 0.25


def test_specular_reflectance_is_the_lobe_at_normal_incidence():
    scene = ball_room(pm.Material.metal(glossy=(0.95, 0.8, 0.5)))
    result = pm.render(
        scene, bands="rgb", size=(24, 24), passes=1, buffers=("specular_reflectance",)
    )
    found = result.buffers["specular_reflectance"].reshape(-1, 3)
    expected = np.array([0.95, 0.8, 0.5], np.float32)
    assert (np.isclose(found, expected).all(axis=1) | (found == 0.0).all(axis=1)).all()
    assert np.isclose(found, expected).all(axis=1).any()
