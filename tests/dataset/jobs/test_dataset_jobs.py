"""The plan of a data set: presets, jobs, their names, and what is refused."""

import dataclasses
import json
from dataclasses import replace

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.files.manifest import as_line
from photonmap.dataset.jobs.job_scene import describe_inputs, make_scene, read_user_scenes
from photonmap.dataset.jobs.plan import CommonSettings, Job, plan_jobs
from photonmap.dataset.jobs.presets import load_preset, with_illuminations
from photonmap.dataset.scenes.illumination import ILLUMINATIONS, Illumination
from photonmap.dataset.scenes.random_lights import RandomLights
from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError, SceneWarning

COMMON = CommonSettings((16, 12), "3", "0.5", inputs="0")
CAMERA = pm.Camera((0.0, 1.0, 2.0), (0.0, 0.0, 0.0))


def write(folder, text, name="preset.toml"):
    (folder / name).write_text(text)
    return str(folder / name)


def own_scene(folder, name="room"):
    """Save a scene of the user's: the Cornell box, which has one lamp."""
    pm.save_scene(pm.scenes.cornell_box(), folder / f"{name}.obj")
    return f"{name}.obj"


@pytest.mark.parametrize(("name", "images"), [("icip2013", 68), ("small", 16)])
def test_presets_have_their_images(name, images):
    jobs = plan_jobs(load_preset(name), [], COMMON)
    assert len(jobs) == images
    assert {job.illumination for job in jobs} == set(ILLUMINATIONS)
    assert len({job.name for job in jobs}) == images


def test_count_repeats_with_further_seeds():
    once = plan_jobs(load_preset("small"), [], COMMON, seed=4)
    thrice = plan_jobs(load_preset("small"), [], COMMON, seed=4, count=3)
    assert thrice[: len(once)] == once
    assert [job.seed for job in thrice[:: len(once)]] == [4, 5, 6]
    assert len({job.geometry for job in thrice}) == 12


def test_a_name_says_what_decides_the_arrays():
    job = plan_jobs(load_preset("small"), [], COMMON)[0]
    assert Job.from_description(json.loads(json.dumps(job.describe()))) == job
    assert job.name.startswith("jug-0-white-")
    for changes in ({"seed": 1}, {"colors": ("A",)}, {"view": View("left", 10.0)}):
        assert dataclasses.replace(job, **changes).digest != job.digest
    for changes in ({"size": (12, 16)}, {"bands": "6"}, {"error": "0.1"}, {"inputs": "1"}):
        common = dataclasses.replace(COMMON, **changes)
        assert dataclasses.replace(job, common=common).digest != job.digest
    elsewhere = dataclasses.replace(COMMON, munsell="/elsewhere/chips")
    assert dataclasses.replace(job, common=elsewhere).digest == job.digest


def test_what_names_stand_for_is_hashed(tmp_path):
    curves = tmp_path / "camera.csv"
    digests = set()
    for peak in (1.0, 0.5):
        rows = "\n".join(f"{nm},1,{(nm - 390 * peak) / 700}" for nm in range(400, 701, 10))
        curves.write_text(f"nm,a,b\n{rows}\n")
        common = dataclasses.replace(COMMON, bands=str(curves))
        digests.add(describe_inputs(common).inputs)
    digests.add(describe_inputs(COMMON).inputs)
    (tmp_path / "lights").mkdir()
    (tmp_path / "lights" / "one.txt").write_text("1 2")
    common = dataclasses.replace(COMMON, illuminants=str(tmp_path / "lights"))
    digests.add(describe_inputs(common).inputs)
    assert len(digests) == 4


def test_a_preset_of_ones_own(tmp_path):
    (tmp_path / "rooms").mkdir()
    own_scene(tmp_path / "rooms")
    path = write(
        tmp_path,
        """
        scenes = ["vase"]
        files = ["rooms"]
        illuminations = ["white"]
        materials = "mixed"
        recolor = true
        [[illumination]]
        name = "evening"
        colors = ["planck:2300"]
        [[view]]
        name = "front"
        [[view]]
        name = "left"
        yaw = 20
        pitch = -5.0
        distance = 1.1
        """,
    )
    preset = load_preset(path)
    assert preset.materials == "mixed"
    common = dataclasses.replace(COMMON, recolor=preset.recolor)
    jobs = plan_jobs(preset, read_user_scenes(preset.files)[0], common)
    assert [(job.stem, job.illumination, job.view.name) for job in jobs] == [
        (scene, light, view)
        for scene in ("vase", "room")
        for light in ("white", "evening")
        for view in ("front", "left")
    ]
    assert jobs[-1].view == View("left", 20, -5.0, 1.1)
    front, left = make_scene(jobs[-2]), make_scene(jobs[-1])
    assert front.camera == pm.scenes.cornell_box().camera
    assert left.camera != front.camera
    walls = {m.name: m.material.reflectance for m in front.meshes if m.name != "light"}
    before = {m.name: m.material.reflectance for m in pm.scenes.cornell_box().meshes}
    assert all(walls[name] != before[name] for name in walls)


