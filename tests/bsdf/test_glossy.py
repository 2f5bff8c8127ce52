"""Glossy surfaces: the white furnace at every roughness, both methods, files and bad input."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from bsdf_harness import Case, furnace
from helpers.comparisons import assert_invisible
from helpers.scenes import GREY, closed_box, quad
from test_rough_renders import block_means, excess

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()

SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
CAMERA = pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0)


def ball(material):
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    vertices = sphere.vertices + np.array([0.0, -0.4, -0.3])
    return pm.Mesh(vertices, sphere.faces, material, "ball", sphere.vertices / 0.5)


def room(*meshes):
    lamp = quad((0.5, 0.5, 0.9), (0.5, 0.9, 0.9), (0.9, 0.9, 0.9), (0.9, 0.5, 0.9),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    return pm.Scene([closed_box(GREY), lamp, *meshes], camera=CAMERA)


@pytest.mark.parametrize("cosine", [1.0, 0.6, 0.2, 0.05])
@pytest.mark.parametrize("alpha", [1e-3, 0.01, 0.05, 0.2, 0.5, 1.0])
@pytest.mark.parametrize(
    ("f0", "index"), [(0.0, 0.0), (0.2, 0.0), (1.0, 0.0), (0.04, 1.5), (0.25, 3.0)]
)
def test_white_furnace(alpha, cosine, f0, index):
    """A white base below any lobe, and a lobe that is white itself, reflect all light."""
    case = Case("glossy", (alpha,), (1.0,) * 3, (f0,) * 3, index=index)
    mean, error = furnace(case, cosine)
    assert abs(mean - 1.0) < 0.005 + 4.0 * error


GOLD = (0.95, 0.8, 0.5)
SWEEP = [pm.Material.metal("metal", GOLD, roughness) for roughness in (0.35, 0.5, 0.7, 1.0)]
SWEEP += [
    pm.Material.plastic("plastic", 0.6, 1.5, roughness) for roughness in (0.0, 0.1, 0.4, 0.7, 1.0)
]
"""Narrower metal is followed by chains: see `test_rough_chains`."""


@pytest.mark.parametrize("material", SWEEP, ids=lambda m: f"{m.name}-{m.roughness}")
def test_photons_and_paths_agree(material):
    scene = room(ball(material))
    assert excess(block_means(scene, "photon"), block_means(scene, "path")) <= 0.0


def test_a_white_ball_vanishes_in_an_even_sky():
    """What is not lost is the sky's radiance everywhere, direct light and residual together."""
    white = pm.Material.plastic(reflectance=1.0, roughness=0.5)
    camera = pm.Camera((0.0, -0.4, 3.0), (0.0, -0.4, 0.0), fov=18.0)
    scene = pm.Scene([ball(white)], [pm.DomeLight(0.7)], camera)
    result = pm.render(scene, **SMALL, passes=32)
    assert_invisible(result, 0.7)


def test_bands_that_a_lobe_tells_apart_are_not_merged():
    grey = room(ball(pm.Material.metal(glossy=0.5)))
    gold = room(ball(pm.Material.metal(glossy=(0.95, 0.8, 0.5))))
    one, three = (pm.render(scene, **SMALL, passes=2) for scene in (grey, gold))
    assert one.record["effects"]["band_merging"]["on"]
    assert not three.record["effects"]["band_merging"]["on"]


def test_only_a_scene_that_calls_for_it_has_scattering():
    assert compile_scene(room(), RGB).scattering is None
    plan = plan_effects(compile_scene(room(ball(pm.Material.metal())), RGB), "auto", 3, 3)
    assert plan.on("glossy")
    assert not plan.on("non_lambertian")
    plaster = pm.Material("plaster", diffuse_roughness=0.5)
    plan = plan_effects(compile_scene(room(ball(plaster)), RGB), "auto", 3, 3)
    assert plan.on("non_lambertian")
    assert not plan.on("glossy")


def test_without_gloss_the_base_is_left():
    effects = [name for name in EFFECTS if name != "glossy"]
    bare = pm.render(room(ball(pm.Material.plastic())), **SMALL, passes=2, effects=effects)
    diffuse = pm.render(room(ball(pm.Material())), **SMALL, passes=2)
    np.testing.assert_array_equal(bare.radiance, diffuse.radiance)
    assert bare.record["partial"]


def test_a_scene_of_metal_alone_has_indirect_light():
    metal = pm.Material.metal(glossy=0.8, roughness=0.6)
    scene = pm.Scene([closed_box(metal)], [pm.PointLight((0.0, 0.0, 0.0), 1.0)], CAMERA)
    assert plan_effects(compile_scene(scene, RGB), "auto", 3, 3).on("indirect")


@pytest.mark.parametrize(
    "other",
    [{"ior": 1.5, "transmission": 0.5, "coat": 0.5}, {"mirror": 0.2}, {"diffuse_roughness": 0.5}],
)
def test_lobes_that_do_not_go_together_are_refused(other):
    material = replace(pm.Material.plastic("cup"), **other)
    with pytest.raises(InputError, match=r"material 'cup': \w+ does not go with \w+: .*; "):
        compile_scene(room(ball(material)), RGB)


def test_roughness_out_of_range_is_refused():
    with pytest.raises(InputError, match=r"roughness: 1\.5 is not a roughness"):
        compile_scene(room(ball(pm.Material.metal(roughness=1.5))), RGB)


def test_files_keep_gloss(tmp_path):
    path = tmp_path / "scene.obj"
    pm.save_scene(room(ball(pm.Material.metal("gold", (0.95, 0.8, 0.5), 0.25))), path)
    found = [m.material for m in pm.load_scene(path).meshes if m.name == "ball"]
    assert found[0].glossy == (0.95, 0.8, 0.5)
    assert found[0].roughness == 0.25


def test_specular_reflectance_is_the_lobe_at_normal_incidence():
    scene = room(ball(pm.Material.metal(glossy=(0.95, 0.8, 0.5))))
    result = pm.render(
        scene, bands="rgb", size=(24, 24), passes=1, buffers=("specular_reflectance",)
    )
    found = result.buffers["specular_reflectance"].reshape(-1, 3)
    expected = np.array([0.95, 0.8, 0.5], np.float32)
    assert (np.isclose(found, expected).all(axis=1) | (found == 0.0).all(axis=1)).all()
    assert np.isclose(found, expected).all(axis=1).any()
