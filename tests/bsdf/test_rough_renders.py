"""Rough diffuse surfaces in pictures: closed forms, bits, and files."""

import numpy as np
import pytest
import trimesh
from bsdf_harness import Case, directional_albedo
from helpers.comparisons import assert_within
from helpers.passes import SIGNIFICANCE, pass_means
from helpers.scenes import closed_box, quad
from scipy import stats

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene, describe_run
from photonmap.kernels.bsdf.models import MODELS
from photonmap.kernels.core.passes import Film

METHODS = ("photon", "path")
SMALL = {"bands": 1, "size": (12, 12), "threads": 2}


def wall(roughness, reflectance=0.6, **attributes):
    return pm.Material("wall", reflectance, diffuse_roughness=roughness, **attributes)


def room(roughness, *meshes):
    """A closed box with a lamp beside the camera, which rough walls reflect back."""
    lamp = quad((0.5, 0.5, 0.9), (0.5, 0.9, 0.9), (0.9, 0.9, 0.9), (0.9, 0.5, 0.9),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    camera = pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0)
    return pm.Scene([closed_box(wall(roughness)), lamp, *meshes], camera=camera)


def block(material):
    box = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    return pm.Mesh(box.vertices, box.faces, material, "block")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("reflectance", "roughness"), [(1.0, 0.7), (0.6, 1.0), (0.8, 0.25)])
def test_a_rough_block_under_an_even_sky(method, reflectance, roughness):
    """It sends the directional albedo of the view times the sky's radiance: all, if it is white.

    An orthographic camera sees all of it at one angle.
    """
    camera = pm.Camera((0.0, 2.0, 2.5), (0.0, 0.5, 0.0), height=0.4)
    sky, material = pm.DomeLight(2.0), wall(roughness, reflectance)
    result = pm.render(
        pm.Scene([block(material)], [sky], camera), **SMALL, passes=64, photons=500, method=method
    )
    cosine = 1.5 / np.hypot(1.5, 2.5)
    truth = 2.0 * directional_albedo(Case("rough diffuse", (roughness,), (reflectance,)), cosine)[0]
    if reflectance == 1.0:
        assert truth == pytest.approx(2.0, rel=1e-4)
    # Pixels have errors of their own, of few passes: their mean is the test.
    error = np.sqrt((result.standard_error("radiance").astype(float) ** 2).sum()) / 144
    assert_within(result.radiance.mean(dtype=float), truth, error, 4.5, 2e-4)
    assert error < 0.01 * truth
    np.testing.assert_allclose(result.shading, 2.0, rtol=1e-5)
    np.testing.assert_allclose(result.reflectance, reflectance, rtol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_furnace_between_rough_walls(furnace, method):
    """L lies between E / (1 - ρ) of the least and of the greatest directional albedo ρ.

    Each bounce returns no less than the one and no more than the other, from any angle.
    """
    roughness, rho = 0.6, 0.7
    scene = furnace(rho)
    scene.meshes[0] = closed_box(wall(roughness, rho, emission=1.0))
    case = Case("rough diffuse", (roughness,), (rho,))
    albedos = [directional_albedo(case, cosine)[0] for cosine in np.linspace(0.02, 1.0, 50)]
    assert max(albedos) < rho < min(albedos) + 0.1
    means = pass_means(scene, method, 12 if method == "photon" else 96).sum(axis=1)
    error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
    reach = stats.t.isf(SIGNIFICANCE / means[0].size, len(means) - 1) * error
    low, high = 1.0 / (1.0 - min(albedos)), 1.0 / (1.0 - max(albedos))
    mean = means.mean(axis=0)
    assert (mean >= low - reach).all()
    assert (mean <= high + reach).all()
    assert (mean < 0.99 / (1.0 - rho)).all(), "as bright as between smooth walls"


@pytest.mark.parametrize("method", METHODS)
def test_roughness_0_changes_no_bit(method):
    settings = SMALL | {"passes": 2, "photons": 500, "seed": 5, "method": method}
    without = room(0.0)
    without.meshes[0] = closed_box(pm.Material("wall", 0.6))
    first, second = pm.render(without, **settings), pm.render(room(0.0), **settings)
    assert set(first.buffers) == set(second.buffers)
    for name, image in first.buffers.items():
        np.testing.assert_array_equal(second.buffers[name], image)
    rough = pm.render(room(0.5), **settings)
    assert not np.array_equal(rough.radiance, first.radiance)


def test_what_reaches_kernels():
    """Materials without roughness keep Lambert's law beside those that have one."""
    scene = room(0.3)
    compiled = compile_scene(scene, pm.Bands.parse("rgb"))
    assert compiled.scattering.model.tolist() == [MODELS["rough diffuse"], 0]
    assert compiled.scattering.parameters[0].tolist() == [0.3, 0.0, 0.0, 0.0, 0.0, -1.0]
    assert not compiled.scattering.parameters[1, :5].any()
    assert compile_scene(room(0.0), pm.Bands.parse("rgb")).scattering is None


def test_roughness_decides_which_runs_may_be_joined():
    """Runs of walls of other roughness are not merged, and no checkpoint is resumed for them."""
    bands, film = pm.Bands.parse("rgb"), Film(8, 8, True)
    prints = [
        describe_run(compile_scene(room(roughness), bands), bands, film, {})
        for roughness in (0.3, 0.3, 0.4, 0.0)
    ]
    assert prints[0] == prints[1]
    assert len({each["materials"] for each in prints}) == 3


def test_files_keep_the_roughness(tmp_path):
    pm.save_scene(room(0.375), tmp_path / "room.obj")
    assert "diffuse_roughness 0.375\n" in (tmp_path / "room.mtl").read_text()
    walls, lamp = pm.load_scene(tmp_path / "room.obj").meshes
    assert walls.material == wall(0.375)
    assert lamp.material.diffuse_roughness == 0.0
    (tmp_path / "room.toml").write_text("[material.wall]\ndiffuse_roughness = 0.75\n")
    assert pm.load_scene(tmp_path / "room.obj").meshes[0].material == wall(0.75)


@pytest.mark.parametrize("value", ["1.5", "-0.1", "nan", '"rough"', "[0.5]"])
def test_bad_roughness_is_refused_with_its_line(tmp_path, value):
    pm.save_scene(room(0.5), tmp_path / "room.obj")
    (tmp_path / "room.toml").write_text(f"[material.wall]\ndiffuse_roughness = {value}\n")
    message = r"room\.toml:2: \[material\.wall\] diffuse_roughness: .* a roughness; give a number"
    with pytest.raises(pm.InputError, match=message):
        pm.load_scene(tmp_path / "room.obj")


def test_glass_has_no_roughness(tmp_path):
    pm.save_scene(room(0.0), tmp_path / "room.obj")
    text = "[material.wall]\nior = 1.5\ndiffuse_roughness = 0.5\n"
    (tmp_path / "room.toml").write_text(text)
    with pytest.raises(pm.InputError, match=r":3: .*diffuse_roughness: glass has none; leave out"):
        pm.load_scene(tmp_path / "room.obj")
