"""What the manifest says of a data set and its images, compared with their files and scenes."""

from __future__ import annotations

import hashlib
import json
import math
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files import image_files
from photonmap.dataset.files.derived_buffers import rgb_method
from photonmap.dataset.files.image_files import BANDS_EXR, BANDS_HDF5, RGB_EXR
from photonmap.dataset.files.inside import fault_of
from photonmap.dataset.files.manifest import FORMAT
from photonmap.dataset.files.reader import Dataset, Image
from photonmap.dataset.files.schema import WHOLE_HEAD_KINDS, misfits
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs.make_dataset import describe_common
from photonmap.dataset.jobs.plan import TEXT, Job
from photonmap.dataset.jobs.render_image import (
    ENTRY,
    describe_lights,
    describe_reflectances,
    describe_render,
    load_entry,
)
from photonmap.dataset.report.page import BINS
from photonmap.io.exr import current_name
from photonmap.results.result import Result
from photonmap.runtime.wording import listed, shown
from photonmap.scene.scene import Scene
from photonmap.spectra.projection import SRGB, projection_onto

_CLOSE = 1e-6
"""By how much numbers of a scene may differ that another machine built."""
_HALF = 2.0**-11
"""By how much half precision rounds, relative to a value."""
_OF_SCENE_AND_ARRAYS = ("lights", "reflectances", "statistics")
"""Keys of entries that do not follow from the job and the record."""
_DEFAULTS = {"lightness": None, "scale": 1.0, "identity": TEXT, "own_noise": True}
"""Values of common settings that earlier heads lack."""
_COPIED = {"full": True, "buffers": None}
"""Keys of the head that entries repeat, and their values where earlier sets lack them."""


def check_head(images: Dataset, sound: Collection[str]) -> Iterator[str]:
    """Yield what the head says that is not so; `sound` are the names of images of right form."""
    head = images.head
    found = list(misfits(head, WHOLE_HEAD_KINDS))
    yield from (f for f in found if head["format"] == FORMAT or not f.endswith(" is missing"))
    if found:
        return
    if len(set(head["images"])) < len(head["images"]):
        yield "images has a name twice"
    if others := [image.name for image in images if image.name not in set(head["images"])]:
        yield f"images lacks {listed(others, 3)}"
    for each in head.get("left_out", ()):
        if why := fault_of(each["scene"].removeprefix("../")):
            yield f"left_out has the scene {shown(each['scene'])}, which {why}"
    entries = [entry for entry in images.entries if entry["name"] in sound]
    if entries:
        jobs = [Job.from_description(entry["job"]) for entry in entries]
        yield from _settings_faults(head, jobs)
        yield from _choice_faults(head.get("choices"), jobs)


def _settings_faults(head: Mapping[str, Any], jobs: Sequence[Job]) -> Iterator[str]:
    """Yield where the settings in the head are not those of the images."""
    sizes: dict[str, set[tuple[int, int]]] = defaultdict(set)
    for job in jobs:
        sizes[part_of(job.geometry)].add(job.common.size)
        here, there = describe_common(job.common), _DEFAULTS | head["common"]
        for name in {**there, **here}.keys() - {"size"}:
            if there.get(name) != here.get(name, TEXT):
                told = shown(there.get(name)), shown(here.get(name))
                yield f"common.{name} is {told[0]} in the head, but {told[1]} of {job.name}"
    for part, found in sizes.items():
        wanted = head.get("split_sizes", {}).get(part, head["common"]["size"])
        if found != {tuple(wanted)}:
            names = ", ".join(f"{width}x{height}" for width, height in sorted(found))
            yield f"the size of {part} is {wanted[0]}x{wanted[1]} in the head, but {names} in jobs"


def _choice_faults(choices: Mapping[str, Any] | None, jobs: Sequence[Job]) -> Iterator[str]:
    """Yield where the options that chose the images did not choose these."""
    if choices is None:
        return
    seeds = {job.seed for job in jobs}
    first, count = choices["seed"], choices["count"]
    if count > len(jobs) or not seeds >= {*range(first, first + count)}:
        yield f"choices.seed {first} and choices.count {count} are not those of the images' scenes"
    for name in ("materials", "lightness", "scale"):
        there = {getattr(job.common, name) for job in jobs}
        if choices[name] is not None and there != {choices[name]}:
            yield f"choices.{name} is {shown(choices[name])}, but {listed(there, 3)} of the images"
    lit = {job.illumination for job in jobs}
    if unused := [name for name in choices["illuminations"] if name not in lit]:
        yield f"choices.illuminations has {listed(unused, 3)}, which no image has"


