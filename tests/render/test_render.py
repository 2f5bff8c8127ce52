"""What a user may rely on: identities, determinism, budgets, honest errors, clear refusals."""

import os
import signal
import threading
from dataclasses import replace

import numpy as np
import pytest
from helpers.marks import slow
from helpers.scenes import CAMERA, GREY, closed_box, quad

import photonmap as pm
from photonmap.buffers import DEFAULT
from photonmap.film.budget import LEAST_PASSES
from photonmap.runtime.progress import Silent
from photonmap.spectra.fluorophores import named

ARRAYS = DEFAULT


def assert_same(one, other):
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for name in one.errors:
        np.testing.assert_array_equal(one.errors[name], other.errors[name], err_msg=name)


@pytest.mark.parametrize(("pixel", "bands"), [("box", "rgb"), ("center", 1), ("box", 6)])
def test_identities(cornell, pixel, bands):
    result = pm.render(cornell, bands=bands, size=(32, 32), passes=3, pixel=pixel)
    total = (result.emission + result.direct) + result.indirect
    np.testing.assert_array_equal(result.radiance, total)
    product = result.reflectance * result.shading
    diffuse = result.direct + result.indirect
    np.testing.assert_array_less(np.abs(product - diffuse), 4 * np.spacing(diffuse) + 1e-30)
    assert (result.residual == 0.0).all()
    for name in ("radiance", "emission", "direct", "indirect", "reflectance", "shading"):
        image, error = getattr(result, name), result.standard_error(name)
        assert image.dtype == error.dtype == np.float32
        assert image.shape == error.shape == (32, 32, result.bands.count)
        assert (image >= 0).all()
        assert (error >= 0).all()
        assert np.isfinite(image).all()
        assert np.isfinite(error).all()


def test_shading_is_defined_on_black_surfaces_and_emitters():
    lamp = pm.Material("lamp", 0.0, 3.0)
    meshes = [
        quad((-1, -1, 1), (1, -1, 1), (1, -1, -1), (-1, -1, -1), pm.Material("black", 0.0)),
        quad((-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1), lamp),
        quad((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), pm.Material("white", 0.9)),
    ]
    result = pm.render(pm.Scene(meshes, camera=CAMERA), bands=2, size=(16, 16), passes=8)
    black = result.reflectance[..., 0] == 0.0
    seen = result.depth > 0
    assert (result.radiance[black & (result.emission[..., 0] == 0)] == 0.0).all()
    assert (result.shading[black & seen & (result.coverage == 1.0)] > 0.0).all()


@pytest.mark.parametrize("method", ["photon", "path"])
def test_same_seed_same_arrays_for_any_number_of_threads(cornell, method):
    one, three = (
        pm.render(cornell, bands=3, size=(40, 30), passes=2, seed=7, threads=threads, method=method)
        for threads in (1, 3)
    )
    assert_same(one, three)


def test_other_seeds_are_independent(cornell):
    one, other = (
        pm.render(cornell, bands=1, size=(24, 24), passes=4, seed=seed) for seed in (0, 2**63 - 1)
    )
    difference = one.radiance.astype(float) - other.radiance
    assert (difference != 0.0).mean() > 0.9
    np.testing.assert_array_equal(one.depth, other.depth)


def test_an_error_budget_is_reproduced_by_its_passes(cornell):
    settings = {"bands": 1, "size": (24, 24), "seed": 2}
    aimed = pm.render(cornell, error=0.05, **settings)
    assert aimed.record["error"] <= 0.05
    assert aimed.record["passes"] >= LEAST_PASSES
    for budget in ({"passes": aimed.record["passes"]}, {"seconds": 1e4}):
        assert_same(aimed, pm.render(cornell, error=0.05, **budget, **settings))


