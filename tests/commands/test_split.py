"""The passes of one image, rendered in parts and merged."""

import numpy as np
import pytest
from helpers.marks import slow

import photonmap as pm
from photonmap.commands import main as cli
from photonmap.dataset.jobs import parts

ARGUMENTS = ["--size", "12x10", "--bands", "2", "--quiet"]


@pytest.fixture
def scene(tmp_path):
    pm.save_scene(pm.scenes.cornell_box(), tmp_path / "box.obj")
    return str(tmp_path / "box.obj")


def split(scene, output, *more):
    return cli.main(["split", scene, "--output", str(output), *ARGUMENTS, *more])


def assert_same(one, other):
    assert set(one.buffers) == set(other.buffers)
    for name, image in one.buffers.items():
        np.testing.assert_array_equal(image, other.buffers[name])
    for name, error in one.errors.items():
        np.testing.assert_array_equal(error, other.errors[name])


@pytest.fixture
def expected(scene):
    """What merging by hand gives."""
    options = {"size": (12, 10), "bands": 2}
    pairs = ((5, 2), (6, 2), (7, 3))
    return pm.merge(
        [pm.render(pm.load_scene(scene), seed=s, passes=n, **options) for s, n in pairs]
    )


@pytest.mark.parametrize("workers", ["1", *slow("2")])
def test_parts_are_merged(scene, tmp_path, expected, workers):
    if workers != "1":
        pytest.importorskip("distributed")
    output = tmp_path / "image.exr"
    more = ["--passes", "7", "--parts", "3", "--seed", "5", "--workers", workers]
    assert split(scene, output, *more) == 0
    made = pm.load_result(output)
    assert_same(made, expected)
    assert made.record["passes"] == 7
    assert made.record["arguments"]["seed"] == [5, 6, 7]
    assert sorted(path.name for path in tmp_path.glob("image*")) == [
        "image.exr", "image.json", "image.png"
    ]  # fmt: skip


def test_parts_that_are_there_are_kept(scene, tmp_path, monkeypatch, expected, capsys):
    output, folder = tmp_path / "image.exr", tmp_path / "image.parts"
    more = ["--passes", "7", "--parts", "3", "--seed", "5"]

    seeds = []
    render_part = parts.render_part

    def render(part):
        seeds.append(part.options.seed)
        if seeds == [5, 6, 7]:
            raise pm.InputError("the power went")
        render_part(part)

    monkeypatch.setattr(parts, "render_part", render)
    assert split(scene, output, *more) == 2
    assert "part-0002.exr: the power went; fix it, and continue" in capsys.readouterr().err
    assert not output.exists()
    stamps = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert len(stamps) == 6
    assert split(scene, output, *more) == 2
    assert "holds parts of an earlier run; add --resume" in capsys.readouterr().err
    assert stamps == {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert split(scene, output, *more, "--resume") == 0
    assert seeds == [5, 6, 7, 7]
    assert_same(pm.load_result(output), expected)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--parts", "2"], "give --passes"),
        (["--parts", "2", "--passes", "4", "--error", "0.1"], "neither --seconds nor --error"),
        (["--parts", "1", "--passes", "4"], "parts 1 must be from 2 to the number of passes, 4"),
        (["--parts", "5", "--passes", "4"], "parts 5 must be from 2"),
        (["--parts", "2", "--passes", "4", "--checkpoint"], "parts have no checkpoints"),
        (["--passes", "4"], "--parts"),
        (["--parts", "2", "--passes", "4", "--workers", "0"], "workers 0 must be"),
    ],
)
def test_bad_input_touches_nothing(scene, tmp_path, capsys, more, message):
    before = sorted(tmp_path.iterdir())
    assert split(scene, tmp_path / "image.exr", *more) == 2
    messages = capsys.readouterr().err.splitlines()
    assert len(messages) == 1
    assert message in messages[0]
    assert sorted(tmp_path.iterdir()) == before
