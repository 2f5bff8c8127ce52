"""Render one image of a data set, write its folder atomically, and say what takes long."""

from __future__ import annotations

import json
import os
import shutil
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.capture.sensor import Sensor
from photonmap.dataset.files import derived_buffers
from photonmap.dataset.files.image_files import add_photo, hash_files, list_files, write_image
from photonmap.dataset.files.lean import rendered_for
from photonmap.dataset.files.manifest import check_code
from photonmap.dataset.files.schema import ENTRY_KINDS, misfits
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs.job_scene import make_scene, pieces_in
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.report.page import summarise
from photonmap.errors import InputError, naming_in_warnings
from photonmap.film.budget import LEAST_PASSES
from photonmap.results.files import write_json
from photonmap.results.result import Result
from photonmap.runtime.progress import STAGES, Silent
from photonmap.runtime.writing import WriteError, drafts_beside
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Paint, Texture, mean_color
from photonmap.settings import DATASET, taken_by
from photonmap.spectra import color_text, munsell
from photonmap.spectra.bands import Bands
from photonmap.spectra.photometry import BY_BANDS

if TYPE_CHECKING:
    from distributed import Client

    from photonmap.integrators.shared_work import SharedScene

ENTRY = "entry.json"
"""File in the folder of an image that holds its entry in the manifest."""


@dataclass(frozen=True)
class Task:
    """A job as it is sent to a worker: with where and how to write its image."""

    job: Job  # what to render
    folder: str  # of the data set
    formats: tuple[str, ...]  # of the files
    # the image must be rendered with, see `describe_code`; None for any
    versions: dict[str, str] | None = None
    threads: int | None = None  # of the render; None for every processor
    full: bool = False  # write everything in single precision, see `photonmap.dataset.files.lean`
    sensor: Sensor | None = None  # that takes a photo of the image; None for no photo
    # seconds of rendering after which an image stops short of its error; None for the usual
    time_limit: float | None = None
    buffers: tuple[str, ...] | None = None  # names of those that files hold; None for all
    others: tuple[Job, ...] = ()  # that are to be rendered too, of the same view in other light
    # all jobs of the view in the set, also those that are there: they decide the noise; () for none
    together: tuple[Job, ...] = ()

    @property
    def jobs(self) -> tuple[Job, ...]:
        """The jobs that are to be rendered."""
        return self.job, *self.others

    def at_size(self, size: tuple[int, int]) -> Task:
        """Return the task of images of another size."""

        def sized(job: Job) -> Job:
            return replace(job, common=replace(job.common, size=size))

        others, together = (tuple(map(sized, jobs)) for jobs in (self.others, self.together))
        return replace(self, job=sized(self.job), others=others, together=together)


def grouped(left: Sequence[Job], jobs: Sequence[Job]) -> list[tuple[Job, dict[str, Any]]]:
    """Return the first of the jobs of each task, and what else the task is to know of jobs.

    `left` are to be rendered, of `jobs`: each by itself, or those of a view together.
    """
    if not left or left[0].common.own_noise:
        return [(job, {}) for job in left]
    views: dict[Job, list[Job]] = {}
    for job in jobs:
        views.setdefault(job.in_any_light, []).append(job)
    waiting = {job.name for job in left}
    groups = []
    for view in views.values():
        asked = [job for job in view if job.name in waiting]
        if asked:
            groups.append((asked[0], {"others": tuple(asked[1:]), "together": tuple(view)}))
    return groups


def by_image(task: Task, result: Any) -> dict[str, dict[str, Any] | str]:
    """Return what came of each image of a task, its entry or why there is none, by its name."""
    if task.together and isinstance(result, dict):
        return result
    return {job.name: result for job in task.jobs}


