"""Clear coats: closed forms, effects, buffers, files and bad input."""

import numpy as np
import pytest
from bsdf_harness import NORMAL, Case, departure, evaluate, sample
from helpers.scenes import ball_room
from test_metals import born_wolf

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
LACQUER = {"coat": 1.0, "coat_roughness": 0.1}
METAL = pm.Material("car", 0.0, glossy=(0.9, 0.3, 0.2), roughness=0.5, **LACQUER)


def test_a_coat_over_paint_is_plastic():
    """A whole coat over a Lambertian base is the BSDF of a glossy lobe over that base."""
    albedo = (0.1, 0.5, 1.0)
    painted = Case("Lambertian", albedo=albedo, coat=(1.0, 0.5, 1.5))
    plastic = Case("glossy", (0.25,), albedo, (0.04,) * 3, index=1.5)
    wi, wo = (departure(cosine, azimuth) for cosine, azimuth in ((0.7, 0.3), (0.4, 2.0)))
    for other in (wo, -wi + 2.0 * (wi @ NORMAL) * np.array(NORMAL)):
        one, two = (evaluate(case, wi[None], other)[0] for case in (painted, plastic))
        np.testing.assert_allclose(one, two, rtol=2e-3)


def test_a_polished_coat_over_a_polished_metal_is_two_mirrors():
    """Together they reflect F + (1 - F)² R / (1 - F R), all reflections between them added up."""
    for albedo in (0.3, 0.9):
        case = Case("glossy", (1e-3,), (0.0,) * 3, (albedo,) * 3, coat=(1.0, 0.0, 1.5))
        for cosine in (1.0, 0.5):
            wo = departure(cosine)
            wi = sample(case, wo, count=20_000)
            values, density = evaluate(case, wi, wo)
            used = density > 0.0
            total = np.where(used, values[:, 0] * (wi @ NORMAL) / density, 0.0).mean()
            coat = born_wolf(1.5, 0.0, cosine)
            metal = albedo + (1.0 - albedo) * (1.0 - cosine) ** 5
            expected = coat + (1.0 - coat) ** 2 * metal / (1.0 - coat * metal)
            assert total == pytest.approx(expected, rel=3e-3)


def test_the_weight_mixes_bare_and_coated_surfaces():
    bare = Case("glossy", (0.3,), (0.2, 0.5, 0.8), (0.04,) * 3)
    wi, wo = departure(0.7, 0.3)[None], departure(0.5, 2.0)
    none, half, all_of_it = (
        evaluate(bare._replace(coat=(weight, 0.3, 1.5)), wi, wo)[0] for weight in (0.0, 0.5, 1.0)
    )
    np.testing.assert_allclose(half, 0.5 * (none + all_of_it), rtol=1e-5)


def test_only_a_scene_that_calls_for_it_has_coats():
    assert compile_scene(ball_room(pm.Material.metal(roughness=0.5)), RGB).scattering.coats is None
    compiled = compile_scene(ball_room(METAL), RGB)
    assert compiled.scattering.coats is not None
    assert plan_effects(compiled, "auto", 3, 3).on("glossy")


def test_without_gloss_the_base_is_left():
    effects = [name for name in EFFECTS if name != "glossy"]
    coated = pm.render(ball_room(pm.Material(**LACQUER)), **SMALL, passes=2, effects=effects)
    diffuse = pm.render(ball_room(pm.Material()), **SMALL, passes=2)
    np.testing.assert_array_equal(coated.radiance, diffuse.radiance)


def test_buffers():
    """At normal incidence metal and coat reflect as two mirrors; the base tells the rest."""
    names = ("specular_reflectance", "roughness", "metallic", "diffuse_fraction")
    metal = pm.Material("car", 0.0, glossy=0.8, roughness=0.5, **LACQUER)
    tile = pm.Material("tile", 0.5, coat=0.5, coat_roughness=0.4)
    seen = {}
    for material in (metal, tile):
        result = pm.render(ball_room(material), **SMALL, passes=2, buffers=(*names, "object_id"))
        at = result.object_id == 3
        assert at.any()
        seen[material.name] = {name: result[name][at].mean(axis=0) for name in names}
    both = 0.04 + 0.96**2 * 0.8 / (1.0 - 0.04 * 0.8)
    np.testing.assert_allclose(seen["car"]["specular_reflectance"], both, rtol=1e-5)
    assert seen["car"]["roughness"] == pytest.approx(0.5)
    assert seen["car"]["metallic"] == pytest.approx(1.0)
    assert (seen["car"]["diffuse_fraction"] == 0.0).all()
    np.testing.assert_allclose(seen["tile"]["specular_reflectance"], 0.02, rtol=1e-5)
    assert seen["tile"]["roughness"] == pytest.approx(0.4)
    assert 0.88 < seen["tile"]["diffuse_fraction"].mean() < 0.96


