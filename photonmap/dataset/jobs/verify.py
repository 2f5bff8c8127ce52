"""Verify a data set: files, identities of buffers, error goals, and images rendered again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.chosen_buffers import held_in
from photonmap.dataset.files.image_files import hash_files, list_files
from photonmap.dataset.files.inputs import warn_of_left_out
from photonmap.dataset.files.lean import as_lean
from photonmap.dataset.files.manifest import describe_differences
from photonmap.dataset.files.reader import Image, open_dataset
from photonmap.dataset.jobs.inputs import Find, input_finder
from photonmap.dataset.jobs.job_scene import make_scene
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import ENTRY, render_job, select_measured_sets
from photonmap.dataset.jobs.verify_arrays import (
    check_digests,
    check_formats_agree,
    check_geometry,
    check_identities,
    check_numbers,
    check_photo,
    check_rgb,
    is_full,
)
from photonmap.errors import InputError
from photonmap.results.record import describe_versions
from photonmap.runtime.fingerprint import difference

Log = Callable[[str], None]


def verify(
    folder: str | PathLike[str],
    sample: int = 1,
    log: Log | None = None,
    seed: int | None = None,
    scenes: str | PathLike[str] | None = None,
) -> list[str]:
    """Check every image of a data set, and render a sample again; warn of scenes left out.

    Parameters
    ----------
    folder : of the data set
    sample : number of images to render again with the same number of passes; they are compared bit
        for bit if versions and kernels are those that rendered them, and skipped otherwise
    log : called with a line for each check that passed or was skipped
    seed : draws the sample; None for another sample each time
    scenes : folder in which scene files are looked for that are not where the manifest says

    Returns
    -------
    Faults, a line each; empty if there are none

    Raises
    ------
    InputError : the folder does not hold a data set, or `sample` is negative
    """
    if sample < 0:
        raise InputError(f"sample {sample} must be a number of images, 0 or more")
    log = log or (lambda line: None)
    images = open_dataset(folder)
    warn_of_left_out(images.head)
    find = input_finder(images.folder, scenes)
    names = {image.name for image in images}
    faults = [f"{name}: is missing" for name in images.head["images"] if name not in names]
    for image in images:
        found = [*_faults(image, log, find), *_version_faults(image.entry, images.head["versions"])]
        faults += [f"{image.name}: {fault}" for fault in found]
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = rng.choice(len(images), min(sample, len(images)), replace=False)
    for index in sorted(chosen.tolist()):
        image = images[index]
        faults += [f"{image.name}: {fault}" for fault in _render_again(image, log, find)]
    count = "1 fault" if len(faults) == 1 else f"{len(faults) or 'no'} faults"
    checked = "files, numbers, identities, geometry and errors checked"
    log(f"{len(images)} images: {checked}, {count}")
    return faults


def _faults(image: Image, log: Log, find: Find) -> Iterator[str]:
    """Yield the faults of an image that show without rendering it."""
    wanted = image.entry["files"]
    if others := sorted(set(list_files(image.folder)) - {*wanted, ENTRY}):
        log(f"{image.name}: other files are left alone: {', '.join(others)}")
    if fault := _file_faults(image.folder, wanted):
        yield fault
        return
    try:
        result = image.result
        yield from check_numbers(result)
        yield from check_digests(image)
        yield from check_identities(result, is_full(image), image.chosen)
        yield from check_rgb(image)
        yield from check_formats_agree(image)
        yield from check_photo(image)
        yield from _geometry_faults(image, find)
    except InputError as error:
        yield str(error)
        return
    if not image.entry["reached"]:
        goal = image.entry["goal"]
        but = "" if goal["reached"] is None else f", but {goal['reached']:.4g}"
        yield f"the error {goal['limit']} was not reached{but}"


def _geometry_faults(image: Image, find: Find) -> Iterator[str]:
    """Yield buffers that rays traced again do not give; none where other versions traced them."""
    if image.entry["versions"] == describe_versions():
        job = find(Job.from_description(image.entry["job"]))
        select_measured_sets(job)
        yield from check_geometry(image.result, make_scene(job), is_full(image))


def _version_faults(entry: dict[str, Any], wanted: dict[str, str]) -> Iterator[str]:
    """Yield the versions that rendered an image if they are not those of the data set."""
    kernels = entry["fingerprint"]["kernels"].removeprefix("kernels-")
    here = {**entry["versions"], "kernels": kernels}
    if differences := describe_differences({n: (wanted[n], here.get(n)) for n in wanted}):
        yield f"was rendered by other versions than the data set's: {differences}"


def _file_faults(folder: Path, wanted: dict[str, str]) -> str:
    """Return the files of an image that are missing or changed, as a fault; "" if none."""
    found = hash_files(folder, wanted)
    changed = [name for name in wanted if wanted[name] != found[name]]
    return f"missing or changed files: {', '.join(changed)}" if changed else ""


def _render_again(image: Image, log: Log, find: Find) -> Iterator[str]:
    """Render an image again; yield the buffers that differ."""
    entry = image.entry
    if entry["versions"] != describe_versions():
        log(f"{image.name}: not rendered again, as other versions rendered it")
        return
    try:
        job = find(Job.from_description(image.entry["job"]))
        select_measured_sets(job)
        again = render_job(
            job,
            make_scene(job),
            passes=entry["passes"],
            pass_samples=entry.get("pass_samples"),
            buffers=image.chosen,
        )
        before = image.result
    except InputError as error:
        yield f"cannot be rendered again: {error}"
        return
    now, then = again.record["fingerprint"], entry["fingerprint"]
    if now["kernels"] != then["kernels"]:
        log(f"{image.name}: not compared, as other kernels rendered it")
        return
    if changed := difference(then, now):
        yield f"would be rendered from other input now: {changed}"
        return
    again = held_in(again, image.chosen)
    pairs = (again if is_full(image) else as_lean(again, like=image.halves)[0]).arrays
    there = before.arrays
    differ = [n for n in pairs if n not in there or not np.array_equal(pairs[n], there[n])]
    if differ:
        yield f"rendered again, these buffers differ: {', '.join(differ)}"
    else:
        log(f"{image.name}: rendered again, identical bit for bit")
