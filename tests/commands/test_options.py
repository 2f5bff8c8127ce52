"""One list of options: the command line, `render`, records, study, data sets and docs follow it."""

import ast
import inspect
import re
import runpy
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import COMMANDS, main, parser_of
from photonmap.dataset.jobs.plan import CommonSettings
from photonmap.errors import InputError, SceneWarning
from photonmap.io.scene_source import SceneSource
from photonmap.runtime.options import list_options, option, taking_keywords_of
from photonmap.settings import DATASET, OPTIONS, RENDER, STUDY, Options, Settings, taken_by
from photonmap.study.measure import Settings as StudySettings

ROOT = Path(__file__).parents[2]


def test_signature_of_render():
    """Names and defaults are a promise to users: an option may be added, none may change."""
    scene, *keywords = inspect.signature(pm.render).parameters.values()
    assert scene.name == "scene"
    assert {p.kind for p in keywords} == {inspect.Parameter.KEYWORD_ONLY}
    found = {p.name: p.default for p in keywords}
    assert found == {name: each.default for name, each in OPTIONS.items()}
    promised = {
        "bands": 6, "size": (512, 512), "pixel": "box", "passes": None, "seconds": None,
        "error": None, "photons": None, "seed": 0, "threads": None, "method": "photon",
        "effects": "auto", "per_light": False, "adaptive": True, "buffers": None, "memory": None,
        "checkpoint": None, "resume": False, "progress": None,
    }  # fmt: skip
    assert found.items() >= promised.items()
    assert [name for name in found if name in promised] == list(promised)
    assert all(p.annotation is not inspect.Parameter.empty for p in keywords)
    for name, each in OPTIONS.items():
        assert f" {name} : {each.help}" in " ".join(pm.render.__doc__.split())


def test_unknown_keywords_are_refused():
    with pytest.raises(TypeError, match="unexpected keyword argument 'bnds'"):
        pm.render(pm.scenes.cornell_box(), bnds=3)
    with pytest.raises(TypeError, match="missing a required argument: 'scene'"):
        pm.render(bands=3)


def test_flags_give_the_defaults_of_render():
    options = parser_of("render").parse_args(["box.obj"])
    for name in taken_by(RENDER):
        assert getattr(options, name) == OPTIONS[name].default
    given = [
        "--size",
        "64x32",
        "--no-adaptive",
        "--per-light",
        "--memory",
        "1k",
        "--buffers",
        "a,b",
    ]
    options = parser_of("render").parse_args(["box.obj", *given, "--checkpoint"])
    assert options.size == (64, 32)
    assert (options.adaptive, options.per_light, options.memory) == (False, True, 1024.0)
    assert (options.buffers, options.checkpoint) == (["a", "b"], "")


@pytest.mark.parametrize("command", ["render", *COMMANDS])
def test_every_option_has_a_help_text(command):
    for action in parser_of(command)._actions:
        assert action.help
        assert not action.help.endswith(".")
        assert not action.help[0].isupper() or action.dest in ("scene", "words")


def test_study_and_data_sets_take_what_the_list_says():
    """Their own records of options have the names of a render's."""
    assert {each.name for each in fields(StudySettings)} <= set(OPTIONS)
    assert set(taken_by(DATASET)) <= {each.name for each in fields(CommonSettings)}
    for command, arguments in ((STUDY, ["box.obj"]), (DATASET, ["folder"])):
        options = vars(parser_of(command).parse_args(arguments))
        assert set(taken_by(command)) <= set(options)


def test_what_decides_the_arrays_is_recorded():
    chosen = Options(passes=3, size=(8, 4), effects=["indirect", "direct"], seed=np.int64(7))
    checked = Settings.of(chosen)
    assert checked.deciding == {
        "pixel": "box", "photons": 16384, "seed": 7, "method": "photon",
        "effects": "direct,indirect", "unbiased": False, "per_light": False, "adaptive": True,
        "filter_light": True,
    }  # fmt: skip
    assert checked.describe(5) == {
        "size": [8, 4], "budget": {"passes": 3}, "threads": 5, **checked.deciding,
        "effects": ["direct", "indirect"],
    }  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Longer(Options):
    bounces: int = option(5, "longest path", whole=(1, 9))


