"""That kernels are compiled is said once, by this process or by others."""

from importlib import import_module

import pytest

from photonmap.commands.main import main
from photonmap.dataset.jobs import schedule
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task, hearing, say

LINE = "compiling kernels for scenes of this kind (once)"


@pytest.mark.parametrize(("more", "times"), [([], 1), (["--quiet"], 0)])
def test_the_command_says_it_once(tmp_path, monkeypatch, capsys, more, times):
    monkeypatch.setattr(import_module("photonmap.render"), "is_compiled", lambda *_: False)
    (tmp_path / "one.toml").write_text('scenes = ["jug"]\nilluminations = ["white", "colored"]')
    arguments = ["--preset", str(tmp_path / "one.toml"), "--size", "16x12", "--bands", "3"]
    made = tmp_path / "set"
    assert main(["dataset", str(made), *arguments, "--error", "0.5", *more]) == 0
    assert capsys.readouterr().err.splitlines().count(LINE) == times


def speak(task):
    say(LINE)
    return task.job.name


def test_workers_are_heard_once(tmp_path):
    pytest.importorskip("distributed")
    preset = Preset("two", ("jug",), illuminations=("white", "colored"))
    jobs = plan_jobs(preset, [], CommonSettings((16, 12), "3", "0.5", inputs="0"))
    tasks = [Task(job, str(tmp_path), ("exr",)) for job in jobs]
    heard = []
    with schedule.start_local_cluster(1) as cluster, hearing(heard.append):
        address = cluster.scheduler_address
        done = [result for _, result in schedule.run_tasks(tasks, address, work=speak)]
    assert sorted(done) == sorted(job.name for job in jobs)
    assert heard == [LINE]
