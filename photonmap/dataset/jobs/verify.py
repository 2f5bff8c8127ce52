"""Verify a data set: files, identities of buffers, error goals, and images rendered again."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.dataset.files import image_files
from photonmap.dataset.files.lean import as_lean, fits_half, held_in, restored, to_half
from photonmap.dataset.files.manifest import (
    FORMAT,
    HEAD,
    SENSOR,
    Head,
    describe_differences,
    kept_as,
    read_head,
    warn_of_left_out,
)
from photonmap.dataset.files.reader import Image, open_dataset
from photonmap.dataset.files.schema import GROWN_HEAD_KINDS, faults_of_entry
from photonmap.dataset.jobs.job_scene import Find, input_finder, make_scene
from photonmap.dataset.jobs.manifest_checks import (
    check_entry,
    check_files,
    check_head,
    check_scene,
)
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import ENTRY, render_jobs, select_measured_sets
from photonmap.errors import InputError
from photonmap.io.exr import current_name
from photonmap.results.record import describe_versions
from photonmap.results.result import Result
from photonmap.runtime.fingerprint import difference
from photonmap.scene.scene import Scene

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
    read_head(folder, GROWN_HEAD_KINDS)
    warn_of_left_out(images.head)
    find = input_finder(images.folder, scenes)
    names = {image.name for image in images}
    faults = [f"{name}: is missing" for name in images.head["images"] if name not in names]
    sound = set()
    for image in images:
        if found := faults_of_entry(image.entry, images.head["format"] != FORMAT):
            faults += [f"{image.name}: {fault}" for fault in found]
            continue
        sound.add(image.name)
        found = [*_faults(image, images.head, log, find)]
        found += version_faults(image.entry, images.head["versions"])
        faults += [f"{image.name}: {fault}" for fault in found]
    faults += [f"{HEAD}: {fault}" for fault in check_head(images, sound)]
    rng = np.random.Generator(np.random.PCG64(seed))
    chosen = rng.choice(len(images), min(sample, len(images)), replace=False)
    for index in sorted(chosen.tolist()):
        image = images[index]
        if image.name in sound:
            faults += [f"{image.name}: {fault}" for fault in _render_again(image, log, find)]
    count = "1 fault" if len(faults) == 1 else f"{len(faults) or 'no'} faults"
    checked = "files, numbers, identities, geometry and errors checked"
    log(f"{len(images)} images: {checked}, {count}")
    return faults


def _faults(image: Image, head: Head, log: Log, find: Find) -> Iterator[str]:
    """Yield the faults of an image that show without rendering it."""
    wanted = image.entry["files"]
    if others := sorted(set(image_files.list_files(image.folder)) - {*wanted, ENTRY}):
        log(f"{image.name}: other files are left alone: {', '.join(others)}")
    try:
        found = image_files.hash_files(image.folder, wanted)
        if changed := [name for name in wanted if wanted[name] != found[name]]:
            yield f"missing or changed files: {', '.join(changed)}"
            return
        yield from check_files(image, head)
        result = image.result
        yield from (f"{n} has NaN" for n, array in result.arrays.items() if np.isnan(array).any())
        yield from check_digests(image)
        yield from check_identities(result, is_full(image), image.chosen)
        yield from check_rgb(image)
        yield from check_formats_agree(image)
        yield from check_photo(image)
        yield from check_entry(image, head)
        yield from _scene_faults(image, find)
    except InputError as error:
        yield str(error)
        return
    if not image.entry["reached"]:
        goal = image.entry["goal"]
        but = "" if goal["reached"] is None else f", but {goal['reached']:.4g}"
        yield f"the error {goal['limit']} was not reached{but}"


def _scene_faults(image: Image, find: Find) -> Iterator[str]:
    """Yield what the scene built again does not give; nothing where other versions rendered it."""
    told = Job.from_description(image.entry["job"])
    is_sound = told.name == image.name and told.common.size == image.result.size
    if is_sound and image.entry["versions"] == describe_versions():
        job = find(told)
        select_measured_sets(job)
        scene = make_scene(job)
        yield from check_geometry(image.result, scene, is_full(image))
        yield from check_scene(image, scene)


def version_faults(entry: dict[str, Any], wanted: dict[str, str]) -> Iterator[str]:
    """Yield the versions that rendered an image if they are not those of the data set."""
    kernels = entry["fingerprint"]["kernels"].removeprefix("kernels-")
    here = {**entry["versions"], "kernels": kernels}
    pairs = {name: (wanted.get(name), here.get(name)) for name in {**wanted, **here}}
    if differences := describe_differences(pairs):
        yield f"was rendered by other versions than the data set's: {differences}"


def _render_again(image: Image, log: Log, find: Find) -> Iterator[str]:
    """Render an image again; yield the buffers that differ."""
    entry = image.entry
    if entry["versions"] != describe_versions():
        log(f"{image.name}: not rendered again, as other versions rendered it")
        return
    try:
        told = [{**entry["job"], **light} for light in entry.get("together") or [{}]]
        jobs = [find(Job.from_description(each)) for each in told]
        select_measured_sets(jobs[0])
        scenes, passes = [make_scene(job) for job in jobs], entry["passes"]
        results = render_jobs(jobs, scenes, passes=passes, buffers=image.chosen)
        number = [job.illumination for job in jobs].index(entry["job"]["illumination"])
        again = next(islice(results, number, None))
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
    again = again if is_full(image) else as_lean(again, like=image.halves)[0]
    there = before.arrays
    differ = [n for n, found in again.arrays.items() if not _equal(there.get(n), found)]
    if (count := again.record["passes"]) != passes:
        yield f"rendered again, its error is reached after {count} passes, not {passes}"
    elif differ:
        yield f"rendered again, these buffers differ: {', '.join(differ)}"
    else:
        log(f"{image.name}: rendered again, identical bit for bit")


ULPS, HALF_ULPS = 8, 2
"""Rounding errors of float32, and of half precision, by which sums and products may differ."""
_PROJECTED = 8
"""By how much projection to RGB may enlarge rounding, relative to the largest value."""
_AT_CENTRE = ("depth", "distance", "normal", "object_id", "material_id")


def is_full(image: Image) -> bool:
    """Return whether an image's files hold everything in single precision."""
    return image.entry.get("full", True)