@taking_keywords_of(Longer)
def trace(scene, options):
    """Trace.

    Parameters
    ----------
    scene : anything
    options : all of them
    """
    return scene, options.bounces, options.seed


def test_a_new_option_is_one_field():
    """From a field of the list follow the keyword, its documentation, its check, and the flag."""
    assert trace("box") == ("box", 5, 0)
    assert trace(scene="box", bounces=3, seed=1) == ("box", 3, 1)
    assert "    bounces : longest path\n" in trace.__doc__
    assert "options :" not in trace.__doc__
    listed = list_options(Longer)["bounces"]
    assert listed.flag == "--bounces"
    assert listed.checked(9) == 9
    with pytest.raises(InputError, match="bounces 10 must be a whole number from 1 to 9"):
        listed.checked(10)


def test_options_are_listed_nowhere_else():
    """No module but the list itself writes down the flags of a render."""
    shared = {each.flag for each in OPTIONS.values() if each.group} - {"--resume", "--seed"}
    own = {
        "sensors": {"--bands"},
        "evaluate": {"--method"},
        "inspect": {"--buffers"},
        "dataset": {"--buffers"},
    }  # where they mean something else
    for path in (ROOT / "photonmap").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if "add_argument" in text else ():
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "add_argument":
                texts = {arg.value for arg in node.args if isinstance(arg, ast.Constant)}
                repeated = (texts & shared) - own.get(path.stem, set())
                assert not repeated, f"{path.name} adds {repeated}"


def test_docs_hold_the_table_of_options():
    tool = runpy.run_path(str(ROOT / "tools" / "make_options.py"))
    text = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8")
    assert tool["insert"](text, tool["options_table"]()) == text, "run tools/make_options.py"
    assert text.count(tool["BEGIN"]) == text.count(tool["END"]) == 1


def test_strict_refuses_what_is_read_with_a_warning(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("room.obj").write_text("mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    small = ["--size", "4", "--passes", "1", "--photons", "100", "--quiet"]
    assert main(["room.obj", "--strict", *small]) == 2
    refused = capsys.readouterr().err
    assert "none.mtl" in refused
    assert refused.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["room.obj"]
    assert main(["convert", "room.obj", "room.glb", "--strict"]) == 2
    assert not (tmp_path / "room.glb").exists()
    assert main(["info", "room.obj", "--strict"]) == 2
    capsys.readouterr()
    with pytest.warns(SceneWarning, match=r"none\.mtl"):
        assert SceneSource("room.obj").load().meshes
    Path("room.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert SceneSource("room.obj", strict=True).load().meshes


@pytest.mark.parametrize(
    "command",
    [[], ["compile"], ["evaluate"], ["inspect"], ["merge"], ["sensor"], ["split"], ["study"]],
)
def test_o_stands_for_output_in_every_command(command, capsys):
    with pytest.raises(SystemExit):
        main([*command, "--help"])
    assert re.search(r"-o [\w.-]+, --output", capsys.readouterr().out)
    assert main([*command, "--output", ""]) == 2
    assert "--output: '' is not the name of a file or folder; give" in capsys.readouterr().err


PLATE = "v 2 0 0\nv 4 0 0\nv 4 2 0\nv 2 2 0\nf 1 2 3 4\n"


def test_parts_of_a_camera_do_without_the_rest(tmp_path):
    (tmp_path / "plate.obj").write_text(PLATE)
    path = str(tmp_path / "plate.obj")
    scene = SceneSource(path, camera={"fov": 10.0, "up": (0.0, 0.0, 1.0)}).load()
    assert (scene.camera, scene.fov, scene.up) == (None, 10.0, (0.0, 0.0, 1.0))
    scene = SceneSource(path, camera={"origin": (0.0, 0.0, 5.0)}).load()
    assert scene.camera == pm.Camera((0.0, 0.0, 5.0), (3.0, 1.0, 0.0))
    with pytest.raises(InputError, match="has no camera, so --target needs --origin too"):
        SceneSource(path, camera={"target": (0.0, 0.0, 5.0)}).load()
