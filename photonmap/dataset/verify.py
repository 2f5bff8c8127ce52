"""Verify a data set: files, identities, errors reached, and images rendered again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files import hash_files
from photonmap.dataset.jobs import Job
from photonmap.dataset.manifest import told_apart
from photonmap.dataset.produce import ENTRY, name_sets, render_job
from photonmap.dataset.reader import Image, open_dataset
from photonmap.errors import InputError
from photonmap.fingerprint import difference
from photonmap.output import name_errors
from photonmap.record import describe_versions
from photonmap.result import Result

ULPS = 8
"""Rounding of float32 that sums and products of buffers may differ by."""

Tell = Callable[[str], None]


def verify(
    folder: str | PathLike[str], sample: int = 1, tell: Tell | None = None, seed: int = 0
) -> list[str]:
    """Check every image of a data set, and render some again.

    Parameters
    ----------
    folder : of the data set
    sample : how many images to render again, to the same number of passes; they are compared bit
        for bit where versions and kernels are those that rendered them, and else left out
    tell : is told what was found right
    seed : draws the sample

    Returns
    -------
    What is wrong, a line each: empty if all is well

    Raises
    ------
    InputError : the folder holds no data set, or `sample` is below 0
    """
    if sample < 0:
        raise InputError(f"sample {sample} must be a number of images from 0")
    tell = tell or (lambda line: None)
    images = open_dataset(folder)
    names = {image.name for image in images}
    faults = [f"{name}: is missing" for name in images.head["images"] if name not in names]
    for image in images:
        told = [*_faults(image), *_other_code(image.entry, images.head["versions"])]
        faults += [f"{image.name}: {fault}" for fault in told]
    tell(f"{len(images)} images: files, numbers, identities and errors checked")
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = rng.choice(len(images), min(sample, len(images)), replace=False)
    for index in sorted(chosen.tolist()):
        image = images[index]
        faults += [f"{image.name}: {fault}" for fault in _render_again(image, tell)]
    return faults


def _faults(image: Image) -> Iterator[str]:
    """Tell what is wrong with an image, without rendering it."""
    if told := _wrong_files(image.folder, image.entry["files"]):
        yield told
        return
    try:
        result = image.result
    except InputError as error:
        yield str(error)
        return
    for name, array in {**result.buffers, **name_errors(result)}.items():
        if np.isnan(array).any():
            yield f"{name} has NaN"
    yield from check_identities(result)
    yield from _check_rgb(image)
    if not image.entry["reached"]:
        goal = image.entry["goal"]
        yield f"the error {goal['limit']} was not reached, but {goal['reached']:.4g}"


def _other_code(entry: dict[str, Any], wanted: dict[str, str]) -> Iterator[str]:
    """Tell of which versions an image is, where they are not those of the set."""
    kernels = entry["fingerprint"]["kernels"].removeprefix("kernels-")
    here = {**entry["versions"], "kernels": kernels}
    if told := told_apart({name: (wanted[name], here.get(name)) for name in wanted}):
        yield f"is of other versions than the set: {told}"


def _wrong_files(folder: Path, wanted: dict[str, str]) -> str:
    """Tell in which files a folder differs from the manifest; "" if in none."""
    found = hash_files(folder) if folder.is_dir() else {}
    found.pop(ENTRY, None)
    changed = [name for name in {**wanted, **found} if wanted.get(name) != found.get(name)]
    return f"missing or changed files: {', '.join(changed)}" if changed else ""


def check_identities(result: Result) -> Iterator[str]:
    """Tell which identities of the buffers do not hold.

    radiance is (emission + direct) + indirect, bit for bit; the buffers of groups of lights add up
    to the whole; direct + indirect is reflectance × shading + residual, and scalar_shading ×
    illuminant is shading, to `ULPS`.
    """
    whole = (result.emission + result.direct) + result.indirect
    if not np.array_equal(result.radiance, whole):
        yield "radiance is not (emission + direct) + indirect"
    for name in ("direct", "indirect", "shading"):
        parts = [split[name] for split in result.per_light.values() if name in split]
        if parts and not _close(_sum(parts), [result.buffers[name]]):
            yield f"{name} is not the sum of its groups of lights"
    product = result.reflectance * result.shading
    if not _close(_sum([result.direct, result.indirect]), [product, result.residual]):
        yield "direct + indirect is not reflectance × shading + residual"
    scalar = result.buffers["scalar_shading"][..., None]
    if not _close(scalar * result.buffers["illuminant"], [result.shading]):
        yield "scalar_shading × illuminant is not shading"


def _check_rgb(image: Image) -> Iterator[str]:
    """Tell where radiance in RGB is not emission + reflectance × shading + residual."""
    rgb = image.rgb
    parts = [rgb["emission"], rgb["reflectance"] * rgb["shading"], rgb["residual"]]
    if not _close(rgb["radiance"], parts):
        yield "radiance in RGB is not emission + reflectance × shading + residual"


def _sum(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.sum(np.array(parts, np.float64), axis=0)


def _close(whole: NDArray[Any], parts: Sequence[NDArray[Any]]) -> bool:
    """Tell whether parts add up to a whole but for rounding of the largest of them."""
    scale = np.abs(whole.astype(np.float64)) + _sum([np.abs(part) for part in parts])
    allowed = ULPS * np.finfo(np.float32).eps * scale + np.finfo(np.float32).tiny
    return bool((np.abs(whole - _sum(parts)) <= allowed).all())


def _render_again(image: Image, tell: Tell) -> Iterator[str]:
    """Render an image once more; tell which buffers differ."""
    from photonmap.dataset.sources import make_scene

    entry = image.entry
    if entry["versions"] != describe_versions():
        tell(f"{image.name}: not rendered again, as other versions made it")
        return
    try:
        job = Job.from_description(entry["job"])
        name_sets(job)
        again = render_job(job, make_scene(job), passes=entry["passes"])
        before = image.result
    except InputError as error:
        yield f"cannot be rendered again: {error}"
        return
    now, then = again.record["fingerprint"], entry["fingerprint"]
    if now["kernels"] != then["kernels"]:
        tell(f"{image.name}: not compared, as other kernels made it")
        return
    if told := difference(then, now):
        yield f"is made from something else now: {told}"
        return
    pairs = {**again.buffers, **name_errors(again)}
    there = {**before.buffers, **name_errors(before)}
    differ = [n for n in pairs if n not in there or not np.array_equal(pairs[n], there[n])]
    if differ:
        yield f"rendered again, these differ: {', '.join(differ)}"
    else:
        tell(f"{image.name}: rendered again, the same bit for bit")
