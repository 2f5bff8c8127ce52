"""What a data set is said to cost, beside what it did cost."""

from types import SimpleNamespace

import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs import costs as module
from photonmap.dataset.jobs.costs import Cost, estimate, list_costs
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.film.budget import usual_photons

COMMON = CommonSettings((640, 480), "3", "0.5", inputs="0")
BUILD, RENDER, WRITE = 2.0, 3.0, 0.5
AGAIN = 0.05
"""Seconds that lighting a scene takes which is built."""


@pytest.fixture
def pilots(monkeypatch):
    """Pilots that take known times, and write files of known sizes."""
    rendered = []

    def render(task):
        rendered.append(task)
        if task.job.stem == "bowl":
            raise pm.InputError("cannot be rendered")
        folder = module.Path(task.folder) / task.job.name
        folder.mkdir()
        (folder / "bands.exr").write_bytes(bytes(1000 * len(task.job.colors)))
        seconds = {"build": BUILD, "compile": 0.0, "render": RENDER, "write": WRITE}
        return {"files": {"bands.exr": ""}, "seconds": seconds, "cpu_seconds": 2 * (BUILD + 3.5)}

    monkeypatch.setattr(module, "render_image", render)
    clock = [0.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(module, "make_scene", lambda job: clock.append(clock.pop() + AGAIN))
    return rendered


def task_of(limit=None):
    return lambda job, folder: module.Task(job, folder, ("exr",), time_limit=limit)


def test_pilots_are_scaled_by_pixels(pilots):
    lights = ("white", "colored", "two_mixed")
    jobs = plan_jobs(Preset("own", ("jug", "bowl"), illuminations=lights), [], COMMON, count=2)
    costs = estimate(task_of(), jobs)
    assert [task.job.common.size for task in pilots[:1]] == [(160, 120)]
    assert len([task for task in pilots if task.job.stem == "jug"]) == 2, "by numbers of lights"
    scale = 16
    growth = (scale + usual_photons(640 * 480) / usual_photons(160 * 120)) / 2.0
    seconds = 6 * (RENDER * growth + WRITE * scale) + 2 * (BUILD - AGAIN) + 6 * AGAIN
    assert costs["jug"].images == 6
    assert costs["jug"].seconds == pytest.approx(seconds), "two scenes, six images"
    assert costs["jug"].cpu_seconds == pytest.approx(2 * seconds)
    assert costs["jug"].bytes == pytest.approx((4 * 1000 + 2 * 2000) * scale)
    assert costs["bowl"] == Cost()
    *_, last = list_costs(costs)
    assert last.startswith("6 images: about ")
    limited = estimate(task_of(10.0), jobs)["jug"]
    limited_seconds = 6 * (10.0 + WRITE * scale) + 2 * BUILD + 4 * AGAIN
    assert limited.seconds == pytest.approx(limited_seconds)


def test_what_cannot_be_rendered_has_no_cost(pilots):
    jobs = plan_jobs(Preset("own", ("bowl",), illuminations=("white",)), [], COMMON)
    with pytest.raises(pm.InputError, match="cannot be rendered"):
        estimate(task_of(), jobs)


def test_files_are_as_large_as_was_said(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(module, "LEAST_PHOTONS", 1700)
    (tmp_path / "one.toml").write_text('scenes = ["jug"]\nilluminations = ["white"]')
    size = ["--size", "64x48", "--bands", "3", "--error", "0.5", "--format", "exr"]
    words = ["dataset", str(tmp_path / "set"), "--preset", str(tmp_path / "one.toml"), *size]
    assert main([*words, "--estimate"]) == 0
    _, row, whole = capsys.readouterr().out.splitlines()
    assert not (tmp_path / "set").exists()
    assert whole.startswith("1 images: about ")
    said = float(row.split()[-1])
    assert main([*words, "--quiet"]) == 0
    [image] = dataset.open(tmp_path / "set")
    took = sum((image.folder / name).stat().st_size for name in image.entry["files"]) / 1e6
    assert took / 2 < said < 2 * took, "files have heads that do not grow"
