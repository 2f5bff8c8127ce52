"""Verify a data set: files, identities of buffers, error goals, and images rendered again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.dataset.files.image_files import hash_files
from photonmap.dataset.files.manifest import describe_differences
from photonmap.dataset.files.reader import Image, open_dataset
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import ENTRY, render_job, select_measured_sets
from photonmap.errors import InputError
from photonmap.results.record import describe_versions
from photonmap.results.result import Result
from photonmap.runtime.fingerprint import difference

ULPS = 8
"""Rounding errors of float32 by which sums and products of buffers may differ."""

Log = Callable[[str], None]


def verify(
    folder: str | PathLike[str], sample: int = 1, log: Log | None = None, seed: int = 0
) -> list[str]:
    """Check every image of a data set, and render a sample again.

    Parameters
    ----------
    folder : of the data set
    sample : number of images to render again with the same number of passes; they are compared bit
        for bit if versions and kernels are those that rendered them, and skipped otherwise
    log : called with a line for each check that passed or was skipped
    seed : draws the sample

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
    names = {image.name for image in images}
    faults = [f"{name}: is missing" for name in images.head["images"] if name not in names]
    for image in images:
        found = [*_faults(image), *_version_faults(image.entry, images.head["versions"])]
        faults += [f"{image.name}: {fault}" for fault in found]
    log(f"{len(images)} images: files, numbers, identities and errors checked")
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = rng.choice(len(images), min(sample, len(images)), replace=False)
    for index in sorted(chosen.tolist()):
        image = images[index]
        faults += [f"{image.name}: {fault}" for fault in _render_again(image, log)]
    return faults


def _faults(image: Image) -> Iterator[str]:
    """Yield the faults of an image that show without rendering it."""
    if fault := _file_faults(image.folder, image.entry["files"]):
        yield fault
        return
    try:
        result = image.result
    except InputError as error:
        yield str(error)
        return
    for name, array in result.arrays.items():
        if np.isnan(array).any():
            yield f"{name} has NaN"
    yield from check_identities(result)
    yield from _check_rgb(image)
    if not image.entry["reached"]:
        goal = image.entry["goal"]
        yield f"the error {goal['limit']} was not reached, but {goal['reached']:.4g}"


def _version_faults(entry: dict[str, Any], wanted: dict[str, str]) -> Iterator[str]:
    """Yield the versions that rendered an image if they are not those of the data set."""
    kernels = entry["fingerprint"]["kernels"].removeprefix("kernels-")
    here = {**entry["versions"], "kernels": kernels}
    if differences := describe_differences({n: (wanted[n], here.get(n)) for n in wanted}):
        yield f"was rendered by other versions than the data set's: {differences}"


def _file_faults(folder: Path, wanted: dict[str, str]) -> str:
    """Return the files in which a folder differs from the manifest, as a fault; "" if none."""
    found = hash_files(folder) if folder.is_dir() else {}
    found.pop(ENTRY, None)
    changed = [name for name in {**wanted, **found} if wanted.get(name) != found.get(name)]
    return f"missing or changed files: {', '.join(changed)}" if changed else ""


def check_identities(result: Result) -> Iterator[str]:
    """Yield the identities of the buffers that do not hold.

    radiance is (emission + direct) + indirect, bit for bit. To `ULPS`, the buffers of light groups
    add up to the whole, direct + indirect is reflectance × shading + residual, and scalar_shading ×
    illuminant is shading.
    """
    whole = (result.emission + result.direct) + result.indirect
    if not np.array_equal(result.radiance, whole):
        yield "radiance is not (emission + direct) + indirect"
    for name in names_where(per_light=True, has_error=True):
        parts = [split[name] for split in result.per_light.values() if name in split]
        if parts and not _close(_sum(parts), [result.buffers[name]]):
            yield f"{name} is not the sum of its light groups"
    product = result.reflectance * result.shading
    if not _close(_sum([result.direct, result.indirect]), [product, result.residual]):
        yield "direct + indirect is not reflectance × shading + residual"
    scalar = result.buffers["scalar_shading"][..., None]
    if not _close(scalar * result.buffers["illuminant"], [result.shading]):
        yield "scalar_shading × illuminant is not shading"


def _check_rgb(image: Image) -> Iterator[str]:
    """Yield a fault if radiance in RGB is not emission + reflectance × shading + residual."""
    rgb = image.rgb
    parts = [rgb["emission"], rgb["reflectance"] * rgb["shading"], rgb["residual"]]
    if not _close(rgb["radiance"], parts):
        yield "radiance in RGB is not emission + reflectance × shading + residual"


def _sum(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.sum(np.array(parts, np.float64), axis=0)


def _close(whole: NDArray[Any], parts: Sequence[NDArray[Any]]) -> bool:
    """Return whether parts add up to a whole within rounding of their magnitudes."""
    scale = np.abs(whole.astype(np.float64)) + _sum([np.abs(part) for part in parts])
    allowed = ULPS * np.finfo(np.float32).eps * scale + np.finfo(np.float32).tiny
    return bool((np.abs(whole - _sum(parts)) <= allowed).all())


def _render_again(image: Image, log: Log) -> Iterator[str]:
    """Render an image again; yield the buffers that differ."""
    from photonmap.dataset.jobs.job_scene import make_scene

    entry = image.entry
    if entry["versions"] != describe_versions():
        log(f"{image.name}: not rendered again, as other versions rendered it")
        return
    try:
        job = Job.from_description(entry["job"])
        select_measured_sets(job)
        again = render_job(job, make_scene(job), passes=entry["passes"])
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
    pairs = again.arrays
    there = before.arrays
    differ = [n for n in pairs if n not in there or not np.array_equal(pairs[n], there[n])]
    if differ:
        yield f"rendered again, these buffers differ: {', '.join(differ)}"
    else:
        log(f"{image.name}: rendered again, identical bit for bit")
