"""The commands of README and docs run as they are written, but small."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from test_docs import PAGES, ROOT

import photonmap as pm
from photonmap.commands.main import main

SMALLER = {
    "--size": "8x6", "--error": "0.5", "--passes": "4", "--parts": "2", "--memory": "1G",
    "--preset": "one.toml",
}  # fmt: skip
"""Values in place of those that are written."""
ADDED = {"render": ["--photons", "500"], "split": ["--photons", "500"]}
"""Options that a command gets besides."""
FILES = {"SCENE": "room.obj", "PATH": "chips.csv", "OUT/": "out"}
"""Files in place of placeholders."""
SLOW = {"split", "study", "dataset"}
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
    for option, value in SMALLER.items():
        if option in words:
            words[words.index(option) + 1] = value
    name = words[0] if words[0] in {*SLOW, "merge", "sensors"} else "render"
    if name == "render" and not {"--size"} & {*words}:
        words += ["--size", SMALLER["--size"]]
    if name == "study":
        words += ["--quick", "--minutes", "0.02", "--size", "8x6"]
    return name, words + ADDED.get(name, [])


def cases():
    """Yield a page and which of its commands are run: the slow ones apart."""
    for page in PAGES:
        names = [made_small(words)[0] for words in commands(page)]
        for slow in (False, True):
            if any((name in SLOW) == slow for name in names):
                marks = [pytest.mark.slow] if slow else []
                yield pytest.param(
                    page, slow, id=f"{page.parent.name}-{page.name}{' slow' * slow}", marks=marks
                )


@pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")
@pytest.mark.parametrize(("page", "slow"), list(cases()))
def test_commands(page, slow, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PHOTONMAP_MUNSELL", "")
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    for file in Path(pm.scenes.FOLDER).glob("cornell_box.*"):
        shutil.copy(file, tmp_path)
        shutil.copy(file, f"room{file.suffix}")
    (tmp_path / "one.toml").write_text('scenes = ["jug"]\nilluminations = ["white"]\n')
    (tmp_path / "chips.csv").write_text("nm,a,b\n380,0.7,0.9\n730,0.9,0.6\n")
    for words in commands(page):
        name, small = made_small(words)
        if (name in SLOW) == slow:
            assert main(small) == 0, f"{words}: {capsys.readouterr().err}"


def test_every_page_with_commands_is_found():
    found = {page.relative_to(ROOT).as_posix(): len(commands(page)) for page in PAGES}
    assert found["README.md"] == 1
    assert found["docs/guide.md"] >= 8
    assert found["docs/spectra.md"] == 1
