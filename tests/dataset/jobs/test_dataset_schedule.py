"""Images rendered by dask.distributed: a real local scheduler, and workers that die."""

import functools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs import render_image as render_image_module
from photonmap.dataset.jobs import schedule
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task, render_image
from photonmap.dataset.jobs.verify import verify

distributed = pytest.importorskip("distributed")

COMMON = CommonSettings((16, 12), "3", "0.5", inputs="0")


class LostFuture:
    """An image that is rendered, by a worker that is no longer there."""

    status = "finished"

    def cancelled(self):
        return False

    def result(self, timeout):
        raise TimeoutError


def tasks(folder):
    preset = Preset("two", ("jug",), illuminations=("white", "two_mixed"))
    return [Task(job, str(folder), ("exr",)) for job in plan_jobs(preset, [], COMMON)]


def die_once(task, mark):
    """Render an image; the first one to come this way is killed instead."""
    try:
        Path(mark).touch(exist_ok=False)
    except FileExistsError:
        return render_image(task)
    return os.kill(os.getpid(), signal.SIGKILL)


def die_of(task, name):
    """Render an image; that of this name kills whoever renders it."""
    if task.job.name == name:
        os.kill(os.getpid(), signal.SIGKILL)
    return render_image(task)


@pytest.fixture
def cluster(workers_in_threads):
    with workers_in_threads(1) as running:
        yield running


def test_workers_make_what_this_process_makes(tmp_path, cluster):
    for place in ("here", "there"):
        (tmp_path / place).mkdir()
    here = dict(_named(schedule.run_tasks(tasks(tmp_path / "here"))))
    there = dict(_named(schedule.run_tasks(tasks(tmp_path / "there"), cluster.scheduler_address)))
    assert here.keys() == there.keys()
    for name in here:
        first = dataset.Image(tmp_path / "here", here[name])
        second = dataset.Image(tmp_path / "there", there[name])
        assert set(first) == set(second)
        for buffer, array in first.items():
            np.testing.assert_array_equal(array, second[buffer])


def test_tasks_are_handed_out_as_workers_become_free(cluster):
    """So what is learnt from the first decides on the order of the others."""
    taken = []

    def numbers():
        for number in range(12):
            taken.append(number)
            yield number

    ahead = []
    for done, _ in schedule.run_tasks(numbers(), cluster.scheduler_address, work=float):
        ahead.append(len(taken) - len(ahead))
        assert done in taken
    assert len(ahead) == 12
    assert max(ahead) <= 3, "of one worker"


@pytest.mark.parametrize(
    ("workers", "fault"),
    [
        ("many", "'many' is not a whole number"),
        ("1.5", "'1.5' is not a whole number"),
        ("0", "workers 0 must be a whole number from 1 to 1024"),
    ],
)
def test_numbers_of_workers(tmp_path, capsys, workers, fault):
    assert main(["dataset", str(tmp_path / "set"), "--workers", workers]) == 2
    assert fault in capsys.readouterr().err
    schedule.check_scheduler(schedule.LOCAL, "auto")


def _named(outcomes):
    return ((task.job.name, entry) for task, entry in outcomes)


@pytest.mark.slow
def test_the_images_of_a_worker_that_dies_go_to_another(tmp_path, monkeypatch):
    mark = tmp_path / "died"
    monkeypatch.setattr(schedule, "render_image", functools.partial(die_once, mark=str(mark)))
    folder = tmp_path / "set"
    folder.mkdir()
    outcomes = dict(_named(schedule.run_tasks(tasks(folder), workers=2)))
    assert mark.exists()
    assert len(outcomes) == 2
    assert all(isinstance(entry, dict) for entry in outcomes.values())
    assert sorted(path.name for path in folder.iterdir()) == sorted(outcomes)


