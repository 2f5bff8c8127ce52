"""The order of images: one of each kind, then the longest; what a run says of cost and time."""

import itertools
from contextlib import nullcontext

import pytest

from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs import costs as module
from photonmap.dataset.jobs import schedule
from photonmap.dataset.jobs.costs import Agenda, kind_of
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task
from photonmap.dataset.jobs.schedule import run_tasks

COMMON = CommonSettings((16, 12), "3", "0.5", inputs="0")
COSTS = {"jug": 1.0, "study": 5.0, "bowl": 2.0}
LIGHTS = ("white", "colored")


def tasks(folder="", scenes=("jug", "study", "bowl"), lights=LIGHTS, count=2):
    preset = Preset("own", scenes, illuminations=lights)
    return [Task(job, str(folder), ("exr",)) for job in plan_jobs(preset, [], COMMON, count=count)]


def entry_of(job, seconds=None):
    seconds = COSTS[job.stem] if seconds is None else seconds
    spent = {"build": 0.0, "compile": 40.0, "render": seconds, "write": 0.0}
    return {"job": job.describe(), "seconds": spent, "cpu_seconds": 2.0 * seconds}


def run(agenda):
    order = []
    for task in agenda:
        order.append(task.job.stem)
        agenda.learn(task, entry_of(task.job))
    return order


def test_one_of_each_kind_then_the_longest():
    order = run(Agenda(tasks()))
    assert order[:3] == ["jug", "study", "bowl"]
    assert order[3:] == ["study"] * 3 + ["bowl"] * 3 + ["jug"] * 3


def test_numbers_of_lights_are_kinds_of_their_own():
    order = run(Agenda(tasks(lights=("white", "two_mixed"), scenes=("jug", "study"), count=1)))
    assert order == ["jug", "jug", "study", "study"]
    jobs = [task.job for task in tasks(scenes=("jug",), lights=("white", "two_mixed"), count=1)]
    assert kind_of(jobs[0]) != kind_of(jobs[1])


def test_what_was_rendered_earlier_is_known():
    first, *rest = tasks()
    known = {task.job.stem: entry_of(task.job) for task in tasks()}
    assert run(Agenda(rest, known.values()))[0] == "study"
    assert first.job.stem == "jug"


def test_a_kind_that_fails_does_not_stop_the_others():
    agenda = Agenda(tasks())
    seen = []
    for task in agenda:
        seen.append(task)
        failed = task.job.stem == "study"
        agenda.learn(task, "cannot be built" if failed else entry_of(task.job))
    assert len(seen) == 12
    assert agenda.seconds_left == 0.0


def test_tasks_may_begin_before_others_end():
    """As on a cluster: nothing is known of what still runs."""
    agenda = Agenda(tasks())
    running = list(itertools.islice(agenda, 7))
    for task in running:
        agenda.learn(task, entry_of(task.job))
    assert run(agenda) == ["study", "study", "bowl", "bowl", "jug"]


def test_what_is_still_rendered_may_take_longest():
    """Else short images would come before those of a kind that is not known yet."""
    agenda = Agenda(tasks(scenes=("jug", "bowl", "study"), lights=("white",)))
    for task in list(itertools.islice(agenda, 3))[:2]:
        agenda.learn(task, entry_of(task.job))
    assert next(agenda).job.stem == "study"


def test_images_of_a_scene_follow_each_other(monkeypatch):
    """Whatever their lights, so that it is built once; those of the first kinds come before."""
    monkeypatch.setattr(module, "KEPT", 0)
    made = tasks(lights=("white", "two_mixed", "colored"), scenes=("jug", "study"), count=3)
    order = [task.job.geometry for task in Agenda(made)][4:]
    assert len(order) == 14
    changes = sum(a != b for a, b in itertools.pairwise(order))
    assert changes == len(set(order)) - 1


def test_the_longest_images_of_scenes_in_memory_come_first():
    lights = ("white", "two_mixed")
    seconds = {("jug", 1): 1.0, ("jug", 2): 6.0, ("study", 1): 4.0, ("study", 2): 9.0}
    agenda = Agenda(tasks(lights=lights, scenes=("jug", "study"), count=2))
    order = []
    for task in agenda:
        kind = task.job.stem, len(task.job.colors)
        order.append(seconds[kind])
        agenda.learn(task, entry_of(task.job, seconds[kind]))
    assert order[4:] == [9.0, 6.0, 4.0, 1.0]