def check_digests(image: Image) -> Iterator[str]:
    """Yield the arrays that are not those that were rendered."""
    digests_then = image.entry.get("arrays", {})
    wanted = {current_name(name): digest for name, digest in digests_then.items()}
    found = image_files.digests(image.result)
    if changed := [name for name, digest in wanted.items() if found.get(name) != digest]:
        yield f"arrays differ from those that were rendered: {', '.join(changed)}"


def check_identities(
    result: Result, full: bool = True, chosen: Collection[str] | None = None
) -> Iterator[str]:
    """Yield the identities of the buffers that do not hold.

    radiance is (emission + direct) + indirect, bit for bit where files are full. To rounding, the
    buffers of light groups add up to the whole, direct + indirect is reflectance × shading +
    fluorescence + residual, and scalar_shading × illuminant is shading. Those of buffers that the
    files were not asked to hold are left alone.
    """

    def holds(*names: str) -> bool:
        return chosen is None or {*names} <= {*chosen}

    if holds("emission", "direct", "indirect"):
        whole = (result.emission + result.direct) + result.indirect
        parts = [result.emission, result.direct, result.indirect]
        if not (np.array_equal(result.radiance, whole) if full else _close(whole, parts, full)):
            yield "radiance is not (emission + direct) + indirect"
    for name in names_where(per_light=True, has_error=True):
        parts = [split[name] for split in result.per_light.values() if name in split]
        if parts and not _close(_sum(parts), [result.buffers[name]], full):
            yield f"{name} is not the sum of its light groups"
    glows = result.record.get("effects", {}).get("fluorescence", {}).get("on", False)
    if holds("direct", "indirect", "residual", *["fluorescence"] * glows):
        product = result.reflectance * result.shading
        parts = [product, result.fluorescence, result.residual]
        if not _close(_sum([result.direct, result.indirect]), parts, full):
            yield "direct + indirect is not reflectance × shading + fluorescence + residual"
    scalar = result.buffers["scalar_shading"][..., None]
    if not _close(scalar * result.buffers["illuminant"], [result.shading], full):
        yield "scalar_shading × illuminant is not shading"


def check_rgb(image: Image) -> Iterator[str]:
    """Yield a fault if radiance in RGB is not the sum of its parts."""
    rgb, chosen = image.rgb, image.chosen
    if chosen is not None and not {"emission", "residual"} <= {*chosen}:
        return
    product = rgb["reflectance"] * rgb["shading"]
    rest = [rgb.get(name, np.zeros_like(product)) for name in ("fluorescence", "residual")]
    if not _close(rgb["radiance"], [rgb["emission"], product, *rest], is_full(image)):
        yield "radiance in RGB is not emission + reflectance × shading + fluorescence + residual"