def test_a_scene_that_changed_meanwhile_is_refused(tmp_path):
    preset = load_preset(write(tmp_path, f'files = ["{own_scene(tmp_path)}"]'))
    with pytest.warns(SceneWarning, match=r"fewer light groups \(1\) than illumination 'two_"):
        job = plan_jobs(preset, read_user_scenes(preset.files)[0], COMMON)[0]
    make_scene(job)
    with pytest.raises(InputError, match="has changed since the data set was begun"):
        make_scene(dataclasses.replace(job, content="0"))


def test_views_turn_around_the_target():
    origin = np.array(CAMERA.origin)
    assert View("same").move(CAMERA) is CAMERA
    quarter = View("side", yaw=90.0).move(CAMERA)
    np.testing.assert_allclose(quarter.origin, (2.0, 1.0, 0.0), atol=1e-12)
    far = View("far", distance=2.0).move(CAMERA)
    np.testing.assert_allclose(far.origin, 2.0 * origin)
    level = View("low", pitch=-np.degrees(np.arctan2(1.0, 2.0))).move(CAMERA)
    np.testing.assert_allclose(level.origin, (0.0, 0.0, np.linalg.norm(origin)), atol=1e-12)
    with pytest.raises(InputError, match="straight up or down"):
        View("top", pitch=80.0).move(CAMERA)


DUSK = 'scenes = ["vase"]\n[[illumination]]\nname = "dusk"\n'


def test_presets_may_draw_lights(tmp_path):
    text = (
        f"{DUSK}colors = ['A', 'D65']\nshares = [0.2, 0.8]\n"
        "[[illumination]]\nname = 'any'\nlights = [2, 3]"
    )
    preset = load_preset(write(tmp_path, text))
    assert preset.illuminations == (
        Illumination("dusk", ("A", "D65"), (0.2, 0.8)),
        RandomLights("any", 2, 3),
    )
    jobs = plan_jobs(preset, [], COMMON, count=30)
    drawn = [job for job in jobs if job.illumination == "any"]
    assert {len(job.colors) for job in drawn} == {2, 3}
    assert len({job.shares for job in drawn}) == len(drawn)
    assert [Job.from_description(job.describe()) for job in jobs] == jobs
    fixed = next(job for job in jobs if job.illumination == "dusk")
    assert fixed.digest != replace(fixed, shares=(0.5, 0.5)).digest


def test_lightness_and_scale_are_read_and_checked(tmp_path):
    preset = load_preset(write(tmp_path, 'scenes = ["study"]\nlightness = 0.3\nscale = 2'))
    assert (preset.lightness, preset.scale) == (0.3, 2.0)
    for changes in ({"lightness": 1.5}, {"scale": 9.0}):
        with pytest.raises(InputError, match="must be"):
            replace(COMMON, **changes)


def test_illuminations_of_a_preset_are_replaced():
    assert with_illuminations(load_preset("small"), []) == load_preset("small")
    assert with_illuminations(load_preset("small"), ["random"]).illuminations == ("random",)
    with pytest.raises(InputError, match="did you mean 'white'"):
        with_illuminations(load_preset("small"), ["wite"])


