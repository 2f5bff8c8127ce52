"""Frosted panes: nothing is lost, both methods agree, and smooth ones are the limit."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_invisible
from helpers.scenes import GREY, closed_box, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.inspection.surfaces import name_kind
from photonmap.kernels.core.records import THIN
from photonmap.spectra.bands import Bands

pytestmark = pytest.mark.filterwarnings("ignore:.*successive reflections")
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
CAMERA = pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0)
SEEDS = 8
SIGMAS = stats.t.isf(5e-4, 2 * SEEDS - 2)
"""Standard errors, themselves estimated from so few seeds, that may separate two means."""


def pane(roughness, **values):
    return pm.Material.pane(roughness=roughness, **values)


def bubble(material):
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.4)
    return pm.Mesh(sphere.vertices + [0.0, -0.3, -0.2], sphere.faces, material, "bubble")


def room(material, lamp=True):
    """A closed box with a lamp, or a bulb, and a bubble in it."""
    corners = (-0.4, 0.9, -0.4), (0.4, 0.9, -0.4), (0.4, 0.9, 0.4), (-0.4, 0.9, 0.4)
    lamps = [quad(*corners, pm.Material("lamp", 0.0, 20.0), "lamp")] if lamp else []
    bulbs = [] if lamp else [pm.PointLight((0.5, 0.5, 0.5), 1.0)]
    return pm.Scene([closed_box(GREY), *lamps, bubble(material)], bulbs, camera=CAMERA)


def means(scene, **settings):
    """Return the means of the radiance over all pixels, one of each seed."""
    results = (pm.render(scene, **SMALL, **settings, seed=seed) for seed in range(SEEDS))
    return np.array([result.radiance.mean(dtype=float) for result in results])


@pytest.mark.parametrize(
    ("roughness", "lamp"), [(0.1, True), (0.4, True), (0.9, True), (0.4, False), (0.9, False)]
)
def test_photons_and_paths_agree(roughness, lamp):
    scene = room(pane(roughness, tint=(0.9, 0.8, 0.7)), lamp)
    photon, path = means(scene, passes=16), means(scene, passes=190, method="path")
    error = np.sqrt(sum(each.var(ddof=1) / SEEDS for each in (photon, path)))
    assert error < 0.01 * path.mean()
    assert abs(photon.mean() - path.mean()) < SIGMAS * error


@pytest.mark.parametrize("ior", [1.1, 2.5])
@pytest.mark.parametrize("roughness", [0.05, 0.4, 1.0])
def test_a_bubble_vanishes_in_an_even_sky(roughness, ior):
    camera = pm.Camera((0.0, -0.3, 3.0), (0.0, -0.3, 0.0), fov=12.0)
    scene = pm.Scene([bubble(pane(roughness, ior=ior))], [pm.DomeLight(0.7)], camera)
    result = pm.render(scene, **SMALL, passes=32)
    assert assert_invisible(result, 0.7) < 0.01


def test_smooth_panes_are_the_limit():
    """The same light in all, of which the smooth pane lets some through unscattered."""
    smooth, rough = (means(room(pane(r)), passes=24) for r in (0.0, 0.02))
    error = np.sqrt(sum(each.var(ddof=1) / SEEDS for each in (smooth, rough)))
    assert error < 0.01 * smooth.mean()
    assert abs(smooth.mean() - rough.mean()) < SIGMAS * error


def test_a_lamp_behind_a_frosted_pane_is_direct_light():
    lamp = quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0),
                pm.Material("lamp", 0.0, 1.0), "lamp")  # fmt: skip
    window = quad((-9, -9, 1), (9, -9, 1), (9, 9, 1), (-9, 9, 1), pane(0.3), "window")
    camera = pm.Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), fov=10.0)
    result = pm.render(pm.Scene([lamp, window], camera=camera), **SMALL, passes=4)
    assert result.direct.mean() > 0.5
    assert not result.emission.any()
    assert not result.indirect.any()


def test_the_record_of_a_frosted_pane():
    compiled = compile_scene(room(pane(0.5)), Bands.rgb())
    assert THIN in compiled.specular.kind
    assert compiled.geometry.alpha is None
    assert compiled.is_thin.sum() == 1
    as_air = compile_scene(room(pane(0.5, ior=1.0)), Bands.rgb())
    assert as_air.specular.alpha.size == 0
    buffers = ["roughness", "specular_reflectance", "metallic", "diffuse_fraction"]
    result = pm.render(room(pane(0.6)), **SMALL, passes=1, buffers=buffers)
    glass = np.isclose(result["roughness"], 0.6)
    assert glass.any()
    np.testing.assert_allclose(result["specular_reflectance"][glass], 0.08 / 1.04, rtol=1e-6)
    assert not result["metallic"][glass].any()
    assert not result["diffuse_fraction"][glass].any()


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_frosted_panes(suffix, tmp_path):
    path = tmp_path / f"scene{suffix}"
    pm.save_scene(room(pane(0.35, ior=1.4)), path)
    found = next(m.material for m in pm.load_scene(path).meshes if m.material.ior is not None)
    assert (found.ior, found.roughness, found.thin) == (1.4, 0.35, True)
    assert name_kind(found) == "rough thin glass"
