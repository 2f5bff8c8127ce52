"""Hostile files: names that command a terminal, and work beyond a file's size."""

import json
import warnings

import hostile
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.errors import InputError, naming, visible
from photonmap.runtime.terminal import drawing, tolerant


@pytest.mark.parametrize("kind", hostile.named())
@pytest.mark.parametrize("more", [[], ["--json"]])
def test_names_of_files_do_not_command_the_terminal(kind, more, tmp_path, capsys):
    for name, data in hostile.named().items():
        (tmp_path / name).write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)
        code = main(["info", str(tmp_path / kind), *more])
    printed = capsys.readouterr()
    assert code == (0 if kind in ("names.gltf", "names.obj", "names.ply") else 2)
    shown = printed.out + printed.err
    assert not [hidden for hidden in hostile.HIDDEN if hidden in shown.replace("\n", "")]
    assert "\nphotonmap: error: none" not in shown
    errors = printed.err.splitlines()
    assert all(line.startswith(("photonmap: error: ", "photonmap: warning: ")) for line in errors)
    assert len([line for line in errors if "error: " in line[:20]]) == (code == 2)
    if code == 0:
        assert "owned" in shown
        assert "202e" in shown  # not left out, but shown
    if more and not code:
        names = [mesh["name"] for mesh in json.loads(printed.out)["meshes"]]
        assert names == (["names"] if kind == "names.ply" else names)
        assert kind != "names.gltf" or names == [hostile.LINES]


def test_names_of_files_do_not_command_the_terminal_in_warnings(tmp_path):
    for kind in ("names.gltf", "names.obj", "names.ply"):
        (tmp_path / kind).write_bytes(hostile.named()[kind])
        with pytest.warns(pm.SceneWarning) as said:
            pm.load_scene(tmp_path / kind)
        for each in said:
            assert "owned" in str(each.message)
            assert not [hidden for hidden in hostile.HIDDEN if hidden in str(each.message)]


def test_what_is_shown():
    assert visible("Ä 日本 \u200d \\ 'a'") == "Ä 日本 \u200d \\ 'a'"
    assert visible("\x1b\n\x7f\u202e\ud800") == "\\u001b\\n\\u007f\\u202e\\ud800"
    assert json.loads(f'"{visible(hostile.LINES)}"') == hostile.LINES
    assert visible(visible(hostile.LINES)) == visible(hostile.LINES)
    assert str(InputError("a\n b", "x\ny")) == "x\\ny: a b"
    with pytest.raises(InputError, match=r"^a\\nb: c$"), naming("a\nb"):
        raise InputError("c")
    assert len(str(InputError("x" * 10**6))) < 5000


def test_only_a_bar_draws(capsys):
    import sys

    for wrap, wanted in ((tolerant, "\\u001b[2K\n"), (drawing, "\x1b[2K\n")):
        print("\x1b[2K", file=wrap(tolerant(sys.stdout)))
        assert capsys.readouterr().out == wanted