def test_time_left_and_cost(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: clock[0])
    agenda = Agenda(tasks())
    for task in itertools.islice(agenda, 3):
        clock[0] += 20.0 + COSTS[task.job.stem] / 2.0
        agenda.learn(task, entry_of(task.job))
    assert agenda.seconds_left == pytest.approx(3 * (1.0 + 5.0 + 2.0))
    # images ran two at a time: 128 s of images, kernels included, in 64 s
    assert agenda.describe() == "0.0044 processor hours, about 12 s left"
    run(agenda)
    assert agenda.describe() == "0.018 processor hours"


def test_the_list_keeps_its_order_in_the_manifest(tmp_path, capsys):
    preset = tmp_path / "own.toml"
    preset.write_text('scenes = ["jug", "bowl"]\nilluminations = ["white", "colored"]')
    size = ["--size", "16x12", "--bands", "3", "--error", "0.5", "--format", "exr"]
    assert main(["dataset", str(tmp_path / "set"), "--preset", str(preset), *size]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "processor hours" in line]
    assert len(lines) == 4
    assert [" left" in line for line in lines] == [True, True, False, False]
    rendered = [line.split()[1].split("-")[0] for line in lines]
    assert rendered == ["jug", "jug", "bowl", "bowl"]
    listed = [image.entry["job"]["scene"] for image in dataset.open(tmp_path / "set")]
    assert listed == ["jug", "jug", "bowl", "bowl"]


class Slow:
    """An agenda whose rest takes a given time."""

    def __init__(self, left, seconds):
        self.left, self.seconds_left = iter(left), seconds

    def __iter__(self):
        return self.left

    def __next__(self):
        return next(self.left)


def test_many_workers_render_the_rest_where_they_are_faster(
    tmp_path, monkeypatch, workers_in_threads
):
    """The arrays are the same; so are the records, of lights without narrow lines to warn of."""
    lights = ("white", "two_planckian")
    monkeypatch.setattr(schedule, "_workers_in_memory", lambda: 2)
    measured = []
    true_measure = schedule._measure

    def measure(client, task, alone):
        measured.append(true_measure(client, task, alone))
        return 1.7

    monkeypatch.setattr(schedule, "_measure", measure)
    lines = []
    for name in ("auto", "alone"):
        (tmp_path / name).mkdir()
    wanted = tasks(tmp_path / "auto", ("jug",), lights)
    found = dict(schedule.run_fastest(Slow(wanted, 1e6), lines.append))
    assert measured[0] > 0.0
    assert "2 render the rest" in lines[0]
    assert len(found) == 4
    threads = {task.job.name: task.threads for task in found}
    assert None not in [threads[task.job.name] for task in wanted[2:]]
    files = {task.job.name: entry["files"] for task, entry in found.items()}
    for task, entry in run_tasks(tasks(tmp_path / "alone", ("jug",), lights)[2:]):
        assert files[task.job.name] == entry["files"]
    assert not list(tmp_path.glob("*/.photonmap-*"))


def test_one_process_goes_on_where_many_are_no_faster(monkeypatch):
    monkeypatch.setattr(schedule, "_workers_in_memory", lambda: 2)
    monkeypatch.setattr(schedule, "has_dask", lambda: True)
    monkeypatch.setattr(schedule, "connect", lambda *_: nullcontext())
    monkeypatch.setattr(schedule, "_measure", lambda *_: 1.02)
    monkeypatch.setattr(schedule, "render_image", lambda task: entry_of(task.job))
    lines = []
    found = dict(schedule.run_fastest(Slow(tasks(), 1e6), lines.append))
    assert lines == ["2 processes are 1.02 times as fast as one: one goes on"]
    assert len(found) == 12
    assert {task.threads for task in found} == {None}


def test_little_work_is_not_worth_a_trial(tmp_path, monkeypatch):
    monkeypatch.setattr(schedule, "_workers_in_memory", lambda: 2)
    monkeypatch.setattr(schedule, "connect", lambda *_: pytest.fail("started processes"))
    found = list(schedule.run_fastest(Slow(tasks(tmp_path, ("jug",), count=1), 10.0), print))
    assert len(found) == 2


def test_as_many_processes_as_memory_allows(monkeypatch):
    psutil = pytest.importorskip("psutil")
    resource = pytest.importorskip("resource")
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    for free, processes in ((0.5, 1), (2.6, 2), (1000.0, 16)):
        monkeypatch.setattr(schedule, "default_threads", lambda: 16)
        memory = psutil.virtual_memory()._replace(available=int(free * used))
        monkeypatch.setattr(psutil, "virtual_memory", lambda memory=memory: memory)
        assert schedule._workers_in_memory() == processes
