"""What a render tells while it runs."""

import math

from photonmap.runtime import progress
from photonmap.settings import Options, Settings


def test_lines(capsys):
    lines = progress.Lines()
    lines.stage("first compile")
    lines.stage("render")
    lines.update(1, math.inf, 0.0, 1.0, 8e6)
    lines.update(2, 0.5, 0.1, 2.0, 8e6)
    lines.close()
    messages = capsys.readouterr().err.splitlines()
    assert messages == [
        "compiling kernels for scenes of this kind (once)",
        "rendering",
        "pass 1, error unknown yet, unknown time left, 8.0 Mrays/s",
    ]


def test_without_a_choice_only_compiling_is_told(capsys):
    notice = progress.CompileNotice()
    for stage in progress.STAGES:
        notice.stage(stage)
    notice.update(1, 0.1, 0.5, 1.0, 8e6)
    notice.close()
    said = "photonmap: compiling kernels for scenes of this kind (once)\n"
    assert capsys.readouterr().err == said
    assert isinstance(Settings.of(Options()).progress, progress.CompileNotice)
    assert isinstance(Settings.of(Options(progress=False)).progress, progress.Silent)


def test_bar():
    bar = progress.Bar()
    bar.stage("render")
    bar.update(3, 0.05, 0.5, 70.0, 1e7)
    task = bar._bar.tasks[0]
    assert task.completed == 0.5
    assert task.fields["state"] == "pass 3, error 0.0500, 1 min 10 s left, 10.0 Mrays/s"
    bar.close()


def test_choice(monkeypatch):
    assert isinstance(progress.choose_progress(quiet=True), progress.Silent)
    monkeypatch.setattr("sys.stderr.isatty", lambda: False)
    assert isinstance(progress.choose_progress(quiet=False), progress.Lines)