@pytest.mark.slow
def test_an_image_that_kills_every_worker_fails_alone(tmp_path, monkeypatch):
    """The other image is rendered, on workers that are started again and again."""
    poisoned, good = tasks(tmp_path)
    monkeypatch.setattr(schedule, "render_image", functools.partial(die_of, name=poisoned.job.name))
    outcomes = dict(_named(schedule.run_tasks([poisoned, good], workers=2)))
    assert outcomes[poisoned.job.name].startswith("KilledWorker: ")
    assert isinstance(outcomes[good.job.name], dict)


@pytest.mark.slow
def test_workers_that_were_given_up_are_replaced(tmp_path):
    with schedule.connect(schedule.LOCAL, 1) as client:
        [nanny] = client.cluster.workers.values()
        client.sync(nanny.close)
        [(_, entry)] = schedule.distribute(client, render_image, tasks(tmp_path)[:1], 1)
    assert isinstance(entry, dict)


@pytest.mark.slow
def test_images_are_told_when_the_scheduler_is_killed(tmp_path):
    file = tmp_path / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0"]
    process = subprocess.Popen(
        [*command, "--no-dashboard", "--host", "127.0.0.1", "--scheduler-file", str(file)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    kill = threading.Timer(5.0, process.kill)
    try:
        while not file.exists():
            assert process.poll() is None
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        kill.start()
        outcomes = list(schedule.run_tasks(tasks(tmp_path), address))
    finally:
        kill.cancel()
        process.kill()
        process.wait()
    assert [reason for _, reason in outcomes] == [schedule._SCHEDULER_GONE] * 2


def test_an_image_whose_entry_was_lost_is_not_rendered_again(tmp_path, monkeypatch):
    task = tasks(tmp_path)[0]
    entry = render_image(task)
    monkeypatch.setattr(
        render_image_module, "render_jobs", lambda *_: pytest.fail("rendered again")
    )
    assert render_image(task) == json.loads(json.dumps(entry))
    assert schedule._collect(LostFuture()) is schedule._RERUNNING


def test_images_are_given_up_where_there_are_no_workers(tmp_path, monkeypatch):
    monkeypatch.setattr(schedule, "_PATIENCE", 0.5)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty:
        outcomes = list(schedule.run_tasks(tasks(tmp_path), empty.scheduler_address))
    assert [reason for _, reason in outcomes] == [schedule._NO_WORKERS] * 2


def test_bad_scenes_fail_alone(tmp_path, cluster):
    good = tasks(tmp_path)[0]
    bad = replace(good, job=replace(good.job, colors=("D65",) * 5))
    outcomes = dict(schedule.run_tasks([bad, good], cluster.scheduler_address))
    assert "has 5 colours, but there are 4 light groups" in outcomes[bad]
    assert isinstance(outcomes[good], dict)


@pytest.mark.slow
def test_two_local_workers(tmp_path):
    preset = tmp_path / "one.toml"
    preset.write_text('scenes = ["jug"]\nilluminations = ["white", "two_mixed"]')
    arguments = ["--preset", str(preset), "--size", "16x12", "--bands", "3", "--error", "0.5"]
    folder = tmp_path / "set"
    assert main(["dataset", str(folder), *arguments, "--workers", "2", "--quiet"]) == 0
    assert len(dataset.open(folder)) == 2
    assert verify(folder, sample=0) == []


def test_without_dask_this_process_renders(tmp_path, monkeypatch):
    monkeypatch.setattr(schedule, "find_spec", lambda name: None)
    with pytest.warns(pm.SceneWarning, match=r"pip install 'photonmap\[cluster\]'"):
        outcomes = list(schedule.run_tasks(tasks(tmp_path)[:1], workers=2))
    assert isinstance(outcomes[0][1], dict)


def test_a_scheduler_that_does_not_answer_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(schedule, "_CONNECT", 0.5)
    with pytest.raises(pm.InputError, match="cannot be reached"):
        list(schedule.run_tasks(tasks(tmp_path), "tcp://127.0.0.1:9"))
    with pytest.raises(pm.InputError, match="cannot be reached"):
        list(schedule.run_tasks(tasks(tmp_path), "nonsense://x"))
    with pytest.raises(ValueError, match="No client"):  # none is left behind as the default
        distributed.default_client()
