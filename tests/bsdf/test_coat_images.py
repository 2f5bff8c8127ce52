"""Clear coats whose roughness is an image, or which have normals of their own."""

from dataclasses import replace

import numpy as np
import pytest
from bsdf_harness import (
    FRAME,
    NORMAL,
    SAMPLES,
    Case,
    departure,
    directional_albedo,
    evaluate,
    hemisphere,
    sample,
    scatter,
)
from helpers.comparisons import assert_within
from helpers.scenes import ball, ball_room
from test_bsdf_models import (
    SIGMAS,
    SIGNIFICANCE,
    fit_of_samples,
    random_directions,
)
from test_coats import RGB, SMALL
from test_relief import ABOVE, encoded, plane, tilted
from test_white_furnace import BASES

import photonmap as pm
from photonmap.compile.effects import plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError

COAT = (1.0, 0.5, 1.5)
LEAN = tuple(tilted(0.3, 0.5)[0])
LEANING = [
    Case("glossy", (0.2,), (0.1, 0.5, 0.9), (0.04,) * 3, coat=COAT, coat_lean=LEAN),
    Case("Lambertian", coat=(0.7, 0.4, 1.5), coat_lean=tuple(tilted(0.7, 2.0)[0])),
]
LACQUER = pm.Material("ground", 0.0, coat=1.0, coat_roughness=0.5)


@pytest.mark.parametrize("base", ["white paint", "matt metal"])
def test_an_even_image_is_its_number(base):
    case = BASES[base]._replace(coat=COAT)
    wi, wo = random_directions(2000, 1), random_directions(2000, 2)
    for other in ({"is_coat_textured": True}, {"coat_lean": (0.0, 0.0, 1.0)}):
        found, wanted = (evaluate(each, wi, wo) for each in (case._replace(**other), case))
        for one, two in zip(found, wanted, strict=True):
            np.testing.assert_allclose(one, two, rtol=1e-4)


@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.35])
@pytest.mark.parametrize("case", LEANING, ids=lambda case: case.model)
def test_samples_of_a_leaning_coat_follow_the_density(case, cosine):
    """χ² over bins of the hemisphere, and one for what is sampled below the horizon."""
    wo = departure(cosine, 0.7)
    assert fit_of_samples(case, wo) > SIGNIFICANCE


@pytest.mark.parametrize("cosine", [0.8, 0.35])
@pytest.mark.parametrize("case", LEANING, ids=lambda case: case.model)
def test_what_leaves_below_a_leaning_coats_horizon_has_a_density(case, cosine):
    """The density adds up to the share of samples that leave above the base's horizon."""
    wo = departure(cosine)
    share = (sample(case, wo, key=3) @ NORMAL > 0.0).mean()
    wi, solid_angles = hemisphere(cosine)
    total = evaluate(case, wi, wo)[1] @ solid_angles
    assert total == pytest.approx(share, abs=3e-4 + SIGMAS * np.sqrt(share * (1 - share) / SAMPLES))


@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.35])
@pytest.mark.parametrize("case", LEANING, ids=lambda case: case.model)
def test_paths_and_photons_on_a_leaning_coat(case, cosine):
    """Means of their samples are integrals of one BSDF, in which light is at either end."""
    wo = departure(cosine)
    wi = sample(case, wo, key=3)
    values, density = evaluate(case, wi, wo)
    cosines, used = np.maximum(wi @ NORMAL, 0.0), density > 0.0
    weights = values * np.where(used, cosines / np.where(used, density, 1.0), 0.0)[:, None]
    away, solid_angles = hemisphere(cosine)
    from_there = evaluate(case, np.broadcast_to(wo, away.shape), away)[0]
    sent = from_there.T @ ((away @ NORMAL) * solid_angles)
    pairs = (weights, directional_albedo(case, cosine)), (scatter(case, wo), sent)
    for estimates, truth in pairs:
        error = estimates.std(axis=0) / np.sqrt(SAMPLES)
        assert_within(estimates.mean(axis=0), truth, error, SIGMAS, slack=3e-4)


def test_a_leaning_coat_is_reciprocal_by_its_own_cosine():
    """As a shading normal is: f(wi, wo) (wi · n) / (wi · m) is the same both ways."""
    case = Case("Lambertian", albedo=(0.0,) * 3, coat=COAT, coat_lean=LEAN)
    wi, wo = random_directions(4000, 1), random_directions(4000, 2)
    normal = np.array(LEAN) @ FRAME
    forth, back = (
        evaluate(case, *pair)[0] * ((pair[0] @ NORMAL) / (pair[0] @ normal))[:, None]
        for pair in ((wi, wo), (wo, wi))
    )
    least = np.minimum(wi @ normal, wo @ normal)
    np.testing.assert_allclose(forth[least > 0.1], back[least > 0.1], rtol=2e-5)
    assert (forth[least < -1e-3] == 0.0).all()


@pytest.mark.filterwarnings("ignore:light 'directional' sends nothing")
@pytest.mark.parametrize("sun", [(0.2, 1.0, 0.1), (-0.4, 1.0, 0.4), (0.4, 1.0, 0.4)])
def test_over_black_it_is_a_surface_of_that_normal(sun):
    """The same picture as of a coat that follows its base, and as of one over nothing."""
    lean = pm.NormalMap(encoded(*tilted(0.4, 0.5)[0]))
    steep = pm.NormalMap(encoded(*tilted(1.2, 2.5)[0]))

    def seen(**look):
        mesh = replace(plane(None), material=replace(LACQUER, **look))
        light = pm.DirectionalLight(tuple(-np.array(sun)), irradiance=2.0)
        return pm.render(pm.Scene([mesh], [light], ABOVE), **SMALL, passes=1).radiance

    own = seen(coat_relief=lean)
    assert own.min() > 0.0
    np.testing.assert_allclose(own, seen(relief=lean), rtol=1e-4)
    even = seen()
    assert abs(own / even - 1.0).min() > 0.1
    flat = seen(relief=steep, coat_relief=pm.NoRelief())
    if np.dot(tilted(1.2, 2.5)[1], sun) > 0.0:
        np.testing.assert_allclose(flat, even, rtol=1e-4)
    else:
        assert (flat == 0.0).all()  # no light is sampled below a base's horizon


