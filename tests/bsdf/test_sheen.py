"""Sheen: tables against quadrature, closed forms, buffers, images, files and bad input."""

from dataclasses import replace

import numpy as np
import pytest
from bsdf_harness import (
    Case,
    departure,
    directional_albedo,
    evaluate,
    hemisphere,
    make_scene,
)
from helpers.scenes import ball, ball_room
from test_coats import RGB, SMALL

import photonmap as pm
from photonmap.compile.effects import EFFECTS, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.compile.surfaces.sheens import LEAST_SHEEN_ALPHA, sheen_lobe
from photonmap.errors import InputError
from photonmap.io.png import encode_png
from photonmap.scene.material import Material

VELVET = Material("velvet", (0.5, 0.1, 0.1), sheen=(0.8, 0.4, 0.6), sheen_roughness=0.4)
GLEAM = Material("satin", 0.3, glossy=0.04, roughness=0.4, sheen=0.7, sheen_roughness=0.3)


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.3, 0.5, 0.7, 1.0])
def test_the_table_is_what_the_lobe_reflects(roughness):
    """Over black, by a quadrature of its own; and no more than arrives at any angle."""
    case = Case("Lambertian", albedo=(0.0,) * 3, sheen=(1.0, roughness))
    lobe = sheen_lobe(max(roughness**2, LEAST_SHEEN_ALPHA))
    places = np.linspace(0.0, 1.0, len(lobe.kept))
    for cosine in (1.0, 0.8, 0.5, 0.2, 0.08, 0.03):
        wi, solid_angles = hemisphere(cosine, heights=96, turns=512)
        values, _ = evaluate(case, wi, departure(cosine))
        cosines = wi @ (departure(1.0))
        found = values[:, 0] @ (cosines * solid_angles)
        table = np.interp(np.sqrt(cosine), places, lobe.albedo[:-1])
        assert found == pytest.approx(table, abs=2e-3)
        assert found <= 1.0 + 1e-3


def test_the_lobe_is_charlie():
    """Its formula, at a roughness at which all of it is kept, and twice as much for twice s."""
    wi, wo = departure(0.6, 0.3), departure(0.35, 2.0)
    alpha, n = 0.25, departure(1.0)
    half = (wi + wo) / np.linalg.norm(wi + wo)
    sine = np.sqrt(1.0 - (half @ n) ** 2)
    density = (2.0 + 1.0 / alpha) * sine ** (1.0 / alpha) / (2.0 * np.pi)

    def masking(x):
        share = (1.0 - alpha) ** 2
        ends = np.array([(21.5473, 3.82987, 0.19823, -1.97760, -4.32054),
                         (25.3245, 3.32435, 0.16801, -1.27393, -4.85967)])  # fmt: skip
        a, b, c, d, e = (1.0 - share) * ends[0] + share * ends[1]

        def at(x):
            return a / (1.0 + b * x**c) + d * x + e

        return np.exp(at(x) if x < 0.5 else 2.0 * at(0.5) - at(1.0 - x))

    expected = density / (4.0 * 0.6 * 0.35 * (1.0 + masking(0.6) + masking(0.35)))
    for color in (0.5, 1.0):
        case = Case("Lambertian", albedo=(0.0,) * 3, sheen=(color, 0.5))
        found = evaluate(case, wi[None], wo)[0]
        np.testing.assert_allclose(found, color * expected, rtol=1e-5)


def test_over_lambert_it_takes_what_it_reflects():
    """At every angle, of a base of albedo ρ as much is left: s E + ρ (1 - s E)."""
    color, albedo = 0.6, sheen_lobe(0.16).albedo
    case = Case("Lambertian", albedo=(0.2, 0.5, 0.9), sheen=(color, 0.4))
    places = np.linspace(0.0, 1.0, len(albedo) - 1)
    for cosine in (1.0, 0.6, 0.2, 0.06):
        own = color * np.interp(np.sqrt(cosine), places, albedo[:-1])
        expected = own + (1.0 - own) * np.array(case.albedo)
        np.testing.assert_allclose(directional_albedo(case, cosine), expected, atol=2e-3)