def test_the_stated_error_is_the_definition(cornell):
    result = pm.render(cornell, bands=3, size=(32, 32), passes=5)
    valid = (result.coverage == 1.0) & ~result.emission.any(axis=2) & ~result.unresolved
    value = result.radiance[valid].astype(float)
    error = result.errors["radiance"][valid].astype(float)
    relative = error**2 / (value**2 + 0.01 * value.mean(axis=0) ** 2)
    assert result.record["standard_error"] == pytest.approx(np.sqrt(relative.mean()), rel=1e-5)


def test_an_error_of_another_buffer_is_the_definition(cornell):
    result = pm.render(cornell, bands=2, size=(24, 24), error="shading:p75:0.2", seed=3)
    valid = (result.coverage == 1.0) & ~result.emission.any(axis=2) & ~result.unresolved
    value = result.shading[valid].astype(float)
    error = result.errors["shading"][valid].astype(float)
    relative = error / np.sqrt(value**2 + 0.01 * value.mean(axis=0) ** 2)
    goal = result.record["goal"]
    assert goal["reached"] == pytest.approx(
        np.percentile(relative, 75, method="inverted_cdf"), rel=1e-5
    )
    assert {**goal, "reached": 0.2} == {
        "buffer": "shading", "percentile": 75.0, "limit": 0.2, "reached": 0.2,
    }  # fmt: skip
    assert goal["reached"] <= 0.2
    assert result.record["standard_error"] != goal["reached"]


def test_a_time_budget_holds(cornell):
    result = pm.render(cornell, bands=1, size=(16, 16), seconds=0.2)
    assert result.record["passes"] >= 1
    assert not result.record["interrupted"]
    assert_same(result, pm.render(cornell, bands=1, size=(16, 16), passes=result.record["passes"]))


def test_interruption_keeps_complete_passes(cornell):
    class Interrupter(Silent):
        def update(self, passes, *rest):
            if passes == 3:
                threading.Timer(0.005, os.kill, (os.getpid(), signal.SIGINT)).start()

    result = pm.render(
        cornell, bands=1, size=(64, 64), passes=10_000, seed=1, progress=Interrupter()
    )
    assert result.record["interrupted"]
    assert 3 <= result.record["passes"] < 10_000
    assert_same(
        result,
        pm.render(cornell, bands=1, size=(64, 64), passes=result.record["passes"], seed=1),
    )


def test_depth_normal_and_ids(cornell):
    result = pm.render(cornell, bands=1, size=(33, 33), passes=1)
    middle = 16
    assert result.material_id[0, 0] == result.object_id[0, 0] == 0
    assert result.depth[0, 0] == 0.0
    names = [mesh.name for mesh in cornell.meshes]
    assert result.object_id[2, middle] == names.index("ceiling") + 1
    floor = result.object_id[31, middle]
    assert floor == names.index("floor") + 1
    np.testing.assert_allclose(result.normal[31, middle], (0, 1, 0), atol=1e-6)
    back = result.object_id == names.index("back") + 1
    np.testing.assert_allclose(result.normal[back], np.broadcast_to((0, 0, 1), (back.sum(), 3)))
    y, x = np.argwhere(back)[0]
    tan = np.tan(np.radians(CAMERA.fov / 2))
    ray = np.array([(2 * x + 1 - 33) / 33 * tan, (33 - 2 * y - 1) / 33 * tan, -1.0])
    assert result.depth[y, x] == pytest.approx(4.9, rel=1e-5)
    assert result.distance[y, x] == pytest.approx(4.9 * np.linalg.norm(ray), rel=1e-5)