def varied(seed=3):
    """Return a ball of paint below a coat of varied roughness that lies smoothly over relief."""
    random = np.random.default_rng(seed)
    rough = pm.Texture.of(random.uniform(0.1, 0.9, (8, 8, 1)).astype(np.float32))
    bumps = pm.BumpMap(pm.Texture.of(random.uniform(0.0, 1.0, (8, 8, 1))), 0.02)
    material = pm.Material("car", (0.2, 0.4, 0.7), coat=0.8, coat_roughness=rough, relief=bumps)
    return replace(material, glossy=0.04, roughness=0.4, coat_relief=pm.NoRelief())


def test_buffers_look_up_the_roughness():
    """Over paint, of the roughness 0.25 at the left edge of the texture, and 0.75 at the right."""
    ramp = pm.Texture.of(np.array([[[0.25], [0.75]]], np.float32))
    mesh = replace(plane(None), material=replace(LACQUER, reflectance=0.5, coat_roughness=ramp))
    camera = replace(ABOVE, height=2.0)
    scene = pm.Scene([mesh], [pm.DomeLight(1.0)], camera)
    names = ("roughness", "diffuse_fraction")
    result = pm.render(scene, **SMALL, passes=1, buffers=names)
    wanted = 0.25 + (np.arange(12) + 0.5) / 24.0
    np.testing.assert_allclose(result["roughness"], np.tile(wanted, (12, 1)), rtol=1e-5)
    assert np.ptp(result["diffuse_fraction"]) > 0.0


def test_only_a_scene_that_calls_for_it_has_them():
    plain = replace(varied(), coat_roughness=0.3, relief=None)
    coats = compile_scene(ball_room(plain), RGB).scattering.coats
    assert coats.maps is None
    assert coats.relief is None
    compiled = compile_scene(ball_room(varied()), RGB)
    assert plan_effects(compiled, "auto", 3, 3).on("textures")
    assert compiled.scattering.coats.maps is not None
    assert compiled.scattering.coats.relief is not None
    leaning = replace(plain, coat_relief=pm.NormalMap(encoded(*LEAN)))
    plan = plan_effects(compile_scene(ball_room(leaning), RGB), "auto", 3, 3)
    assert plan.on("relief")
    assert not plan.on("textures")


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_them(tmp_path, suffix):
    texels = np.random.default_rng(8).integers(0, 256, (4, 4, 3), dtype=np.uint8)
    rough = pm.Texture.of(texels[..., :1], srgb=False)
    bumps = pm.BumpMap(rough, 0.02)
    lean, other = (pm.NormalMap(pm.Texture.of(t, srgb=False)) for t in (texels, texels[::-1]))
    coats = {
        "followed": (lean, None),
        "smooth": (lean, pm.NoRelief()),
        "smooth over bumps": (bumps, pm.NoRelief()),
        "own": (lean, other),
        "alone": (None, other),
        "bumps": (lean, bumps),
    }
    paint = pm.Material("", 0.5, coat=0.5, coat_roughness=rough)
    meshes = [
        replace(ball(replace(paint, name=name, relief=below, coat_relief=above)), name=name)
        for name, (below, above) in coats.items()
    ]
    path = tmp_path / f"scene{suffix}"
    pm.save_scene(pm.Scene(meshes), path)
    read = {mesh.material.name: mesh.material for mesh in pm.load_scene(path).meshes}
    for name, pair in coats.items():
        found = read[name]
        np.testing.assert_allclose(values(found.coat_roughness), values(rough), atol=1e-5)
        for image, wanted in zip((found.relief, found.own_coat_relief), pair, strict=True):
            assert type(image) is type(wanted)
            if hasattr(wanted, "texture"):
                np.testing.assert_allclose(values(image.texture), values(wanted.texture), atol=1e-5)


def values(texture):
    return texture.image.linear(slice(None), slice(None)).mean(axis=2) * texture.factor[0]


def test_by_toml(tmp_path):
    pm.save_scene(ball_room(pm.Material("ball", 0.8)), tmp_path / "scene.obj")
    text = "mesh = 'scene.obj'\n[material.ball]\ncoat = 1\ncoat_relief = { type = 'none' }\n"
    (tmp_path / "scene.toml").write_text(text)
    meshes = pm.load_scene(tmp_path / "scene.toml").meshes
    found = next(mesh.material for mesh in meshes if mesh.name == "ball 0")
    assert found.coat_relief == pm.NoRelief()
    (tmp_path / "scene.toml").write_text(text.replace("none", "flat"))
    with pytest.raises(InputError, match=r":4: .*coat_relief: type 'flat' is not known"):
        pm.load_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"coat_relief": 0.1}, "coat_relief: 0.1 is not a relief; give one of NormalMap, BumpMap"),
        ({"coat_relief": pm.NormalMap(pm.Texture.of(np.zeros((2, 2, 1))))}, "has three channels"),
        ({"coat_roughness": pm.Texture.of(np.full((2, 2), 1.5))}, "the texture reaches 1.5"),
    ],
)
def test_bad_input(wrong, message):
    with pytest.raises(InputError, match=r"'ground'.*coat_") as error:
        compile_scene(ball_room(replace(LACQUER, **wrong)), RGB)
    assert message in str(error.value)