def render_image(task: Task) -> dict[str, Any]:
    """Render an image and write its folder, replacing a damaged one; return its entry.

    A complete image is not rendered again: a worker may have died between writing and reporting it.
    Warnings name the image. Of a task of images that are rendered together, return what came of
    each, its entry or the reason why there is none, by its name.
    """
    if task.versions is not None:
        check_code(task.versions)
    with ThreadPoolExecutor(1) as writer:  # an image is written while the next one is rendered
        if not task.together:
            with naming_in_warnings(task.job.name):
                (entry,) = _render_images(task, [task.job], writer).values()
            return entry.result() if isinstance(entry, Future) else entry
        results, sets = _rendered_together(task)
        for jobs in sets:
            asked = [job.name for job in jobs if job in task.jobs]
            try:
                with naming_in_warnings(jobs[0].name):
                    results |= _render_images(task, jobs, writer) if asked else {}
            except (InputError, WriteError) as error:
                results |= dict.fromkeys(asked, str(error))
        return {job.name: _found(results[job.name]) for job in task.jobs}


def _found(result: Any) -> dict[str, Any] | str:
    """Return the entry of an image or the reason why there is none, when it has been written."""
    try:
        return result.result() if isinstance(result, Future) else result
    except (InputError, WriteError) as error:
        return str(error)


def _rendered_together(task: Task) -> tuple[dict[str, Any], list[list[Job]]]:
    """Return why there are no scenes of some jobs of a view, and others in sets for one render."""
    from photonmap.compile.illuminations import gather

    select_measured_sets(task.job)
    failures, jobs, scenes = dict[str, Any](), list[Job](), list[Scene]()
    for job in task.together:
        try:
            scenes.append(make_scene(job))
            jobs.append(job)
        except InputError as error:
            failures[job.name] = str(error)
    sets = gather(scenes, Bands.parse(task.job.common.bands))
    return failures, [[jobs[number] for number in numbers] for numbers in sets]


def _render_images(task: Task, jobs: Sequence[Job], writer: ThreadPoolExecutor) -> dict[str, Any]:
    """Render jobs together; return the entries of images that are asked for, or their futures."""
    data_set, start, used = Path(task.folder), time.perf_counter(), time.process_time()
    entries: dict[str, Any] = {
        job.name: read_entry(data_set / job.name) for job in jobs if job in task.jobs
    }
    if all(entries.values()):
        return entries
    select_measured_sets(jobs[0])
    scenes = [make_scene(job) for job in jobs]
    built = time.perf_counter()
    limit = task.time_limit and task.time_limit * len(jobs)
    results = render_jobs(jobs, scenes, task.threads, seconds=limit, buffers=task.buffers)
    shared: dict[str, float] = {}
    for job, scene, result in zip(jobs, scenes, results, strict=True):
        rendered = time.perf_counter()
        if not shared:  # each of the images that are asked for has its part of what is shared
            compiling = result.record["seconds"]["compile"]
            shared = {
                "build": built - start,
                "compile": compiling,
                "render": rendered - built - compiling,
                "cpu": time.process_time() - used,
            }
            shared = {name: value / len(entries) for name, value in shared.items()}
        if len(jobs) > 1:
            result.record["together"] = [
                each.relative_to(data_set).described_light for each in jobs
            ]
        if entries.get(job.name, True) is None:
            wait(each for each in entries.values() if isinstance(each, Future))
            entries[job.name] = writer.submit(_write, task, job, scene, result, shared)
    return entries


def _write(
    task: Task, job: Job, scene: Scene, result: Result, shared: dict[str, float]
) -> dict[str, Any]:
    """Write the folder of an image; return its entry, with the seconds of what was shared."""
    data_set, start, used = Path(task.folder), time.perf_counter(), time.thread_time()
    if not result.radiance.any():
        raise InputError(f"{job.name} shows no light; choose another view, or other lights")
    with naming_in_warnings(job.name), drafts_beside(data_set / job.name) as made:
        result = derived_buffers.with_derived(result, scene, pieces_in(job, scene))
        rgb = derived_buffers.as_rgb(result, job.common.rgb)
        folder = made / job.name
        folder.mkdir()
        arrays = write_image(folder, result, rgb, task.formats, task.full, task.buffers)
        entry = _describe(job.relative_to(data_set), scene, result, rgb) | {
            "full": task.full,
            "buffers": task.buffers and list(task.buffers),
            "arrays": arrays,
            "photo": task.sensor
            and add_photo(folder, result, task.sensor, job.own_seed, task.full),
        }
        entry["files"] = hash_files(folder, list_files(folder))
        entry["seconds"] = {
            **{name: shared[name] for name in ("build", "compile", "render")},
            "write": time.perf_counter() - start,
        }
        entry["cpu_seconds"] = shared["cpu"] + time.thread_time() - used
        write_json(entry, folder / ENTRY)
        _replace_folder(data_set / job.name, folder, made)
    return entry