def test_smooth_normals_agree_with_the_path_tracer():
    """Photons carry the adjoint factor, so shading normals conserve what the path tracer sees."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    room = closed_box(pm.Material("walls", 0.7), name="room")
    smooth = pm.Mesh.from_trimesh(ball, pm.Material("ball", 0.8), "ball", smooth=True)
    scene = pm.Scene(
        [room, smooth],
        [pm.PointLight((0.7, 0.8, 0.6), 1.0)],
        pm.Camera((-0.2, 0.1, 0.95), (0.0, 0.0, 0.0), fov=60.0),
    )
    photon = pm.render(scene, bands=1, size=(20, 20), passes=16, seed=1)
    path = pm.render(scene, bands=1, size=(20, 20), passes=128, seed=2, method="path")
    for name in ("direct", "indirect"):
        mean, truth = getattr(photon, name).mean(dtype=float), getattr(path, name).mean(dtype=float)
        error = np.sqrt((path.standard_error(name).astype(float) ** 2).sum()) / 400
        assert abs(mean - truth) < 4.0 * error + 0.006 * truth


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"passes": 0}, "passes 0"),
        ({"passes": 1.5}, "whole number"),
        ({"seconds": float("inf")}, "seconds inf"),
        ({"error": -1.0}, "error -1"),
        ({"error": 2}, "error 2 is 200%; write a fraction"),
        ({"per_light": "yes"}, "per_light 'yes' is neither True nor False"),
        ({"size": (0, 4)}, "size 0x4"),
        ({"size": (4.5, 4)}, "size 4.5x4"),
        ({"size": (1 << 20, 4)}, "too large"),
        ({"size": (60_000, 60_000)}, "GB"),
        ({"bands": 0}, "band"),
        ({"bands": "many"}, "many"),
        ({"photons": -1}, "photons -1"),
        ({"photons": 0}, "photons"),
        ({"seed": -1}, "seed -1"),
        ({"seed": 2**63}, "seed"),
        ({"seed": 0.5}, "seed"),
        ({"threads": 0}, "threads 0"),
        ({"pixel": "round"}, "round"),
        ({"method": "magic"}, "magic"),
        ({"error": "indirect:95:0.1"}, "'95' is not a percentile"),
        ({"error": "residual:0.1"}, "without mirrors, .* residual is exactly 0"),
        ({"error": "fluorescence:0.1"}, "without fluorescent surfaces fluorescence is exactly 0"),
        ({"buffers": "caustics,fluorescence"}, "without mirrors, .* and without fluorescent"),
    ],
)
def test_bad_options(cornell, options, message):
    with pytest.raises(pm.InputError, match=message):
        pm.render(cornell, **{"size": (4, 4), **options})


GLOWING = pm.Material("black", 0.0, fluorescence=named("fluorescein"))


@pytest.mark.filterwarnings("ignore:bands do not resolve")
@pytest.mark.parametrize("material", [GREY, *slow(GLOWING)], ids=["grey", "fluorescent"])
def test_unresolved_marks_pixels_that_no_photon_reached(cornell, material):
    """Inside a sealed box no light is found, though photons were stored outside."""
    sealed = closed_box(material, 0.3, 0.6, "sealed")
    camera = pm.Camera((0.45, 0.45, 0.59), (0.45, 0.45, 0.0), fov=80.0)
    with pytest.warns(pm.SceneWarning, match="sends nothing into the view"):
        inside = pm.render(
            pm.Scene([*cornell.meshes, sealed], camera=camera), bands=1, size=(8, 8), passes=2
        )
    assert inside.unresolved.all()
    assert inside.record["unresolved"] == 64
    assert inside.record["error"] is None
    assert (inside.radiance == 0.0).all()
    assert not pm.render(cornell, bands=1, size=(16, 16), passes=2).unresolved.any()


MIRRORS = ("left", "right", "back", "ceiling")


def mirrored(cornell, color):
    """Return the box in grey, most walls mirrors, in light of one colour."""
    grey, mirror = pm.Material("grey", 0.5), pm.Material.polished("mirror", 0.9)
    meshes = []
    for mesh in cornell.meshes:
        material = mirror if mesh.name in MIRRORS else grey
        if mesh.name == "light":
            material = replace(mesh.material, emission=color)
        meshes.append(replace(mesh, material=material))
    return pm.Scene(meshes, camera=cornell.camera)


@pytest.mark.parametrize("color", [[10, 0, 0], [0, 0, 10]])
def test_light_of_any_band_resolves_what_mirrors_show(cornell, color):
    result = pm.render(mirrored(cornell, color), bands=3, size=32, passes=1, photons=150, seed=3)
    assert result.record["unresolved"] == 0
