"""Render one image of a data set, write its folder atomically, and say what takes long."""

from __future__ import annotations

import json
import os
import shutil
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
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
from photonmap.runtime.writing import drafts_beside
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


def render_image(task: Task) -> dict[str, Any]:
    """Render an image and write its folder, replacing a damaged one; return its entry.

    A complete image is not rendered again: a worker may have died between writing and reporting it.
    Warnings name the image.
    """
    with naming_in_warnings(task.job.name):
        return _render_image(task)


def _render_image(task: Task) -> dict[str, Any]:
    job, start, used = task.job, time.perf_counter(), time.process_time()
    if task.versions is not None:
        check_code(task.versions)
    data_set = Path(task.folder)
    if entry := read_entry(data_set / job.name):
        return entry
    select_measured_sets(job)
    scene = make_scene(job)
    built = time.perf_counter()
    result = render_job(job, scene, task.threads, seconds=task.time_limit, buffers=task.buffers)
    rendered = time.perf_counter()
    if not result.radiance.any():
        raise InputError(f"{job.name} shows no light; choose another view, or other lights")
    result = derived_buffers.with_derived(result, scene, pieces_in(job, scene))
    rgb = derived_buffers.as_rgb(result, job.common.rgb)
    with drafts_beside(data_set / job.name) as made:
        folder = made / job.name
        folder.mkdir()
        arrays = write_image(folder, result, rgb, task.formats, task.full, task.buffers)
        entry = _describe(job.relative_to(data_set), scene, result, rgb) | {
            "full": task.full,
            "buffers": task.buffers and list(task.buffers),
            "arrays": arrays,
            "photo": task.sensor
            and add_photo(folder, result, task.sensor, job.render_seed, task.full),
        }
        entry["files"] = hash_files(folder, list_files(folder))
        entry["seconds"] = {
            "build": built - start,
            "compile": result.record["seconds"]["compile"],
            "render": rendered - built - result.record["seconds"]["compile"],
            "write": time.perf_counter() - rendered,
        }
        entry["cpu_seconds"] = time.process_time() - used
        write_json(entry, folder / ENTRY)
        _replace_folder(data_set / job.name, folder, made)
    return entry


def render_job(
    job: Job,
    scene: Scene,
    threads: int | None = None,
    passes: int | None = None,
    pass_samples: float | None = None,
    seconds: float | None = None,
    buffers: Sequence[str] | None = None,
) -> Result:
    """Render a job's scene: until its error is reached or the time is up; or as many passes.

    Parameters
    ----------
    passes, pass_samples : how many passes, and their size, in place of the error
    seconds : of rendering; None for the usual
    buffers : names of those that files are to hold; None for all
    """
    from photonmap.render import render_scene
    from photonmap.settings import Options

    options = {name: getattr(job.common, name) for name in taken_by(DATASET)}
    options |= {"seconds": seconds, "buffers": rendered_for(buffers)}
    if passes is not None:
        options |= {"passes": passes, "pass_samples": pass_samples, "error": None}
    options |= {"seed": job.render_seed, "per_light": True, "progress": SpokenStages()}
    with warnings.catch_warnings():  # of each image alike: its record says so
        warnings.filterwarnings("ignore", f".*{BY_BANDS}")
        result = render_scene(scene, Options(**options, threads=threads), shared=_shared_scene())
    if result.record["interrupted"]:
        raise KeyboardInterrupt
    sets = result.record["measured_sets"]
    result.record["measured_sets"] = {role: path and Path(path).name for role, path in sets.items()}
    result.record["white"] = None  # the colours of lights are what data sets are about
    return result


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
