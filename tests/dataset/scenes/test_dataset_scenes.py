"""Scenes of a data set: reproducible, resting, without collisions, well framed, sanely lit."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.generated import lit, unlit
from helpers.marks import slow

import photonmap as pm
from photonmap.dataset.jobs.presets import PRESETS
from photonmap.dataset.models.arrangements import in_row, scatter
from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import (
    CONTACT_TOLERANCE,
    SceneObject,
    Support,
    multi_part,
    overlap,
)
from photonmap.dataset.models.shapes import box
from photonmap.dataset.publication.metadata import CATEGORIES, kind_of
from photonmap.dataset.scenes.build import PAPER_SCENES, SCENES, build_scene
from photonmap.dataset.scenes.exposure import LEVEL
from photonmap.dataset.scenes.illumination import (
    ILLUMINATIONS,
    Illumination,
)
from photonmap.dataset.scenes.outdoors import OUTDOORS
from photonmap.dataset.scenes.rooms.catalogue import FURTHER_KINDS, ROOMS
from photonmap.dataset.scenes.single_objects import OBJECTS
from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import shipped_set

HUNG = (
    "picture",
    "clock",
    "mirror",
    "pendant lamp",
    "ceiling lamp",
    "ceiling spot",
    "curtain",
    "wall shelf",
    "blackboard",
    "tool board",
    "towel rail",
    "coat rack",
    "wall lantern",
)
DEEPEST_WINDOW = 0.2
SEEDS = (0, *slow(1))
each_scene = pytest.mark.parametrize("name", [*PAPER_SCENES, *OUTDOORS, *slow(*FURTHER_KINDS)])


def random(seed=0):
    return np.random.Generator(np.random.PCG64(seed))


def objects_of(made):
    wanted = set(made.object_names)
    return [obj for obj in made.named_objects if obj.name in wanted]


def equal(first, second):
    return len(first.meshes) == len(second.meshes) and all(
        a.name == b.name
        and np.array_equal(a.vertices, b.vertices)
        and np.array_equal(a.faces, b.faces)
        and np.array_equal(a.normals, b.normals)
        for a, b in zip(first.meshes, second.meshes, strict=True)
    )


def test_presets():
    assert len(OBJECTS) == 8
    assert len(ROOMS) == 14
    assert PRESETS["icip2013"].scenes == SCENES[:17]
    assert PRESETS["varied"].scenes == SCENES
    small = PRESETS["small"].scenes
    assert [name in ROOMS for name in small] == [False, False, True, True]


@pytest.mark.parametrize("name", ["cushion", "kitchen"])
def test_a_seed_is_a_scene(name):
    first, again = lit(name, 1), build_scene(name, 1)
    assert equal(first, again)
    assert first.camera == again.camera
    assert [m.material for m in first.meshes] == [m.material for m in again.meshes]
    assert not equal(first, lit(name, 0))


@pytest.mark.parametrize("name", OBJECTS)
def test_objects_have_edges_of_reflectance(name):
    made = unlit(name)
    parts = next(obj for obj in made.objects if obj.name not in made.backdrop).parts
    assert len({part.material.name for part in parts}) > 1


def test_sections_of_a_ribbon_are_no_slivers():
    for seed in range(4):
        ribbon = next(o for o in unlit("ribbon", seed).objects if o.name == "ribbon")
        first, second = (part.shape.area for part in ribbon.parts)
        assert first == pytest.approx(second, rel=0.2)
        for part in ribbon.parts:
            around = part.shape.faces.reshape(-1, 64, 3)
            for ring in around:
                assert len(np.unique(ring)) == 64, "every section runs all around the tube"


def test_light_changes_the_lamps_alone():
    white, mixed = lit("bedroom"), lit("bedroom", 0, "two_mixed")
    for a, b in zip(white.meshes, mixed.meshes, strict=True):
        np.testing.assert_array_equal(a.vertices, b.vertices)
        if a.material != b.material:
            assert {a.material.name, b.material.name} & {"window pane", "lamp", "lamp 2"}


@pytest.mark.parametrize("seed", SEEDS)
@each_scene
def test_all_lie_within_the_room_and_apart(name, seed):
    made = unlit(name, seed)
    objects = objects_of(made)
    every = np.concatenate([obj.boxes for obj in objects])
    ends = np.cumsum([len(obj.boxes) for obj in objects])
    for obj, end in zip(objects, ends, strict=True):
        assert not overlap(obj.boxes, every[end:]), (
            obj.name,
            [o.name for o in objects if o is not obj and overlap(obj.boxes, o.boxes)],
        )
    if name in ROOMS:
        low, high = next(t for t in made.objects if t.name == "walls").bounds
        for obj in made.named_objects:
            slack = DEEPEST_WINDOW if obj.name.startswith("window") else CONTACT_TOLERANCE
            assert (obj.bounds[0] >= low - slack).all(), obj.name
            assert (obj.bounds[1] <= high + slack).all(), obj.name


def rests(obj, others, walls):
    """Whether a thing stands on the floor, on another one's part, or touches a wall or ceiling."""
    low, high = obj.bounds
    if obj.name.startswith(HUNG):
        return np.isclose(np.stack([low, high]), walls, rtol=0.0, atol=0.09).any()
    if abs(low[1]) < 1e-9:
        return True
    tops = np.concatenate([other.boxes for other in others if other is not obj])
    beneath = np.abs(tops[:, 1, 1] - low[1]) < 1e-9
    beneath &= (tops[:, 0, ::2] < high[::2]).all(axis=1) & (tops[:, 1, ::2] > low[::2]).all(axis=1)
    return beneath.any()


