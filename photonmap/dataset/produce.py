"""Render one image of a data set, and write its folder: whole, or not at all."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from photonmap.bands import Bands
from photonmap.dataset.derived import as_rgb, rgb_method, rgb_residual, with_derived
from photonmap.dataset.files import hash_files, write_image
from photonmap.dataset.jobs import Job
from photonmap.dataset.manifest import check_code
from photonmap.dataset.sources import make_scene
from photonmap.dataset.statistics import summarise
from photonmap.output import write_json
from photonmap.result import Result
from photonmap.scene import Scene
from photonmap.spectra import munsell, text
from photonmap.textures import Paint, Texture

ENTRY = "entry.json"
"""What the manifest says of an image, in its own folder."""


@dataclass(frozen=True)
class Task:
    """A job, and where and how its image is written; what is sent to workers."""

    job: Job
    folder: str
    formats: tuple[str, ...]
    versions: dict[str, str] | None = None
    """those it must be rendered with, see `describe_code`; None for any"""
    threads: int | None = None


def produce(task: Task) -> dict[str, Any]:
    """Render an image and write its folder, in place of a damaged one; return its entry.

    One that is there already is not rendered again: a worker wrote it, and died before it said so.

    Raises
    ------
    InputError : its scene cannot be rendered, or not with the same versions
    OSError : it cannot be written
    KeyboardInterrupt : at Ctrl-C; nothing is written
    """
    job, start, used = task.job, time.perf_counter(), time.process_time()
    if task.versions is not None:
        check_code(task.versions)
    place = Path(task.folder)
    if there := read_entry(place / job.name):
        return there
    name_sets(job)
    scene = make_scene(job)
    built = time.perf_counter()
    result = render_job(job, scene, task.threads)
    rendered = time.perf_counter()
    result = with_derived(result)
    rgb = as_rgb(result)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=place) as made:
        folder = Path(made) / job.name
        folder.mkdir()
        write_image(folder, result, rgb, task.formats)
        entry = _describe(job, scene, result, rgb)
        entry["files"] = hash_files(folder)
        entry["seconds"] = {
            "build": built - start,
            "compile": result.record["seconds"]["compile"],
            "render": rendered - built - result.record["seconds"]["compile"],
            "write": time.perf_counter() - rendered,
        }
        entry["cpu_seconds"] = time.process_time() - used
        write_json(entry, folder / ENTRY)
        _put(folder, place / job.name, Path(made))
    return entry


def render_job(
    job: Job, scene: Scene, threads: int | None = None, passes: int | None = None
) -> Result:
    """Render a job's scene: to its error, or as many passes.

    Raises
    ------
    KeyboardInterrupt : at Ctrl-C, also after the first passes
    """
    from photonmap import render

    result = render(
        scene,
        bands=Bands.parse(job.common.bands),
        size=job.common.size,
        passes=passes,
        error=job.common.error if passes is None else None,
        seed=job.render_seed,
        threads=threads,
        per_light=True,
    )
    if result.record["interrupted"]:
        raise KeyboardInterrupt
    return result


def name_sets(job: Job) -> None:
    """Let names of colours find the measured sets of the job, and no others."""
    sets = {munsell.VARIABLE: job.common.munsell, text.ILLUMINANTS: job.common.illuminants}
    for variable, path in sets.items():
        if path is None:
            os.environ.pop(variable, None)
        else:
            os.environ[variable] = path


def _put(folder: Path, place: Path, spare: Path) -> None:
    """Move a folder to its place; what was there goes."""
    if place.exists():
        place.rename(spare / "before")
    folder.rename(place)
    shutil.rmtree(spare / "before", ignore_errors=True)


def _describe(job: Job, scene: Scene, result: Result, rgb: Result) -> dict[str, Any]:
    """Return what the manifest says of an image, but for files and seconds."""
    record = result.record
    method = rgb_method(result.bands)
    goal = record["goal"]
    return {
        "name": job.name,
        "job": job.describe(),
        "geometry": job.geometry,
        "render_seed": job.render_seed,
        "lights": _lights(scene, record, result.bands),
        **_surfaces(scene, result.bands),
        "camera": record["camera"],
        "size": list(result.size),
        "bands": result.bands.count,
        "passes": record["passes"],
        "error": record["error"],
        "goal": goal,
        "reached": goal is None or goal["reached"] is None or goal["reached"] <= goal["limit"],
        "effects": {
            name: [effect["on"], effect["why"]] for name, effect in record["effects"].items()
        },
        "rgb": {
            "method": method or "as they stand",
            "fit_residual": result.projection("rgb", method).residual,
            "residual": rgb_residual(rgb),
        },
        "statistics": summarise(result, rgb),
        "unresolved": record["unresolved"],
        "versions": record["versions"],
        "fingerprint": record["fingerprint"],
        "warnings": record["warnings"],
    }


def _lights(scene: Scene, record: dict[str, Any], bands: Bands) -> dict[str, Any]:
    """Return the band values of what each group of lights sends, None for textures."""
    sent: dict[str, Paint] = {m.material.name: m.material.emission for m in scene.meshes}
    sent |= {each.group or each.name or each.kind: each.color for each in scene.lights}
    paints = {group: sent[group] for group in record["light_groups"] if group in sent}
    return {
        group: None if isinstance(paint, Texture) else _bands(bands.emission(paint))
        for group, paint in paints.items()
    }


def _surfaces(scene: Scene, bands: Bands) -> dict[str, Any]:
    """Name objects and materials in the order of their ids, from 1; and what they reflect."""
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    materials = list({id(mesh.material): mesh.material for mesh in meshes}.values())
    known: dict[str, Any] = {}
    for material in materials:
        paint = material.reflectance
        known[material.name] = (
            None if isinstance(paint, Texture) else _bands(bands.reflectance(paint))
        )
    return {
        "objects": list(dict.fromkeys(mesh.name for mesh in meshes)),
        "materials": [material.name for material in materials],
        "reflectances": known,
    }


def _bands(values: Any) -> list[float]:
    return [round(float(value), 6) for value in values]


def read_entry(folder: Path) -> dict[str, Any] | None:
    """Return the entry of an image that is complete and whose files are those written; else None.

    Hashes are compared.
    """
    try:
        entry = json.loads((folder / ENTRY).read_text(encoding="utf-8"))
        files = hash_files(folder)
    except (OSError, ValueError):
        return None
    files.pop(ENTRY, None)
    return entry if isinstance(entry, dict) and entry.get("files") == files else None