def test_only_a_scene_that_calls_for_it_has_it():
    coated = Material("car", 0.3, coat=0.5)
    assert compile_scene(ball_room(coated), RGB).scattering.sheens is None
    assert compile_scene(ball_room(replace(VELVET, sheen=0.0)), RGB).scattering is None
    other = ball(coated)
    other = replace(other, vertices=0.2 * other.vertices, name="other")
    both = compile_scene(pm.Scene([ball(VELVET), other], [pm.DomeLight()]), RGB)
    assert both.scattering.sheens is not None
    assert both.scattering.sheens.maps is None
    assert both.scattering.coats is not None
    plan = plan_effects(both, "auto", 3, 3)
    assert plan.on("glossy")
    assert not plan.on("non_lambertian")
    assert not make_scene(Case("Lambertian")).scattering.sheens


def test_without_gloss_the_base_is_left():
    effects = [name for name in EFFECTS if name != "glossy"]
    bare = pm.render(ball_room(VELVET), **SMALL, passes=2, effects=effects)
    plain = pm.render(ball_room(replace(VELVET, sheen=0.0)), **SMALL, passes=2)
    np.testing.assert_array_equal(bare.radiance, plain.radiance)


def test_bands_that_a_sheen_tells_apart_are_not_merged():
    grey, red = (ball_room(Material("ball", 0.4, sheen=sheen)) for sheen in (0.5, (0.5, 0.1, 0.1)))
    one, three = (pm.render(scene, **SMALL, passes=2) for scene in (grey, red))
    assert one.record["effects"]["band_merging"]["on"]
    assert not three.record["effects"]["band_merging"]["on"]


