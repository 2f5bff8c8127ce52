"""Stereo pairs, trajectories, the looks of splits, and the files of flow."""

import json

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs import flows
from photonmap.dataset.jobs.job_scene import make_scene
from photonmap.dataset.jobs.plan import CommonSettings, Job, plan_jobs
from photonmap.dataset.jobs.presets import load_preset
from photonmap.dataset.scenes import view_search
from photonmap.dataset.scenes.view_search import is_way_free
from photonmap.dataset.scenes.views import View
from photonmap.integrators.look import Onlooker

COMMON = CommonSettings((16, 12), "3", "0.5", inputs="0")
PRESET = """
scenes = ["jug"]
illuminations = ["white", "colored"]
[[view]]
name = "pair"
yaw = 12
baseline = 0.06
[[trajectory]]
name = "walk"
frames = 3
yaw = 15
[split.test]
size = [20, 16]
fov = 40
"""

PLAIN = PRESET.partition("[split")[0]


def write(folder, text):
    (folder / "preset.toml").write_text(text)
    return load_preset(str(folder / "preset.toml"))


def cameras_of(jobs):
    return {job.view.name: make_scene(job).camera for job in jobs}


def test_pairs_and_paths(tmp_path):
    """Cameras of a pair are parallel and as far apart as asked for; frames are evenly spaced on a
    free path, the same for every light."""
    jobs = plan_jobs(write(tmp_path, PLAIN.replace("frames = 3", "frames = 9")), [], COMMON)
    assert len(jobs) == 2 * (2 + 9)
    found = cameras_of(jobs[:11])
    assert list(found) == ["pair_left", "pair_right", *(f"walk-{i:04}" for i in range(9))]
    view_search._found.clear()
    assert cameras_of(jobs[11:]) == found
    left, right = found["pair_left"], found["pair_right"]
    np.testing.assert_allclose(
        np.subtract(left.origin, right.origin), np.subtract(left.target, right.target)
    )
    assert np.linalg.norm(np.subtract(left.origin, right.origin)) == pytest.approx(0.06)
    path = np.array([found[f"walk-{i:04}"].origin for i in range(9)])
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    assert lengths.max() < 1.1 * lengths.min()
    turns = (steps[1:] * steps[:-1]).sum(axis=1) / lengths[1:] / lengths[:-1]
    assert turns.min() > 0.75
    assert is_way_free(Onlooker(make_scene(jobs[0])), path)


def test_paths_in_rooms(tmp_path):
    """Through free space, and within the room: from each frame the next one can be seen."""
    preset = write(tmp_path, PLAIN.replace("jug", "kitchen").replace('"white", ', ""))
    jobs = plan_jobs(preset, [], COMMON, seed=1)
    scene = make_scene(jobs[-1])
    path = [np.array(camera.origin) for camera in cameras_of(jobs[2:]).values()]
    corners = np.concatenate([mesh.vertices for mesh in scene.meshes])
    assert all((place > corners.min(axis=0)).all() for place in path)
    assert all((place < corners.max(axis=0)).all() for place in path)
    assert is_way_free(Onlooker(scene), path)


def test_splits_have_their_own_looks(tmp_path):
    jobs = plan_jobs(write(tmp_path, PRESET), [], COMMON, count=40)
    for job in jobs:
        is_test = part_of(job.geometry) == "test"
        assert job.common.size == ((20, 16) if is_test else (16, 12))
        assert job.view.fov == (40 if is_test else None)
    assert {job.common.size for job in jobs} == {(16, 12), (20, 16)}
    seen = next(job for job in jobs if job.view.fov)
    assert make_scene(seen).camera.fov == 40


def test_descriptions_of_views(tmp_path):
    """They lead back to the job; of a plain view, what is at its default is left out."""
    for job in plan_jobs(write(tmp_path, PRESET), [], COMMON, count=12):
        assert Job.from_description(json.loads(json.dumps(job.describe()))) == job
    plain = View("left", 10.0).describe()
    assert plain == {"name": "left", "yaw": 10.0, "pitch": 0.0, "distance": 1.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[view]]\nname = "a"\nbaseline = -1', "baseline -1 must be 0 or more"),
        ('[[view]]\nname = "a"\nfov = 180', "fov 180 must be between"),
        ('[[trajectory]]\nname = "a"', "preset.toml:2: trajectory 'a' needs frames"),
        ('[[trajectory]]\nname = "a"\nframes = 0', "needs frames, 1 to"),
        (
            '[[trajectory]]\nname = "a"\nframes = 2\nsped = 1',
            "key of trajectory 'sped' is not known",
        ),
        (
            '[[view]]\nname = "a_left"\n[[view]]\nname = "a"\nbaseline = 1',
            "two views are called 'a_left'",
        ),
        ("[split.tests]\nfov = 3", "there is no split 'tests'"),
        ("[split.test]\nsize = 0", "split test: size 0x0 must be"),
        ("[split.test]\nfov = 200", "fov 200 must be between"),
        ("[split.test]\ncount = 2", "key 'count' is not known"),
        ("[split]\ntest = 3", "split.test is not a section"),
    ],
)
def test_bad_presets(tmp_path, text, message):
    with pytest.raises(pm.InputError, match=r"preset\.toml") as caught:
        write(tmp_path, f'scenes = ["jug"]\n{text}\n')
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_split_without_scenes_is_named(tmp_path):
    with pytest.warns(pm.SceneWarning, match=r"\[split.test\] is not used, .* 1 scenes"):
        plan_jobs(write(tmp_path, PRESET), [], COMMON)