def check_entry(image: Image, head: Mapping[str, Any]) -> Iterator[str]:
    """Yield what an entry says that the image's files, its job and the head do not."""
    entry, result = image.entry, image.result
    wanted = {name: head.get(name, usual) for name, usual in _COPIED.items()}
    job = Job.from_description(entry["job"])
    try:
        told = describe_render(job, result)
    except (KeyError, TypeError, AttributeError) as error:
        yield f"the record in its files is damaged ({error!r})"
        return
    told = {name: value for name, value in told.items() if name not in _OF_SCENE_AND_ARRAYS}
    rgb = told.pop("rgb")
    del told["job"]  # from which the rest follows
    yield from _differences(_COPIED | entry, wanted, "in the head")
    yield from _differences({"together": None} | entry, told, "by its job and its files")
    yield from _differences(entry.get("rgb", {}), rgb, "by its job and its files", "rgb.", _CLOSE)
    if list(result.size) != list(job.common.size):
        there, here = (shown(list(size)) for size in (result.size, job.common.size))
        yield f"the size of its files is {there}, but {here} of its job"
    own = image.folder / ENTRY
    if own.is_file() and load_entry(image.folder) != entry:
        yield f"{ENTRY} in its folder is not what the manifest says of it"
    yield from _photo_faults(image, head)
    if "arrays" in entry:
        in_file = set(image_files.list_arrays(image.folder))
        if differ := sorted(in_file ^ set(map(current_name, entry["arrays"]))):
            yield f"arrays are not those of its file: {listed(differ, 3)}"
    if "statistics" in entry:
        yield from check_statistics(image)


def check_files(image: Image, head: Mapping[str, Any]) -> Iterator[str]:
    """Yield the files that an image should have, or that readers open, but the manifest lacks."""
    listed_files, chosen = set(image.entry["files"]), image.chosen
    shown_names = [n for n in image_files.PREVIEWED if chosen is None or n in chosen]
    wanted = {
        "exr": {BANDS_EXR, RGB_EXR},
        "hdf5": {BANDS_HDF5},
        "png": {f"{name}.png" for name in shown_names},
    }
    for format_, names in wanted.items():
        if format_ in head["formats"] and (missing := names - listed_files):
            yield f"files lacks {listed(sorted(missing), 3)} of the format {format_}"
        if format_ not in head["formats"] and (more := names & listed_files):
            yield f"files has {listed(sorted(more), 3)}, but the set has no format {format_}"
    read = set().union(*wanted.values())
    unlisted = [
        name
        for name in image_files.list_files(image.folder)
        if name not in listed_files and (name in read or name.startswith(image_files.READ_FOLDERS))
    ]
    if unlisted:
        yield f"files lacks {listed(unlisted, 3)}, which readers open"


def _photo_faults(image: Image, head: Mapping[str, Any]) -> Iterator[str]:
    """Yield where photo, entry and the head's sensor disagree."""
    sensor, told = head.get("sensor"), image.entry.get("photo")
    if (sensor is None) != (told is None):
        yield f"photo is {shown(told)}, but the set's sensor is {shown(sensor)}"
    elif sensor is not None and told is not None:
        record = image.photo.record
        yield from _differences(told, image_files.describe_photo(record), "in its file", "photo.")
        curves = json.dumps(record["sensitivities"])
        digest = hashlib.sha256(curves.encode()).hexdigest()[: len(sensor["sensitivities"])]
        used = {**record["sensor"], "sensitivities": digest}
        if json.loads(json.dumps(used)) != sensor:
            names = [name for name in {**used, **sensor} if used.get(name) != sensor.get(name)]
            yield f"the photo is not by the set's sensor, as {listed(names, 3)} differ"


def check_scene(image: Image, scene: Scene) -> Iterator[str]:
    """Yield what an entry says of lights, surfaces and the camera that the scene does not."""
    result = image.result
    told = {
        "lights": describe_lights(scene, result),
        "reflectances": describe_reflectances(scene, result.bands),
    }
    if scene.camera is not None:
        told["camera"] = {"framed": False, **scene.camera.describe(*result.size)}
    yield from _differences(image.entry, told, "in the scene", close=_CLOSE)


def _differences(
    there: Mapping[str, Any],
    wanted: Mapping[str, Any],
    where: str,
    prefix: str = "",
    close: float = 0.0,
) -> Iterator[str]:
    """Yield the values that a manifest has otherwise; keys that old manifests lack are left out."""
    for name, value in json.loads(json.dumps(wanted)).items():
        if name in there and (found := _first_difference(there[name], value, close)):
            path, one, other = found
            told = f"{prefix}{name}{path} is {shown(one)}"
            yield f"{told} in the manifest, but {shown(other)} {where}"


def _first_difference(one: Any, other: Any, close: float) -> tuple[str, Any, Any] | None:
    """Return the place where two values from JSON differ, and both values there; None if nowhere.

    Numbers may differ by rounding, `close`.
    """
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        pairs = [(f".{name}", one[name], other[name]) for name in one]
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = [(f"[{n}]", *pair) for n, pair in enumerate(zip(one, other, strict=True))]
    elif close and {type(one), type(other)} <= {float, int}:
        is_same = math.isclose(one, other, rel_tol=close, abs_tol=2 * close)
        return None if is_same else ("", one, other)
    else:
        return None if type(one) is type(other) and one == other else ("", one, other)
    for name, first, second in pairs:
        if found := _first_difference(first, second, close):
            return f"{name}{found[0]}", found[1], found[2]
    return None