@pytest.mark.parametrize("seed", SEEDS)
@each_scene
def test_all_rest_on_something(name, seed):
    made = unlit(name, seed)
    shell = next(t for t in made.objects if t.name in ("walls", "backdrop"))
    objects = objects_of(made)
    for obj in objects:
        assert rests(obj, objects, shell.bounds), obj.name


@pytest.mark.parametrize("seed", SEEDS)
@each_scene
def test_the_camera_is_free(name, seed):
    made = unlit(name, seed)
    origin, target = np.array(made.camera.origin), np.array(made.camera.target)
    view = (target - origin) / np.linalg.norm(target - origin)
    near = origin + view * np.linspace(0.0, 0.4, 9)[:, None]
    for obj in made.named_objects:
        if obj.name in ("walls", "floor", "ground", "ceiling", "skirting", "backdrop"):
            continue
        for low, high in obj.boxes:
            assert not ((near > low) & (near < high)).all(axis=1).any(), obj.name
    if name in ROOMS:
        low, high = next(t for t in made.objects if t.name == "walls").bounds
        assert (origin > low + 0.1).all()
        assert (origin < high - 0.1).all()
        assert 1.2 < origin[1] < 1.8


@each_scene
def test_surfaces_are_chips(name):
    known = set(shipped_set().names)
    parts = [part for obj in unlit(name).objects for part in obj.parts]
    for material in {id(p.material): p.material for p in parts if not p.light_group}.values():
        assert material.name in known
        assert isinstance(material.reflectance, Spectrum)
        assert (material.mirror, material.ior, material.alpha) == (0.0, None, 1.0)
    assert 10_000 < sum(len(part.shape.faces) for part in parts) < 300_000


@each_scene
def test_all_objects_have_a_category(name):
    assert {kind_of(obj.name) for obj in unlit(name).named_objects} <= {*CATEGORIES}


def test_mixed_materials():
    plain, mixed = unlit("pottery"), unlit("pottery", 0, "mixed")
    materials = {p.material.name: p.material for obj in mixed.objects for p in obj.parts}
    assert materials["glass"].ior == 1.5
    assert any(name.startswith("glazed") for name in materials)
    assert [obj.name for obj in plain.named_objects] == [obj.name for obj in mixed.named_objects]
    for a, b in zip(plain.objects, mixed.objects, strict=True):
        np.testing.assert_array_equal(a.boxes, b.boxes)