def check_formats_agree(image: Image) -> Iterator[str]:
    """Yield the arrays of HDF5 files that differ from those that the image is read from."""
    if not (image.folder / image_files.BANDS_HDF5).is_file():
        return
    try:
        there = restored(image_files.read_hdf5(image.folder / image_files.BANDS_HDF5)).arrays
        frames = image_files.read_hypersim(image.folder)
    except InputError as error:
        yield str(error)
        return
    here = image.result.arrays
    if differ := _differing(here, there):
        yield f"{image_files.BANDS_HDF5} has other arrays than the image: {', '.join(differ)}"
    wanted = image_files.hypersim_images(image.result, image.rgb)
    if not is_full(image) and not (image.folder / image_files.RGB_EXR).is_file():
        colors = (frames[n] for n in frames if n.endswith("color.hdf5"))
        light = max((float(np.abs(color).max()) for color in colors), default=0.0)
        wanted |= {
            n: frames[n]
            for n in wanted
            if n in frames and _rounded(wanted[n], frames[n], light if "residual" in n else 0.0)
        }
    if differ := _differing(wanted, frames):
        yield f"Hypersim's files have other arrays than the image: {', '.join(differ)}"


def check_geometry(result: Result, scene: Scene, full: bool = True) -> Iterator[str]:
    """Yield the buffers at the pixels' centres that rays traced again do not give."""
    from photonmap.integrators.look import Onlooker

    assert scene.camera is not None
    seen = Onlooker(scene).see(scene.camera, result.size, _AT_CENTRE)
    if not full:
        seen = {n: to_half(image) if fits_half(n, image) else image for n, image in seen.items()}
    there = {name: result.buffers[name] for name in seen if name in result.buffers}
    if differ := [name for name, image in there.items() if not np.array_equal(image, seen[name])]:
        yield f"rays traced again give other values: {', '.join(differ)}"


def _differing(here: dict[str, NDArray[Any]], there: dict[str, NDArray[Any]]) -> list[str]:
    return [name for name in {**here, **there} if not _equal(here.get(name), there.get(name))]


def _rounded(one: NDArray[Any], other: NDArray[Any], scale: float) -> bool:
    """Return whether RGB images agree of which one was projected after its bands were rounded.

    `scale` is the largest value of what a difference was made from.
    """
    if one.shape != other.shape or one.dtype.kind != "f":
        return False
    allowed = _PROJECTED * float(np.finfo(np.float16).eps) * max(scale, float(np.abs(other).max()))
    return bool((np.abs(one - other) <= allowed).all())


def _equal(one: NDArray[Any] | None, other: NDArray[Any] | None) -> bool:
    return one is not None and other is not None and np.array_equal(one, other)


def _sum(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.sum(np.array(parts, np.float64), axis=0)


def _close(whole: NDArray[Any], parts: Sequence[NDArray[Any]], full: bool) -> bool:
    """Return whether parts add up to a whole within rounding of their magnitudes."""
    scale = np.abs(whole.astype(np.float64)) + _sum([np.abs(part) for part in parts])
    kind = np.finfo(np.float32 if full else np.float16)
    smallest = kind.tiny if full else 8 * kind.smallest_subnormal
    allowed = (ULPS if full else HALF_ULPS) * float(kind.eps) * scale + float(smallest)
    return bool((np.abs(whole - _sum(parts)) <= allowed).all())


def check_photo(image: Image) -> Iterator[str]:
    """Yield what is wrong with a photo: it is exposed again, if its sensitivities are known."""
    if image.entry.get("photo") is None:
        return
    from photonmap.capture.expose import expose
    from photonmap.capture.sensor import Sensor
    from photonmap.spectra.sensitivities import table_of

    try:
        photo = image.photo
        sensor = Sensor(**photo.record["sensor"])
        path = table_of(sensor.camera)
        kept = path and image.folder.parent / kept_as(SENSOR, path)
        if kept is None or kept.is_file():
            sensor = sensor if kept is None else replace(sensor, camera=str(kept))
            again = expose(image.result, sensor, photo.record["seed"])
            if not (_equal(again.raw, photo.raw) and _equal(again.truth, photo.truth)):
                yield "the photo is not that of the radiance"
    except (InputError, TypeError) as error:
        yield f"the photo cannot be checked: {error}"