def wall(sheen):
    """A wall that a camera sees whole; the images of its sheen span it."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    material = Material("cloth", 0.3, sheen=sheen, sheen_roughness=0.6)
    uv = 0.25 * corners[:, :2] + 0.5
    mesh = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], material, "wall", uv=uv)
    camera = pm.Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), height=2.0)
    return pm.Scene([mesh], [pm.DomeLight(1.0)], camera)


def test_buffers():
    """The sheen is no part of reflectance and shading, and the lesser of the two parts."""
    names = ("reflectance", "diffuse_fraction", "specular_reflectance", "roughness", "metallic")
    result = pm.render(wall(0.8), **SMALL, passes=2, buffers=names)
    np.testing.assert_allclose(result.reflectance, 0.3, rtol=1e-6)
    own = 0.8 * sheen_lobe(0.36).albedo[-1]
    expected = 0.3 * (1.0 - own) / (0.3 * (1.0 - own) + own)
    np.testing.assert_allclose(result["diffuse_fraction"], expected, rtol=1e-5)
    assert (result["specular_reflectance"] == 0.0).all()
    assert (result["roughness"] == 1.0).all()
    assert (result["metallic"] == 0.0).all()


def test_an_image_gives_the_colour():
    """As the number does where it is even; buffers look it up from 0.25 at the left to 0.75."""
    even = pm.Texture.of(np.full((2, 2, 3), 0.5, np.float32))
    settings = SMALL | {"passes": 16}
    one, other = (pm.render(wall(sheen), **settings) for sheen in (0.5, even))
    errors = np.stack([result.errors["radiance"][..., 0] for result in (one, other)])
    spread = np.sqrt((errors.astype(float) ** 2).sum()) / errors[0].size
    assert other.radiance.mean() == pytest.approx(one.radiance.mean(), abs=4.0 * spread)
    assert spread < 1e-3
    ramp = pm.Texture.of(np.repeat([[[0.25], [0.75]]], 3, axis=2).astype(np.float32))
    result = pm.render(wall(ramp), **settings, buffers=("radiance", "diffuse_fraction"))
    own = (0.25 + (np.arange(12) + 0.5) / 24.0) * sheen_lobe(0.36).albedo[-1]
    expected = 0.3 * (1.0 - own) / (0.3 * (1.0 - own) + own)
    found = result["diffuse_fraction"][..., 0]
    np.testing.assert_allclose(found, np.tile(expected, (12, 1)), rtol=1e-3)


@pytest.mark.parametrize(
    ("other", "found"),
    [
        ({"ior": 1.5, "reflectance": 0.0}, "ior"),
        ({"mirror": 0.2}, "mirror"),
        ({"coat": 0.5}, "coat"),
    ],
)
def test_what_no_sheen_lies_over_is_refused(other, found):
    material = Material(**{"name": "cup", "sheen": 0.5, "reflectance": 0.4, **other})
    with pytest.raises(InputError, match=rf"material 'cup': sheen does not go with {found}: \w+"):
        compile_scene(ball_room(material), RGB)


class Moss(Material):
    """A surface of a BSDF whose white base covers do not know."""

    scattering = "moss", (0.3,)


@pytest.mark.parametrize("cover", ["coat", "sheen"])
def test_no_cover_lies_over_an_unknown_model(cover):
    message = "material 'bark': coat and sheen do not go over a moss surface; set both to 0"
    with pytest.raises(InputError, match=message):
        compile_scene(ball_room(Moss("bark", **{cover: 0.5})), RGB)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"sheen": 1.2}, r"'cup': sheen is 1\.2 in band \w+; it must lie between 0 and 1"),
        ({"sheen": (0.1, -0.5, 0.0)}, r"'cup': sheen is -0\.\d+ in band"),
        ({"sheen": pm.Texture.of(np.full((2, 2), 1.5))}, r"'cup': sheen.* 1\.5"),
        ({"sheen": 0.5, "sheen_roughness": 1.1}, r"'cup': sheen_roughness: 1\.1 is not a rough"),
        ({"sheen": 0.5, "sheen_roughness": -0.1}, r"sheen_roughness: -0\.1 is not a rough"),
    ],
)
def test_bad_input(wrong, message):
    with pytest.raises(InputError, match=message):
        compile_scene(wall(0.0).with_materials({"wall": Material("cup", **wrong)}), RGB)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_it(tmp_path, suffix):
    texels = np.random.default_rng(3).integers(0, 256, (4, 4, 3), dtype=np.uint8)
    image = pm.Texture.of(texels)
    sheens = {"number": 0.4, "colour": (0.2, 0.4, 0.6), "image": image}
    meshes = [
        replace(ball(replace(GLEAM, name=name, sheen=sheen)), name=name)
        for name, sheen in sheens.items()
    ]
    first, *_ = pm.save_scene(pm.Scene(meshes), tmp_path / f"scene{suffix}")
    read = {mesh.material.name: mesh.material for mesh in pm.load_scene(first).meshes}
    for name, sheen in sheens.items():
        found = read[name]
        assert found.sheen_roughness == GLEAM.sheen_roughness
        if name == "image":
            everywhere = slice(None), slice(None)
            wanted = image.image.linear(*everywhere)
            np.testing.assert_allclose(found.sheen.image.linear(*everywhere), wanted, atol=1e-5)
        else:
            np.testing.assert_allclose(np.ones(3) * found.sheen, np.ones(3) * sheen)


def test_by_toml(tmp_path):
    pm.save_scene(ball_room(Material("ball", 0.8)), tmp_path / "scene.obj")
    text = "mesh = 'scene.obj'\n[material.ball]\nsheen = [0.1, 0.2, 0.3]\nsheen_roughness = 0.7\n"
    (tmp_path / "scene.toml").write_text(text)
    meshes = pm.load_scene(tmp_path / "scene.toml").meshes
    found = next(mesh.material for mesh in meshes if mesh.name == "ball 0")
    np.testing.assert_allclose(found.sheen, (0.1, 0.2, 0.3))
    assert found.sheen_roughness == 0.7
    (tmp_path / "cloth.png").write_bytes(encode_png(np.full((2, 2, 3), 188, np.uint8)))
    image = text.replace("[0.1, 0.2, 0.3]", "{ file = 'cloth.png' }")
    (tmp_path / "scene.toml").write_text(image)
    meshes = pm.load_scene(tmp_path / "scene.toml").meshes
    found = next(mesh.material for mesh in meshes if mesh.name == "ball 0")
    np.testing.assert_allclose(found.sheen.mean, 0.503, atol=1e-3)
    (tmp_path / "scene.toml").write_text(text.replace("0.7", "1.7"))
    with pytest.raises(InputError, match=r":4: .*sheen_roughness: 1\.7 is not a roughness"):
        pm.load_scene(tmp_path / "scene.toml")
