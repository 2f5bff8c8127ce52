"""Frosted glass and panes: which light is direct, records, buffers, and files.

That nothing is lost or counted twice: `test_even_sky` and `test_methods_agree`.
"""

from dataclasses import replace

import numpy as np
import pytest
from helpers.comparisons import assert_within
from helpers.passes import pass_means
from helpers.scenes import ball_room, quad

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.core.records import THIN
from photonmap.scene.surfaces.layers import name_kind
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
GLASS, PANE = pm.Material.glass(), pm.Material.pane()


@pytest.mark.parametrize(
    ("count", "roughness", "wanted"),
    [(1, 0.0, "emission"), (1, 0.3, "direct"), (2, 0.3, "indirect"), (2, 0.0, "emission")],
)
@pytest.mark.parametrize("look", [GLASS, PANE], ids=["glass", "pane"])
def test_the_first_rough_surface_makes_direct_light(look, count, roughness, wanted):
    """A lamp behind one sheet of frosted glass is direct light; behind two it is indirect."""
    lamp = quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0),
                pm.Material("lamp", 0.0, 1.0), "lamp")  # fmt: skip
    look = replace(look, roughness=roughness)
    panes = [
        quad((-9, -9, z), (9, -9, z), (9, 9, z), (-9, 9, z), look, f"pane {z}")
        for z in (0.5, 1.0)[:count]
    ]
    scene = pm.Scene([lamp, *panes], camera=pm.Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), fov=10.0))
    found = pm.render(scene, **SMALL, passes=4, photons=1000).buffers
    kinds = ("emission", "direct", "indirect")
    assert [kind for kind in kinds if found[kind].mean() > 1e-6] == [wanted]


def test_smooth_panes_are_the_limit():
    """The same light in all, of which the smooth pane lets some through unscattered."""
    rooms = (ball_room(*[replace(PANE, roughness=roughness)] * 4) for roughness in (0.0, 0.02))
    passes = (pass_means(room, "photon", 20) for room in rooms)
    smooth, rough = (each.sum(axis=1).mean(axis=(1, 2, 3)) for each in passes)
    error = np.hypot(smooth.std(ddof=1), rough.std(ddof=1)) / np.sqrt(20)
    assert error < 0.01 * smooth.mean()
    assert_within(rough.mean(), smooth.mean(), error)


def test_only_a_scene_that_calls_for_it_has_rough_chains():
    for smooth in (
        GLASS,
        replace(GLASS, roughness=0.5, ior=1.0),
        replace(PANE, roughness=0.5, ior=1.0),
    ):
        assert compile_scene(ball_room(smooth), RGB).specular.alpha.size == 0
    compiled = compile_scene(ball_room(replace(GLASS, roughness=0.5)), RGB)
    assert compiled.specular.alpha.max() == 0.25
    plan = plan_effects(compiled, "auto", 3, 3)
    assert plan.on("glossy")
    assert plan.on("transmission")


def test_the_record_of_a_frosted_pane():
    compiled = compile_scene(ball_room(replace(PANE, roughness=0.5)), RGB)
    assert THIN in compiled.specular.kind
    assert compiled.geometry.alpha is None
    assert compiled.is_thin.sum() == 1


def test_without_gloss_rough_glass_is_black():
    effects = [name for name in EFFECTS if name != "glossy"]
    rough, black = replace(GLASS, roughness=0.5), pm.Material("black", 0.0)
    found = pm.render(ball_room(rough), **SMALL, passes=2, effects=effects)
    wanted = pm.render(ball_room(black), **SMALL, passes=2)
    np.testing.assert_array_equal(found.radiance, wanted.radiance)


@pytest.mark.parametrize(("look", "reflectance"), [(GLASS, 0.04), (PANE, 0.08 / 1.04)])
def test_buffers_show_it(look, reflectance):
    names = ("roughness", "specular_reflectance", "metallic", "diffuse_fraction")
    room = ball_room(replace(look, roughness=0.6))
    result = pm.render(room, **SMALL, passes=1, buffers=names)
    glass = np.isclose(result["roughness"], 0.6)
    assert glass.any()
    assert np.isclose(result["roughness"][~glass], 1.0).all()
    np.testing.assert_allclose(result["specular_reflectance"][glass], reflectance, rtol=1e-6)
    assert not result["metallic"][glass].any()
    assert not result["diffuse_fraction"][glass].any()


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_it(suffix, tmp_path):
    looks = [replace(look, ior=1.4, roughness=0.35) for look in (GLASS, PANE)]
    pm.save_scene(ball_room(*looks), tmp_path / f"scene{suffix}")
    meshes = pm.load_scene(tmp_path / f"scene{suffix}").meshes
    found = [mesh.material for mesh in meshes if mesh.material.ior is not None]
    assert [(each.ior, each.roughness, each.thin) for each in found] == [
        (1.4, 0.35, False),
        (1.4, 0.35, True),
    ]
    assert [name_kind(each) for each in found] == ["rough glass", "rough thin glass"]


def test_new_glass_in_toml_is_smooth_unless_it_says_so(tmp_path):
    pm.save_scene(ball_room(pm.Material.metal("ball", roughness=0.5)), tmp_path / "scene.obj")
    for lines, roughness in (("", 0.0), ("roughness = 0.25\n", 0.25)):
        text = f"mesh = 'scene.obj'\n[material.ball]\nior = 1.5\n{lines}"
        (tmp_path / "scene.toml").write_text(text)
        glass = pm.load_scene(tmp_path / "scene.toml").meshes[-1].material
        assert (glass.ior, glass.roughness) == (1.5, roughness)


def test_mtl_gives_glass_its_roughness(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl glass\nillum 4\nNi 1.5\nPr 0.3\n")
    lines = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n"
    (tmp_path / "a.obj").write_text(lines)
    assert pm.load_scene(tmp_path / "a.obj").meshes[0].material.roughness == 0.3