@each_scene
def test_renders_with_sane_numbers(name):
    made = unlit(name)
    scene = lit(name)
    # A large scene's radiosity cache takes longer than a few paths.
    method = "photon" if name in OBJECTS else "path"
    result = pm.render(scene, bands=3, size=(32, 24), passes=2, method=method)
    assert result.record["warnings"] == []
    for buffer in ("radiance", "direct", "indirect", "shading", "reflectance", "depth"):
        assert np.isfinite(result.buffers[buffer]).all()
    assert (result.coverage == 1.0).all() or name in OUTDOORS
    ids = {name: i for i, name in enumerate(dict.fromkeys(m.name for m in scene.meshes), 1)}
    seen = np.isin(result.object_id, [ids[name] for name in made.object_names]).mean()
    assert 0.1 < seen < 0.6
    share = result.direct.sum() / (result.direct + result.indirect).sum()
    low, high = (0.8, 0.98) if name in OBJECTS else (0.4, 0.95)
    assert low < share < high
    plain = (result.coverage == 1.0) & ~result.emission.any(axis=-1)
    irradiance = np.pi * result.shading[plain].mean(axis=-1)
    assert 0.8 * LEVEL < np.median(irradiance) < 1.5 * LEVEL


@pytest.mark.filterwarnings("ignore:luminance by these bands")
@pytest.mark.parametrize(
    ("name", "kind"), [*(("jug", kind) for kind in ILLUMINATIONS), ("bedroom", "two_mixed")]
)
def test_two_lights_are_two_groups(name, kind):
    scene = lit(name, 0, kind)
    result = pm.render(scene, bands=3, size=(16, 12), passes=2, per_light=True)
    groups = result.record["light_groups"]
    assert len(groups) == 1 + kind.startswith("two")
    for group in groups:
        assert result.per_light[group]["direct"].sum() > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("vaze",), "there is no scene 'vaze'; did you mean 'vase'?"),
        (("vase", -1), "seed -1 must be a whole number from 0 to 9223372036854775807"),
        (("vase", 0.5), "seed 0.5 must be a whole number"),
        (("vase", 0, "wite"), "there is no illumination 'wite'; did you mean 'white'?"),
        (("vase", 0, "white", "shiny"), "must be one of 'lambertian', 'mixed', "),
        (("vase", 0, Illumination("x", ("D66",))), "did you mean"),
        (("vase", 0, Illumination("x", ("0.5",))), "'0.5' is not a spectrum of light"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=r"^[^\n]+$") as caught:
        build_scene(*arguments)
    assert message in str(caught.value)


def cube(size):
    return lambda _: multi_part("cube", [box(size, size, size)], [Material()])


def test_scattered_things_rest_apart():
    level = Support((-0.5, 0.5), (-0.2, 0.2), 0.7, 0.3)
    placed = scatter(Draw(random()), level, [cube(0.1)] * 12 + [cube(0.35)])
    assert 3 <= len(placed) <= 12
    for index, obj in enumerate(placed):
        assert obj.bounds[0, 1] == pytest.approx(0.7, abs=1e-12)
        assert (obj.bounds[0, ::2] >= (-0.5, -0.2)).all()
        assert (obj.bounds[1, ::2] <= (0.5, 0.2)).all()
        for other in placed[index + 1 :]:
            assert not overlap(obj.boxes, other.boxes)


def test_a_row_ends_with_its_level():
    level = Support((0.0, 1.0), (0.0, 0.2), 0.4)
    row = in_row(Draw(random()), level, [cube(0.1)] * 20, (0.01, 0.02), front=True)
    assert 8 <= len(row) <= 9
    assert max(obj.bounds[1, 0] for obj in row) <= 1.0
    assert all(obj.bounds[1, 2] == pytest.approx(0.2) for obj in row)
    assert not any(overlap(a.boxes, b.boxes) for a, b in pairwise(row))


def test_boxes_that_touch_do_not_overlap():
    first = cube(1.0)(None)
    assert not overlap(first.boxes, first.moved((1.0, 0.0, 0.0)).boxes)
    assert overlap(first.boxes, first.moved((0.99, 0.0, 0.0)).boxes)
    assert isinstance(first, SceneObject)
