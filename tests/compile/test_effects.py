"""Only the effects that a scene calls for: off is proved, on makes a difference."""

from functools import cache

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.compile.effects import EFFECTS, parse_effects
from photonmap.errors import InputError

CAMERA = pm.Camera((0.3, 0.4, 4.0), (0, 0, 0), fov=40)
GREY = pm.Material("grey", 0.5)
SUN = pm.DirectionalLight((0.2, -1, -0.5), 2.0)
LIGHT = ("radiance", "emission", "direct", "indirect", "reflectance", "shading")


def body(mesh, material=GREY, name="body"):
    return pm.Mesh.from_trimesh(mesh, material, name)


def scene(*meshes, lights=(SUN,), camera=CAMERA):
    return pm.Scene(list(meshes), list(lights), camera)


def render(scene, **settings):
    settings = {"bands": 3, "size": (16, 16), "passes": 4, "photons": 2000, "seed": 1, **settings}
    return pm.render(scene, **settings)


def cube(**changed):
    return body(trimesh.creation.box((1, 1, 1)), **changed)


def two():
    other = trimesh.creation.box((1, 1, 1)).apply_translation((1.2, 0, 0))
    return cube(), body(other, name="other")


SPHERE = trimesh.creation.icosphere(2)
OPEN = trimesh.Trimesh(trimesh.creation.box((1, 1, 1)).vertices, trimesh.creation.box().faces[2:])
PANEL = pm.Mesh([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 2, 1], [0, 3, 2]], GREY)
SCENES = {
    "cube": (scene(cube()), "indirect", False),
    "sphere": (scene(body(SPHERE)), "indirect", False),
    "panel": (scene(PANEL), "indirect", False),
    "black": (scene(*two()[:1], body(SPHERE, pm.Material("black", 0.0))), "indirect", True),
    "all black": (
        scene(cube(material=pm.Material("a", 0.0)), body(SPHERE, pm.Material("b", 0.0))),
        "indirect", False,
    ),
    "two": (scene(*two()), "indirect", True),
    "open cube": (scene(body(OPEN)), "indirect", True),
    "camera inside": (scene(cube(), camera=pm.Camera((0, 0, 0.1), (0, 0, 0))), "indirect", True),
    "lamp inside": (scene(cube(), lights=[pm.PointLight((0, 0, 0))]), "indirect", True),
    "holes": (scene(cube(material=pm.Material("holes", 0.5, alpha=0.5))), "indirect", True),
    "concave": (scene(body(trimesh.creation.annulus(0.5, 1.0, 1.0))), "indirect", True),
    "sun": (scene(*two()), "soft_shadows", False),
    "dome": (scene(*two(), lights=[pm.DomeLight()]), "soft_shadows", True),
    "no lamp in view": (scene(*two()), "emission", False),
    "sky in view": (scene(*two(), lights=[pm.DomeLight()]), "emission", True),
    "no glass": (scene(*two()), "caustics", False),
    "glass": (scene(cube(), body(SPHERE, pm.Material.glass())), "caustics", True),
    "glass alone": (scene(body(SPHERE, pm.Material.glass())), "caustics", False),
    "mirror": (scene(cube(), body(SPHERE, pm.Material.polished())), "transmission", False),
    "mirrors": (scene(cube(), body(SPHERE, pm.Material.polished())), "specular", True),
    "grey": (scene(*two()), "band_merging", True),
    "coloured": (scene(cube(material=pm.Material("c", (0.9, 0.5, 0.1)))), "band_merging", False),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:light .* sends nothing into the view")
@pytest.mark.parametrize("name", SCENES)
def test_the_plan_knows_what_a_scene_calls_for(name):
    made, effect, on = SCENES[name]
    record = render(made, size=(2, 2), passes=1).record["effects"]
    assert list(record) == list(EFFECTS)
    assert record[effect]["on"] == on, record[effect]["why"]
    assert all(entry["why"] for entry in record.values())


@pytest.mark.parametrize("name", ["cube", "sphere", "panel", "all black"])
def test_light_between_surfaces_is_left_out_where_there_is_none(name):
    made = SCENES[name][0]
    auto, full = render(made), render(made, effects="all")
    assert not auto.indirect.any()
    assert not full.indirect.any()
    error = np.hypot(auto.standard_error("radiance"), full.standard_error("radiance"))
    assert (np.abs(auto.radiance - full.radiance) <= 6.0 * error + 1e-6).all()
    assert auto.record["rays"] < full.record["rays"]
    assert auto.record["photons"] == 0 < full.record["photons"]


def test_merged_bands_are_the_same_to_the_last_bit():
    made = SCENES["grey"][0]
    auto = render(made, bands=9)
    every = [effect for effect in EFFECTS if effect != "band_merging"]
    apart = render(made, bands=9, effects=every)
    assert auto.record["effects"]["band_merging"]["on"]
    assert not apart.record["effects"]["band_merging"]["on"]
    for name in LIGHT:
        np.testing.assert_array_equal(auto.buffers[name], apart.buffers[name])
        np.testing.assert_array_equal(auto.standard_error(name), apart.standard_error(name))
    assert auto.record["error"] == pytest.approx(apart.record["error"], rel=1e-9)


def test_equal_columns_anywhere_are_merged():
    flat = pm.Spectrum([380, 540, 560, 780], [0.2, 0.2, 0.7, 0.7])
    made = scene(cube(material=pm.Material("step", flat)), body(SPHERE))
    plan = render(made, bands="box:6").record["effects"]["band_merging"]
    assert plan["why"] == "6 bands have 4 different spectra"


def test_smooth_code_changes_nothing_where_nothing_is_smooth():
    made = scene(*two())
    auto, full = render(made, passes=6), render(made, passes=6, effects="all")
    for name in ("radiance", "shading"):
        error = np.hypot(auto.standard_error(name), full.standard_error(name))
        assert (np.abs(auto.buffers[name] - full.buffers[name]) <= 6.0 * error + 1e-6).all()
    assert not full.caustics.any()
    assert not full.residual.any()
    assert "caustics" not in auto.buffers


JELLY = pm.Material("jelly", 0, ior=1.4, attenuation_color=0.5, attenuation_distance=1)


@pytest.mark.parametrize(
    ("material", "effect"), [(pm.Material.plastic(), "glossy"), (JELLY, "media")]
)
def test_auto_equals_all_where_matter_calls_for_it(material, effect):
    made = scene(PANEL, body(ball((0, 0.5, 0)), material))
    auto, full = render(made), render(made, effects="all")
    assert auto.record["effects"][effect]["on"]
    if effect == "media":
        np.testing.assert_array_equal(auto.radiance, full.radiance)
    for name in ("radiance", "direct", "indirect", "residual"):
        error = np.hypot(auto.standard_error(name), full.standard_error(name))
        assert (np.abs(auto.buffers[name] - full.buffers[name]) <= 6.0 * error + 1e-6).all()


def ball(center):
    return SPHERE.copy().apply_scale(0.3).apply_translation(center)


BALLS = scene(
    PANEL,
    body(ball((0, 0.5, 0)), pm.Material.glass()),
    body(ball((0.7, 0.4, 0)), pm.Material.polished(), "mirror"),
    lights=[SUN, pm.DomeLight(0.2)], camera=pm.Camera((0.3, 2, 3.0), (0, 0, 0), fov=40),
)  # fmt: skip


@cache
def balls_by(method):
    return render(BALLS, method=method)


@pytest.mark.filterwarnings("ignore:method path finds no caustics")
@pytest.mark.parametrize("method", ["photon", "path"])
@pytest.mark.parametrize(
    ("effect", "buffer"),
    [
        ("emission", "emission"),
        ("direct", "direct"),
        ("indirect", "indirect"),
        ("caustics", "caustics"),
        ("specular", "residual"),
        ("transmission", "residual"),
    ],
)
def test_what_is_called_for_is_missed_when_it_is_left_out(effect, buffer, method):
    if method == "path" and effect == "caustics":
        pytest.skip("no path hits the sun")
    whole = balls_by(method)
    part = render(BALLS, method=method, effects=[name for name in EFFECTS if name != effect])
    assert part.record["partial"]
    assert not whole.record["partial"]
    entry = part.record["effects"][effect]
    assert (entry["on"], entry["why"]) == (False, "left out on request")
    missing, there = (getattr(result, buffer).sum(dtype=float) for result in (part, whole))
    assert missing < 0.9 * there
    if effect in ("emission", "direct"):
        assert missing == 0.0


def test_without_an_environment_the_sky_is_dark():
    sky = pm.EnvironmentLight(np.ones((2, 4, 3)))
    made = scene(cube(), lights=[sky, SUN])
    whole, part = render(made), render(made, effects="emission,direct,indirect")
    assert whole.emission.any()
    assert not part.emission.any()


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        ("indirekt", "no effect 'indirekt'; did you mean 'indirect'"),
        ("auto,direct", "no effect 'auto'"),
        ("", "no effect ''"),
        (["direct", "shine"], "no effect 'shine'"),
    ],
)
def test_unknown_effects_are_refused(effects, message):
    with pytest.raises(InputError, match=message):
        parse_effects(effects)
