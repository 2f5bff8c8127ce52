"""What somebody tries first works, or is answered by a message that says what to do."""

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.commands.main import main
from photonmap.runtime.progress import STAGES

BOX = Path(pm.scenes.FOLDER) / "cornell_box.obj"
SMALL = {"passes": 1, "bands": 1, "photons": 100}
TRIANGLE = pm.Mesh(np.eye(3), [[0, 1, 2]])


@pytest.mark.parametrize("path", [str(BOX), BOX])
def test_a_file_in_place_of_a_scene(path):
    result = pm.render(path, size=6, **SMALL)
    assert result.size == (6, 6)
    np.testing.assert_array_equal(
        result.radiance, pm.render(pm.load_scene(BOX), size=(6, 6), **SMALL).radiance
    )


def test_one_mesh_and_one_light_in_place_of_lists():
    scene = pm.Scene(TRIANGLE, pm.PointLight((0, 0, 2), 1))
    assert (len(scene.meshes), len(scene.lights)) == (1, 1)
    assert pm.Scene((TRIANGLE, TRIANGLE)).meshes == [TRIANGLE, TRIANGLE]
    meshes = [TRIANGLE]
    assert pm.Scene(meshes).meshes is meshes


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (lambda: pm.Scene("room.obj"), "'room.obj' is not a list of photonmap.Mesh; .*load_scene"),
        (lambda: pm.Scene([trimesh.creation.box()]), "is not a mesh; .*from_trimesh"),
        (lambda: pm.Scene(TRIANGLE, "sun"), "'sun' is not a list of photonmap.Light"),
        (lambda: pm.render(TRIANGLE), r"<Mesh .*> is not a scene; .*Scene\(\[mesh\]\)"),
        (lambda: pm.render("lost.obj"), "lost.obj: "),
        (lambda: pm.render(BOX, size="big"), "size 'big' is not"),
        (lambda: pm.render(BOX, size=(1, 2, 3)), r"size \(1, 2, 3\) is not \(width, height\)"),
        (lambda: pm.render(BOX, size=12.5), "size 12.5 is not"),
    ],
)
def test_messages(attempt, message):
    with pytest.raises(pm.InputError, match=message):
        attempt()


def test_short_representations():
    box = pm.scenes.cornell_box()
    text = "<Scene 'cornell_box': 8 meshes (emitting: 1) of 36 triangles, 0 other lights, camera"
    assert repr(box).startswith(text)
    lamps = [pm.AreaLight((0, 1, 0), (0, 0, 0), radius=0.1), pm.PointLight((0, 1, 0))]
    text = "<Scene 'scene': 2 meshes (emitting: 1) of 63 triangles, 1 other lights, no camera>"
    assert repr(pm.Scene([TRIANGLE], lamps)) == text
    assert "1 meshes of 1 triangles, 0 lights" in repr(pm.Scene([TRIANGLE]))
    assert repr(TRIANGLE) == "<Mesh 'mesh': 1 triangles of 'grey'>"
    assert "6 more" not in repr(pm.Bands.gaussian(6))
    big = np.ones((64, 128, 3))
    for thing in (
        pm.EnvironmentLight(big),
        pm.PhotometricLight((0, 0, 0), np.ones((181, 5))),
        pm.Camera((0, 0, 1), (0, 0, 0), projection=pm.RayMap(np.ones((20, 20, 6)))),
        pm.Material("wall", pm.Texture.of(big), pm.emission("D65")),
        pm.Bands.gaussian(81),
        pm.emission("D65"),
    ):
        assert len(repr(thing)) < 500, thing


def test_warnings_point_at_the_line_that_called():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pm.render(pm.Scene(TRIANGLE), size=2, **SMALL)
    assert {Path(each.filename).name for each in caught} == {Path(__file__).name}


def test_progress_may_be_true(capsys, monkeypatch):
    pm.render(BOX, size=4, progress=True, **SMALL)
    lines = capsys.readouterr().err.splitlines()
    assert STAGES["render"] in lines
    assert any(line.startswith("pass 1, ") for line in lines)
    pm.render(BOX, size=4, progress=False, **SMALL)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    pm.render(BOX, size=4, progress=True, **SMALL)
    pm.render(BOX, size=4, progress=True, **SMALL)  # the first bar is gone


def test_the_plan_comes_before_the_passes(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stderr", sys.stdout)
    assert main([str(BOX), "--size", "4", "--passes", "1", "--photons", "100"]) == 0
    text = capfd.readouterr().out
    assert text.index("caustics       off  there is no mirror") < text.index("pass 1, ")


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("studdy", "there is no command 'studdy'; did you mean 'study'?"),
        ("datset", "did you mean 'dataset'?"),
        ("rendr", "there is no command 'rendr'; to render, name the scene alone (a scene is a"),
        ("render", "to render, name the scene alone (a scene is a file, as in room.obj)"),
    ],
)
def test_misspelt_commands(word, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([word, "x"]) == 2
    assert message in capsys.readouterr().err


def test_misspelt_options(capsys):
    assert main([str(BOX), "--pases", "3"]) == 2
    assert "there is no option --pases; did you mean '--passes'?" in capsys.readouterr().err
    assert main([str(BOX), "--zzzzzzzz"]) == 2
    assert "unrecognized arguments: --zzzzzzzz (see python -m" in capsys.readouterr().err


def test_options_are_checked_before_the_scene_is_read(tmp_path, capsys):
    (tmp_path / "broken.obj").write_text("garbage")
    assert main([str(tmp_path / "broken.obj"), "--effects", "direct,indirct"]) == 2
    assert "did you mean 'indirect'?" in capsys.readouterr().err


def test_help_begins_with_what_there_is(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    head = "\n".join(capsys.readouterr().out.splitlines()[:26])
    for wanted in ("dataset  Render a data set", "study    Sweep", ".gltf", ".stl", "--up z"):
        assert wanted in head