def render_jobs(
    jobs: Sequence[Job],
    scenes: Sequence[Scene],
    threads: int | None = None,
    passes: int | None = None,
    seconds: float | None = None,
    buffers: Sequence[str] | None = None,
) -> Iterator[Result]:
    """Render the scenes of jobs: until their errors are reached, or the passes or time are up.

    Several jobs differ in the light alone, and are rendered together.

    Parameters
    ----------
    passes : the most of them; None for any number
    seconds : of rendering; None for the usual, or as many as the passes take
    buffers : names of those that files are to hold; None for all
    """
    from photonmap.render import render_scene
    from photonmap.render_illuminations import render_illuminations
    from photonmap.settings import Options

    job = jobs[0]
    options = {name: getattr(job.common, name) for name in taken_by(DATASET)}
    options |= {"passes": passes, "seconds": seconds, "buffers": rendered_for(buffers)}
    options |= {"seed": job.render_seed, "per_light": True, "progress": SpokenStages()}
    given = Options(**options, threads=threads)
    with warnings.catch_warnings():  # of each image alike: its record says so
        warnings.filterwarnings("ignore", f".*{BY_BANDS}")
        if len(jobs) > 1:
            results = render_illuminations(scenes, given)
        else:
            results = iter([render_scene(scenes[0], given, shared=_shared_scene())])
        for result in results:
            if result.record["interrupted"]:
                raise KeyboardInterrupt
            sets = result.record["measured_sets"]
            named = {role: path and Path(path).name for role, path in sets.items()}
            result.record["measured_sets"] = named
            result.record["white"] = None  # the colours of lights are what data sets are about
            yield result


@cache
def _shared_scene() -> SharedScene:
    """Return what compiles a scene once for all its views; photons are of each image."""
    from photonmap.integrators.shared_work import SharedScene

    return SharedScene()


def select_measured_sets(job: Job) -> None:
    """Point the environment to the measured sets of the job, and to no others."""
    sets = {munsell.VARIABLE: job.common.munsell, color_text.ILLUMINANTS: job.common.illuminants}
    for variable, path in sets.items():
        os.environ.pop(variable, None)
        if path is not None:
            os.environ[variable] = path


def _replace_folder(folder: Path, new: Path, spare: Path) -> None:
    """Replace a folder, if it exists, by a new one; `spare` takes the old one.

    Files of the old one that the data set does not write, such as notes, go over to the new one.
    """
    if folder.exists():
        written = {*list_files(new), *(load_entry(folder) or {"files": ()})["files"]}
        folder.rename(spare / "before")
        for name in set(list_files(spare / "before")) - written:
            (new / name).parent.mkdir(parents=True, exist_ok=True)
            (spare / "before" / name).rename(new / name)
    new.rename(folder)
    shutil.rmtree(spare / "before", ignore_errors=True)


def _describe(job: Job, scene: Scene, result: Result, rgb: Result) -> dict[str, Any]:
    """Return the entry of an image in the manifest, but for files and seconds."""
    described = describe_render(job, result)
    described["rgb"] |= {
        "residual": derived_buffers.rgb_residual(rgb),
        "negative": derived_buffers.negative_share(rgb, result.buffers["valid"]),
    }
    described["lights"] = describe_lights(scene, result)
    described["reflectances"] = describe_reflectances(scene, result.bands)
    described["statistics"] = summarise(result, derived_buffers.as_rgb(result))
    return described