def test_a_texture_gives_the_weight(tmp_path):
    """Texels of 0 and 1 look as no coat and a whole one do, also from files that were written."""
    texels = np.zeros((1, 2, 3), np.float32)
    texels[:, 1] = 1.0
    patch = pm.Texture.of(texels)
    floor = np.array([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]])
    uv = np.array([[0.25, 0.5], [0.25, 0.5], [0.75, 0.5], [0.75, 0.5]])
    uv[2:] = 0.25
    camera = pm.Camera((0.0, 1.5, 1.5), (0.0, 0.0, 0.0), fov=30.0)
    sky = [pm.DomeLight(1.0)]

    def seen(coat, shift=0.0, path=None):
        material = pm.Material("m", 0.3, coat=coat, coat_roughness=0.5)
        mesh = pm.Mesh(floor, [[0, 1, 2], [0, 2, 3]], material, "floor", uv=uv + [shift, 0.0])
        scene = pm.Scene([mesh], sky, camera)
        if path is not None:
            pm.save_scene(scene, path)
            scene = pm.load_scene(path)
        result = pm.render(scene, **SMALL, passes=32)
        return result.radiance[4:8, 4:8].mean(), (result.errors["radiance"][4:8, 4:8] ** 2).sum()

    (bare, _), (whole, variance) = seen(0.0), seen(1.0)
    assert whole - bare > 0.015
    assert seen(patch)[0] == pytest.approx(bare, abs=1e-5)
    for path in (None, tmp_path / "floor.glb", tmp_path / "floor.obj"):
        value, own = seen(patch, 0.5, path)
        assert value == pytest.approx(whole, abs=4.0 * float(variance + own) ** 0.5 / (16 * 3))


def test_buffers_look_up_the_weight():
    """Over paint, of the weight 0.25 at the left edge of the texture, and 0.75 at the right one."""
    ramp = pm.Texture.of(np.repeat([[[0.25], [0.75]]], 3, axis=2).astype(np.float32))
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    uv = 0.25 * corners[:, :2] + 0.5
    material = pm.Material("m", 0.3, coat=ramp, coat_roughness=0.4)
    wall = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], material, "wall", uv=uv)
    camera = pm.Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), height=2.0)
    scene = pm.Scene([wall], [pm.DomeLight(1.0)], camera)
    names = ("specular_reflectance", "roughness", "diffuse_fraction")
    result = pm.render(scene, **SMALL, passes=2, buffers=names)
    weight = 0.25 + (np.arange(12) + 0.5) / 24.0
    seen = result["specular_reflectance"][..., 0]
    np.testing.assert_allclose(seen, np.tile(0.04 * weight, (12, 1)), rtol=1e-3)
    np.testing.assert_allclose(result["roughness"], 0.4, rtol=1e-6)
    assert (np.diff(result["diffuse_fraction"][0, :, 0]) < 0.0).all()


@pytest.mark.parametrize(
    ("other", "found"),
    [
        ({"ior": 1.5, "reflectance": 0.0}, "ior"),
        ({"mirror": 0.2}, "mirror"),
        ({"diffuse_roughness": 0.5}, "diffuse_roughness"),
    ],
)
def test_what_no_coat_lies_over_is_refused(other, found):
    material = pm.Material(**{"name": "cup", "coat": 0.5, "reflectance": 0.4, **other})
    with pytest.raises(InputError, match=rf"material 'cup': coat does not go with {found}: \w+"):
        compile_scene(ball_room(material), RGB)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"coat": 1.2}, r"coat: 1\.2 is not a weight"),
        ({"coat_roughness": -0.1}, r"coat_roughness: -0\.1 is not a roughness"),
        ({"coat_ior": 0.9}, r"coat_ior: 0\.9 is not an index of refraction"),
    ],
)
def test_numbers_out_of_range_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        compile_scene(ball_room(pm.Material("cup", **wrong)), RGB)
