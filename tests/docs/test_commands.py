"""The commands of README and docs run as they are written, but small."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
import trimesh
from test_docs import PAGES, ROOT

import photonmap as pm
from photonmap.commands.main import main

SMALLER = {"--size": "8x6", "--error": "0.5", "--passes": "4", "--memory": "1G"}
"""Values in place of those that are written."""
FILES = {"SCENE": "room.obj", "PATH": "chips.csv"}
"""Files in place of placeholders."""
ELSEWHERE = {"split", "study", "dataset", "evaluate"}
"""Commands that take long: their own tests run them."""
COMMAND = re.compile(r"^    (?:\.venv/bin/)?python -m photonmap ((?:.*\\\n)*.*)$", re.M)
OPTIONAL = re.compile(r"\[[^\]]*\]")


def commands(page):
    """Return the arguments of each command of a page, without what may be left out."""
    found = COMMAND.findall(page.read_text(encoding="utf-8"))
    lines = (OPTIONAL.sub("", text.replace("\\\n", " ")) for text in found)
    return [shlex.split(line, comments=True) for line in lines]


def made_small(words):
    """Return the arguments of a command that is done in a second."""
    words = [FILES.get(word, word) for word in words]
    if words[0] == "compile":  # a minute; tests/commands/test_compile.py runs it
        return ["info", str(ROOT / "scenes" / "cornell_box.obj")]
    for option, value in SMALLER.items():
        if option in words:
            words[words.index(option) + 1] = value
    if words[0] in ("convert", "info", "inspect", "merge", "sensor", "sensors"):
        return words
    size = [] if "--size" in words else ["--size", SMALLER["--size"]]
    return [*words, *size, "--photons", "500"]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The folder of the files that commands name."""
    folder = tmp_path_factory.mktemp("files")
    (folder / "scenes").symlink_to(ROOT / "scenes")
    for file in Path(pm.scenes.FOLDER).glob("cornell_box.*"):
        shutil.copy(file, folder)
        shutil.copy(file, folder / f"room{file.suffix}")
    pm.save_scene(pm.scenes.cornell_box(), folder / "saved" / "room.glb")
    shutil.copy(folder / "saved" / "room.glb", folder)
    result = pm.render(pm.scenes.cornell_box(), size=(8, 6), passes=2, photons=500)
    for name in ("box", "other"):
        result.save(folder / f"{name}.exr")
    trimesh.creation.box().export(folder / "scan.ply")
    (folder / "scene.xml").write_text('<scene version="3.0.0"><shape type="cube"/></scene>')
    (folder / "chips.csv").write_text("nm,a,b\n380,0.7,0.9\n730,0.9,0.6\n")
    return folder


@pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")
@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if commands(page)],
    ids=lambda page: f"{page.parent.name}-{page.name}",
)
def test_commands(page, files, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(shutil.copytree(files, tmp_path / "here", symlinks=True))
    monkeypatch.setenv("PHOTONMAP_MUNSELL", "")
    for words in commands(page):
        if words[0] not in ELSEWHERE:
            assert main(made_small(words)) == 0, f"{words}: {capsys.readouterr().err}"


def test_every_page_with_commands_is_found():
    found = {page.relative_to(ROOT).as_posix(): len(commands(page)) for page in PAGES}
    assert found["README.md"] == 1
    assert found["docs/guide.md"] >= 8
    assert found["docs/sensor.md"] >= 3
    assert found["docs/spectra.md"] == 1