def test_illuminations_of_a_preset_can_be_chosen(tmp_path):
    preset = load_preset(write(tmp_path, f"{DUSK}colors = ['A', 'D65']"))
    assert with_illuminations(preset, ["dusk"]).illuminations == preset.illuminations
    assert with_illuminations(preset, ["white", "dusk"]).illuminations[0] == "white"
    with pytest.raises(InputError, match="did you mean 'dusk'"):
        with_illuminations(preset, ["dosk"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scenes = ["vaze"]', "preset.toml:1: there is no scene 'vaze'; did you mean 'vase'?"),
        ('scenes = ["vase"]\nilluminations = ["wite"]', "preset.toml:2: there is no illumination"),
        ('scenes = "vase"', "is not a list of names"),
        ("", "has no scene"),
        ('files = ["nowhere"]', "there is no file or folder"),
        ('scenes = ["vase"]\nscene = 1', "key 'scene' is not known; did you mean 'scenes'?"),
        ('scenes = ["vase"]\nmaterials = "shiny"', "must be one of"),
        ('scenes = ["vase"]\nrecolor = 1', "must be true or false"),
        ('scenes = ["vase"]\nview = 3', "is not a list of sections; write [[view]]"),
        ('scenes = ["vase"]\n[[view]]\nyaw = 3', "needs a unique name"),
        ('scenes = ["vase"]\n[[view]]\nname = "a/b"', "needs a unique name"),
        (
            'scenes = ["vase"]\n[[view]]\nname = "a"\ndistance = 0',
            "preset.toml:2: view 'a': distance 0 must be above 0",
        ),
        ('scenes = ["vase"]\n[[view]]\nname = "a"\nyaw = "x"', "must be finite numbers"),
        ('scenes = ["vase"]\n[[illumination]]\nname = "a"', "'a' needs colors"),
        ('scenes = ["vase"]\n[[illumination]]\nname = "a"\ncolors = []', "has the colours ()"),
        (
            "illuminations = ['white']\n" + DUSK.replace("dusk", "white") + "colors = ['A']",
            "two illuminations are called 'white'; choose another name",
        ),
        ('scenes = ["vase"]\nscale = "large"', "scale 'large' is not a number"),
        ('scenes = ["vase"]\nlightness = 1.5', "toml:2: lightness 1.5 must be between 0 and 1"),
        (f"{DUSK}colors = ['A', 'D66']", "preset.toml:4: there is no light 'D66'; did you mean"),
        (f"{DUSK}colors = ['A', 'D65']\nshares = [1]", "preset.toml:5: illumination 'dusk' has 2"),
        (f"{DUSK}colors = ['A', 'D65']\nshares = 0.5", "shares 0.5 is not a list"),
        (f"{DUSK}lights = [2, 9]", "give two numbers from 1 to 4, the lower one first"),
        (f"{DUSK}lights = [2]", "'dusk' needs colors, as in"),
        (f"{DUSK}lights = [1, 2]\ncolors = ['A']", "or the number of lights to draw"),
    ],
)
def test_presets_that_cannot_be(tmp_path, text, message):
    with pytest.raises(InputError, match=r"^[^\n]+$") as caught:
        load_preset(write(tmp_path, text))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("seed", "count", "message"),
    [
        (0, 0, "count 0 is out of range: the preset has 16 images per seed; choose 1 to 62500"),
        (0, 10**9, "count 1000000000 is out of range"),
        (-1, 1, "seed -1 must be from 0"),
        (2**63 - 1, 2, "must be from 0 to 9223372036854775806"),
    ],
)
def test_counts_and_seeds_out_of_range(seed, count, message):
    with pytest.raises(InputError, match=message):
        plan_jobs(load_preset("small"), [], COMMON, seed, count)


def test_lights_and_names_are_checked(tmp_path):
    text = 'scenes = ["vase"]\n[[illumination]]\nname = "a"\ncolors = ["0.5"]'
    with pytest.raises(InputError, match="is not a spectrum of light"):
        load_preset(write(tmp_path, text))
    twice = load_preset(write(tmp_path, 'scenes = ["vase", "vase"]'))
    with pytest.raises(InputError, match="would be rendered twice"):
        plan_jobs(twice, [], COMMON)
    with pytest.raises(InputError, match="did you mean 'small'"):
        load_preset("smal")
    with pytest.raises(InputError, match="no such file"):
        load_preset(str(tmp_path / "none.toml"))


def test_new_settings_leave_the_names_of_images_as_they_were():
    """As of before shares, lightness and scale could be asked for."""
    common = CommonSettings((640, 480), "6", "0.02", inputs="703203ffbf106cfd")
    assert Job("vase", 0, "white", ("D65",), View(), common).name == "vase-0-white-4858ceded9"
    for changed in ({"lightness": 0.5}, {"scale": 1.2}):
        other = dataclasses.replace(common, **changed)
        assert Job("vase", 0, "white", ("D65",), View(), other).name != "vase-0-white-4858ceded9"


def test_a_scene_that_cannot_be_read_is_named_once(tmp_path):
    """Also where its materials or their images are at fault; and so is its folder."""
    folder = tmp_path / "scenes of mine"
    folder.mkdir()
    pm.save_scene(pm.scenes.cornell_box(), folder / "room.obj")
    with (folder / "room.mtl").open("a") as file:
        file.write("map_Kd wood.png\n")
    (folder / "broken.obj").write_text("v 0 0\nf 1 2 3\n")
    _, faults = read_user_scenes([str(folder / name) for name in ("room.obj", "broken.obj")])
    room, broken = (as_line(*fault) for fault in faults.items())
    assert room.startswith(f"{folder}/room.obj: room.mtl:")
    assert ": map_Kd: wood.png: cannot be read (" in room
    assert broken.startswith(f"{folder}/broken.obj:1: ")
    assert [line.count("scenes of mine") for line in (room, broken)] == [1, 1]


def test_reflectances_unknown_in_some_band_are_named_before_a_render(tmp_path):
    box = pm.scenes.cornell_box()
    wall = replace(box.meshes[1].material, reflectance=pm.Spectrum([400, 700], [0.1, 0.5]))
    meshes = [box.meshes[0], replace(box.meshes[1], material=wall), *box.meshes[2:]]
    path = str(tmp_path / "room.obj")
    pm.save_scene(replace(box, meshes=meshes), path)
    assert not read_user_scenes([path], pm.Bands.gaussian(6))[1]
    (fault,) = read_user_scenes([path], pm.Bands.parse("300:780:20"))[1].values()
    assert "covers 400-700 nm, but 300-780 nm is needed" in fault
