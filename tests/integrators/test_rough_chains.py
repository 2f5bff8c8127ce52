"""Rough glass and narrow metal in scenes: nothing is lost or counted twice by either method."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_invisible
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.inspection.surfaces import name_kind
from photonmap.kernels.core.records import METAL
from photonmap.scene import material as materials
from photonmap.spectra.bands import Bands

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*successive reflections"),
    pytest.mark.filterwarnings("ignore:.*photons were truncated"),
]
"""Nearly smooth facets keep some light in a ball for long."""

RGB = Bands.rgb()
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
CAMERA = pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0)
SEEDS = 8
"""Independent renders, of which the spread gives standard errors."""
SIGMAS = 3.0
"""Standard errors that may separate two means."""
ROUGHNESS = [np.sqrt(alpha) for alpha in (0.01, 0.05, 0.2, 0.5, 1.0)]


def ball(material, radius=0.4, subdivisions=3):
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return pm.Mesh(sphere.vertices + [0.0, -0.3, -0.2], sphere.faces, material, "ball")


def frosted(roughness, **values):
    return pm.Material.glass(roughness=float(roughness), **values)


def room(material, *lights, lamp=True):
    """A closed box with a lamp and a ball in it."""
    glow = pm.Material("lamp", 0.0, 20.0)
    corners = (-0.4, 0.9, -0.4), (0.4, 0.9, -0.4), (0.4, 0.9, 0.4), (-0.4, 0.9, 0.4)
    lamps = [quad(*corners, glow, "lamp")] if lamp else []
    return pm.Scene([closed_box(GREY), *lamps, ball(material)], list(lights), camera=CAMERA)


def means(scene, name="radiance", seeds=SEEDS, **settings):
    """Return the means of a buffer over all pixels, one of each seed."""
    results = (pm.render(scene, **SMALL, **settings, seed=seed) for seed in range(seeds))
    return np.array([result.buffers[name].mean(dtype=float) for result in results])


def difference(scene, name="radiance", photon=16, path=190, seeds=SEEDS):
    """Return the difference of the two methods' means, its standard error, and the mean.

    The error is that over seeds: pixels share photons and point sets, so that of their mean is up
    to 2.4 times what their own errors add up to.
    """
    a = means(scene, name, seeds, passes=photon)
    b = means(scene, name, seeds, passes=path, method="path")
    return a.mean() - b.mean(), standard_error(a, b), b.mean()


def standard_error(*samples):
    """Return the standard error of a difference of means."""
    return np.sqrt(sum(sample.var(ddof=1) / len(sample) for sample in samples))


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_photons_and_paths_agree(roughness):
    found, error, value = difference(room(frosted(roughness, tint=(0.9, 0.8, 0.7))))
    assert error < 0.01 * value
    assert abs(found) < SIGMAS * error


@pytest.mark.parametrize("roughness", [0.4, 0.8])
def test_a_bulb_is_seen_through_rough_glass(roughness):
    """No walk ever meets it: all of its direct light, and its caustics, are light samples'."""
    scene = room(frosted(roughness), pm.PointLight((0.5, 0.5, 0.5), 1.0), lamp=False)
    direct, error, value = difference(scene, "direct", seeds=2 * SEEDS)  # the spread itself varies
    assert value > 0.0
    assert abs(direct) < SIGMAS * error
    found, error, value = difference(scene)
    assert error < 0.01 * value
    assert abs(found) < SIGMAS * error


@pytest.mark.parametrize("roughness", np.sqrt([0.01, 0.05, 0.09]).tolist())
def test_metal_is_the_same_by_both_methods_and_as_a_glossy_surface(roughness, monkeypatch):
    metal = pm.Material.metal(glossy=(0.95, 0.8, 0.5), roughness=roughness)
    scene = room(metal, pm.PointLight((0.5, 0.5, 0.5), 0.3))
    assert METAL in compile_scene(scene, RGB).specular.kind
    found, error, value = difference(scene)
    assert error < 0.01 * value
    assert abs(found) < SIGMAS * error
    narrow = means(scene, passes=190, method="path")
    monkeypatch.setattr(materials, "NARROW_ALPHA", 0.0)
    assert compile_scene(scene, RGB).specular is None
    glossy = means(scene, passes=190, method="path")
    assert abs(glossy.mean() - narrow.mean()) < SIGMAS * standard_error(glossy, narrow)


def test_a_textured_or_painted_metal_stays_glossy():
    for reflectance in (0.1, pm.Texture.of(np.full((1, 1), 0.4))):
        painted = pm.Material("paint", reflectance, glossy=0.5, roughness=0.1)
        assert not painted.is_narrow_metal
    assert pm.Material.metal(roughness=0.31).is_narrow_metal
    assert not pm.Material.metal(roughness=0.32).is_narrow_metal