def check_statistics(image: Image) -> Iterator[str]:
    """Yield the statistics in an entry that are not those of the arrays.

    They were made before lean files rounded the arrays, by which a share may change, and a value
    move to the next bin of a histogram.
    """
    result, told, rgb = image.result, image.entry["statistics"], image.entry["rgb"]
    step = 0.0 if image.entry.get("full", True) else _HALF
    valid = result.buffers["valid"]
    if told["valid"] != float(valid.mean()):
        yield f"statistics.valid is {told['valid']}, but {float(valid.mean())} of its pixels are"
    values = result.reflectance[valid].astype(np.float64)
    yield from _histogram_faults("reflectance", told, values, step * values + 1e-6)
    for name, channel in (("illuminant_red", 0), ("illuminant_blue", 2)):
        yield from _histogram_faults(name, told, *_fractions(result, valid, step, channel))
    yield from _share_faults(image, told, rgb, step)


def _fractions(
    result: Result, valid: NDArray[np.bool_], step: float, channel: int
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return a channel's fraction of the light in sRGB, NaN where it is not known; and its error.

    Rounding may decide whether a channel is negative; the error is infinite there.
    """
    matrix = np.asarray(projection_onto(result.bands, SRGB, rgb_method(result.bands)))
    shading = result.shading[valid].astype(np.float64)
    light, off = shading @ matrix.T, 2.0 * step * (np.abs(shading) @ np.abs(matrix).T)
    whole = light.sum(axis=-1)
    is_known = (light >= 0.0).all(axis=-1) & light.any(axis=-1)
    safe = np.where(is_known, whole, 1.0)
    values = np.where(is_known, light[:, channel] / safe, np.nan)
    errors = (off[:, channel] + light[:, channel] / safe * off.sum(axis=-1)) / np.abs(safe)
    is_open = (np.abs(light) <= off + 1e-6 * np.abs(whole)[:, None]).any(axis=-1)
    return values, np.where(is_open, np.inf, np.abs(errors) + 1e-6)


def _histogram_faults(
    name: str, told: Mapping[str, Any], values: NDArray[Any], errors: NDArray[Any]
) -> Iterator[str]:
    """Yield a fault if a histogram cannot be that of values known to within errors."""
    there, edges = np.cumsum(told[name]), np.linspace(0.0, 1.0, BINS + 1)[1:]
    flat, slack = np.ravel(values), np.ravel(errors)
    is_open, is_known = np.isinf(slack), np.isfinite(flat)
    sure = is_known & ~is_open
    for place, edge in enumerate(edges):
        is_last = place == BINS - 1
        low = int((sure & (is_last | (flat + slack < edge))).sum())
        high = int((sure & (is_last | (flat - slack < edge))).sum()) + int(is_open.sum())
        if len(there) != BINS or not low <= there[place] <= high:
            yield f"statistics.{name} is not the histogram of its pixels"
            return


def _share_faults(
    image: Image, told: Mapping[str, Any], rgb: Mapping[str, Any], step: float
) -> Iterator[str]:
    """Yield shares and ratios of light that are not those of the arrays."""
    result, space = image.result, image.rgb
    if image.chosen is None or {"direct", "indirect"} <= {*image.chosen}:
        direct = result.direct.astype(np.float64)
        whole = float(np.abs(direct + result.indirect).sum())
        share = float(np.abs(direct).sum()) / whole if whole else None
        if not _near(told["direct_share"], share, 4.0 * step):
            yield f"statistics.direct_share is {told['direct_share']}, but {share} of its light is"
    radiance = space["radiance"].astype(np.float64)
    if "emission" in space and "residual" in space:
        light = float(np.linalg.norm(radiance - space["emission"]))
        ratio = (
            float(np.linalg.norm(space["residual"].astype(np.float64))) / light if light else 0.0
        )
        parts = ("radiance", "emission", "residual")
        loss = sum(float(np.linalg.norm(space[name].astype(np.float64))) for name in parts)
        allowed = _MATRIX * (step + 2.0**-24) * loss / light if light else 0.0
        if not _near(rgb["residual"], ratio, allowed * (1.0 + ratio)):
            yield f"rgb.residual is {rgb['residual']}, but {ratio} in its files"
    valid = result.buffers["valid"]
    if valid.any() and rgb.get("negative") is not None:
        seen = radiance[valid]
        off = _MATRIX * (step + 2.0**-24) * np.abs(seen).max(axis=-1, keepdims=True)
        least, most = ((seen < end).any(axis=-1).mean() for end in (-off, off))
        if not float(least) <= rgb["negative"] <= float(most):
            yield f"rgb.negative is {rgb['negative']}, but {float(least)} in its files"


_MATRIX = 8.0
"""By how much projection to RGB may enlarge a rounding error, relative to the largest channel."""


def _near(one: float | None, other: float | None, allowed: float) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=1e-9, abs_tol=allowed)