def test_a_baseline_that_does_not_fit(tmp_path):
    [job, _] = plan_jobs(
        write(
            tmp_path,
            'scenes = ["kitchen"]\nilluminations = ["white"]\n[[view]]\nname = "a"\nbaseline = 60',
        ),
        [],
        COMMON,
        seed=1,
    )
    with pytest.raises(pm.InputError, match="choose another yaw, pitch, distance or baseline"):
        make_scene(job)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("views")
    text = PRESET.replace('["white", "colored"]', '["white"]').replace(
        "[split.test]", "[split.train]"
    )
    text = text.replace("frames = 3", "frames = 2")
    (folder / "preset.toml").write_text(text)
    arguments = ["--size", "24x18", "--error", "0.5", "--bands", "3", "--format", "exr", "--quiet"]
    command = ["dataset", str(folder / "OUT"), "--preset", str(folder / "preset.toml")]
    assert main([*command, *arguments]) == 0
    return folder / "OUT"


def test_the_command_writes_flow(made, capsys):
    """For pairs and neighbours, both ways; comparing surfaces says nearly the same."""
    assert main(["dataset", "flow", str(made)]) == 0
    assert "4 pairs of views" in capsys.readouterr().out
    names = {path.name.removesuffix(".npz") for path in (made / "flow").iterdir()}
    assert {"jug-0-pair_left-to-pair_right", "jug-0-walk-0001-to-walk-0000"} < names
    by_view = {image.entry["job"]["view"]["name"]: image for image in dataset.open_dataset(made)}
    for name in names:
        first, second = name.removeprefix("jug-0-").split("-to-")
        flow = by_view[first].flow_to(by_view[second])
        with np.load(made / "flow" / f"{name}.npz") as file:
            np.testing.assert_array_equal(file["flow"], flow.flow)
            assert (file["visible"] == flow.visible).mean() > 0.9
            assert file["visible"].mean() > 0.3
            assert ("disparity" in file) == name.startswith("jug-0-pair")
    assert main(["dataset", "verify", str(made), "--sample", "0", "--quiet"]) == 0
    assert by_view["pair_left"].entry["size"] == [20, 16]


def test_flow_needs_pairs(tmp_path, made, capsys):
    assert main(["dataset", "flow", str(tmp_path)]) == 2
    assert "does not hold a data set" in capsys.readouterr().err
    images = dataset.open_dataset(made)
    [alone] = [image for image in images if image.entry["job"]["view"]["name"] == "walk-0000"]
    assert not [*flows.find_pairs(dataset.Dataset(made, images.head, [alone.entry]))]


def test_dry_run_says_the_sizes(tmp_path, capsys):
    write(tmp_path, PRESET)
    command = ["dataset", str(tmp_path / "OUT"), "--preset", str(tmp_path / "preset.toml")]
    assert main([*command, "--dry-run", "--count", "40", "--size", "16x12"]) == 0
    assert "400 images of 16x12 and 20x16" in capsys.readouterr().out


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_images_that_take_too_long_are_marked(tmp_path, capsys):
    (tmp_path / "one.toml").write_text('scenes = ["jug"]\nilluminations = ["white"]\n')
    command = ["dataset", str(tmp_path / "OUT"), "--preset", str(tmp_path / "one.toml")]
    command += ["--size", "24x18", "--error", "1e-6", "--bands", "3", "--format", "exr"]
    assert main([*command, "--time-limit", "0.1"]) == 0
    said = capsys.readouterr().err
    assert "before the error 1e-06 was reached" in said
    assert "1 of 1 images did not reach their error" in said
    [image] = dataset.open_dataset(tmp_path / "OUT")
    assert not image.entry["reached"]
    assert main(["dataset", "verify", str(tmp_path / "OUT"), "--sample", "0"]) == 1
    assert "the error 1e-06 was not reached" in capsys.readouterr().err