GLASSES = [frosted(r, ior=ior) for r in (0.05, 0.3, 0.7, 1.0) for ior in (1.1, 1.5, 2.5)]
METALS = [pm.Material.metal(glossy=1.0, roughness=r) for r in (0.05, 0.3)]


@pytest.mark.parametrize(
    "material", GLASSES + METALS, ids=lambda m: f"{m.name}-{m.ior}-{m.roughness}"
)
def test_a_ball_vanishes_in_an_even_sky(material):
    """Light samples and walks add up to all of the sky, inside and out."""
    camera = pm.Camera((0.0, -0.3, 3.0), (0.0, -0.3, 0.0), fov=12.0)
    scene = pm.Scene([ball(material)], [pm.DomeLight(0.7)], camera)
    result = pm.render(scene, **SMALL, passes=32)
    assert assert_invisible(result, 0.7) < 0.01


def test_the_first_rough_surface_makes_direct_light():
    """A lamp behind one sheet of frosted glass is direct light; behind two it is indirect."""

    def sheets(count, roughness):
        lamp = quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0),
                    pm.Material("lamp", 0.0, 1.0), "lamp")  # fmt: skip
        panes = [
            quad((-9, -9, z), (9, -9, z), (9, 9, z), (-9, 9, z), frosted(roughness), f"pane {z}")
            for z in (0.5, 1.0)[:count]
        ]
        camera = pm.Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), fov=10.0)
        scene = pm.Scene([lamp, *panes], camera=camera)
        return pm.render(scene, **SMALL, passes=4).buffers

    kinds = ("emission", "direct", "indirect")
    for (count, roughness), there in {(1, 0.0): 0, (1, 0.3): 1, (2, 0.3): 2, (2, 0.0): 0}.items():
        light = [sheets(count, roughness)[kind].mean() for kind in kinds]
        assert [value > 1e-6 for value in light] == [kind == there for kind in range(3)]


def test_only_a_scene_that_calls_for_it_has_rough_chains():
    assert compile_scene(room(pm.Material.glass()), RGB).specular.alpha.size == 0
    assert compile_scene(room(frosted(0.5, ior=1.0)), RGB).specular.alpha.size == 0
    compiled = compile_scene(room(frosted(0.5)), RGB)
    assert compiled.specular.alpha.max() == 0.25
    plan = plan_effects(compiled, "auto", 3, 3)
    assert plan.on("glossy")
    assert plan.on("transmission")


def test_without_gloss_rough_glass_is_black():
    effects = [name for name in EFFECTS if name != "glossy"]
    found = pm.render(room(frosted(0.5)), **SMALL, passes=2, effects=effects)
    black = pm.render(room(pm.Material("black", 0.0)), **SMALL, passes=2)
    np.testing.assert_array_equal(found.radiance, black.radiance)


def test_the_buffer_of_roughness_shows_it():
    scene = room(frosted(0.6))
    result = pm.render(scene, **SMALL, passes=1, buffers=("roughness", "specular_reflectance"))
    found = result.buffers["roughness"]
    glass = np.isclose(found, 0.6)
    assert glass.any()
    assert np.isclose(found[~glass], 1.0).all()
    np.testing.assert_allclose(result.buffers["specular_reflectance"][glass], 0.04, rtol=1e-6)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_rough_glass(suffix, tmp_path):
    path = tmp_path / f"scene{suffix}"
    pm.save_scene(room(frosted(0.35, ior=1.4)), path)
    found = [m.material for m in pm.load_scene(path).meshes if m.material.ior is not None]
    assert [(glass.ior, glass.roughness) for glass in found] == [(1.4, 0.35)]
    assert name_kind(found[0]) == "rough glass"


def test_new_glass_in_toml_is_smooth_unless_it_says_so(tmp_path):
    pm.save_scene(room(pm.Material.metal("ball", roughness=0.5)), tmp_path / "scene.obj")
    for lines, roughness in (("", 0.0), ("roughness = 0.25\n", 0.25)):
        text = f"mesh = 'scene.obj'\n[material.ball]\nior = 1.5\n{lines}"
        (tmp_path / "scene.toml").write_text(text)
        scene = pm.load_scene(tmp_path / "scene.toml")
        glass = next(m.material for m in scene.meshes if m.name == "ball")
        assert (glass.ior, glass.roughness) == (1.5, roughness)


def test_mtl_gives_glass_its_roughness(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl glass\nillum 4\nNi 1.5\nPr 0.3\n")
    lines = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n"
    (tmp_path / "a.obj").write_text(lines)
    assert pm.load_scene(tmp_path / "a.obj").meshes[0].material.roughness == 0.3