def describe_render(job: Job, result: Result) -> dict[str, Any]:
    """Return what an entry says that follows from its job and the record in the image's files.

    What is None follows from the scene or from the arrays.
    """
    record = result.record
    method = derived_buffers.rgb_method(result.bands)
    goal = record["goal"]
    # an error that is not defined counts as reached, after enough passes
    is_met = goal is None or goal["reached"] is None or goal["reached"] <= goal["limit"]
    return {
        "name": job.name,
        "job": job.describe(),
        "geometry": job.geometry,
        "split": part_of(job.geometry),
        "render_seed": job.render_seed,
        "together": record.get("together"),
        "lights": None,
        "objects": record["objects"],
        "materials": record["materials"],
        "reflectances": None,
        "camera": record["camera"],
        "size": list(result.size),
        "bands": result.bands.count,
        **{name: record[name] for name in ("passes", "pass_samples", "error", "goal")},
        "reached": goal is None or (record["passes"] >= LEAST_PASSES and is_met),
        "effects": {name: [each["on"], each["why"]] for name, each in record["effects"].items()},
        "rgb": {
            "space": job.common.rgb,
            "method": method or "as they stand",
            "fit_residual": result.projection("rgb", method).residual,
        },
        "statistics": None,
        **{name: record[name] for name in ("unresolved", "versions", "fingerprint", "warnings")},
    }


def describe_lights(scene: Scene, result: Result) -> dict[str, Any]:
    """Return the emission of each light group in bands, None for textures."""
    bands = result.bands
    emitted: dict[str, Paint] = {m.material.name: m.material.emission for m in scene.meshes}
    emitted |= {each.group or each.name or each.kind: each.color for each in scene.lights}
    paints = {group: emitted[group] for group in result.record["light_groups"] if group in emitted}
    return {
        group: None if isinstance(paint, Texture) else _bands(bands.emission(paint))
        for group, paint in paints.items()
    }


def describe_reflectances(scene: Scene, bands: Bands) -> dict[str, Any]:
    """Return the reflectances of materials in bands, None where they vary."""
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    colored = {id(mesh.material) for mesh in meshes if mesh.colors is not None}
    reflectances = {}
    for material in {id(mesh.material): mesh.material for mesh in meshes}.values():
        paint = material.reflectance
        varies = isinstance(paint, Texture) or id(material) in colored
        mean = None if varies else _bands(bands.reflectance(mean_color(paint)))
        reflectances[material.name] = mean
    return reflectances


def _bands(values: Any) -> list[float]:
    return [round(float(value), 6) for value in values]


_TIMES = {name: ENTRY_KINDS[name] for name in ("seconds", "cpu_seconds")}


def read_entry(folder: Path) -> dict[str, Any] | None:
    """Return an image's entry if its files have the hashes in it, and its seconds are in range.

    Other files do not matter.
    """
    entry = load_entry(folder)
    with suppress(OSError, InputError):  # such as a file outside the folder
        if (
            entry
            and entry.get("name") == folder.name
            and entry["files"] == hash_files(folder, entry["files"])
            and not any(misfits(entry, _TIMES))
        ):
            return entry
    return None


def load_entry(folder: Path) -> dict[str, Any] | None:
    """Return the entry in the folder of an image; None where it is missing or damaged."""
    try:
        entry = json.loads((folder / ENTRY).read_text(encoding="utf-8"))
        return entry if isinstance(entry["files"], dict) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


Log = Callable[[str], None]
_TOPIC = "photonmap"  # of what workers send

_listeners: list[Log] = []


class SpokenStages(Silent):
    """Says where kernels are compiled, which may take a minute; else nothing."""

    def stage(self, name: str) -> None:
        """Say so."""
        if name == "first compile":
            say(STAGES[name])


def say(line: str) -> None:
    """Say a line to who listens in this process, or from a worker of dask to its client."""
    for listener in _listeners:
        listener(line)
    if not _listeners and find_spec("distributed") is not None:
        from distributed import get_worker

        with suppress(ValueError):  # this is no worker
            get_worker().log_event(_TOPIC, line)


@contextmanager
def hearing(log: Log) -> Iterator[None]:
    """Call `log` with every line that is said in this context, once each."""
    heard = set[str]()

    def hear(line: str) -> None:
        if line not in heard:
            heard.add(line)
            log(line)

    _listeners.append(hear)
    try:
        yield
    finally:
        _listeners.remove(hear)


def hear_workers(client: Client) -> None:
    """Say here what the workers of a client say."""
    client.subscribe_topic(_TOPIC, lambda event: say(event[1]))
