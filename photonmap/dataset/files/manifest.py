"""The manifest of a data set: manifest.json describes the set, manifest.jsonl each image."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.dataset.files.inside import check_inside, inside
from photonmap.dataset.files.schema import GROWN_HEAD_KINDS, HEAD_KINDS, misfits
from photonmap.errors import InputError, warn
from photonmap.runtime.wording import enumerated, shown
from photonmap.runtime.writing import check_output_folder, naming_written, replacing
from photonmap.spectra.curves import EXTRAPOLATE
from photonmap.spectra.sensitivities import table_of

HEAD, LINES = "manifest.json", "manifest.jsonl"
FORMAT = "photonmap data set 2"
READABLE = (FORMAT, "photonmap data set 1")
"""Formats that can be read; the first version's images are full, and have no digests."""
_FILES = {"formats": "--format", "full": "--full", "sensor": "--sensor", "buffers": "--buffers"}
"""Options that decide what files hold, apart from what decides the arrays, by key of the head."""
CHOICES = ("seed", "count", "illuminations", "materials", "lightness", "scale")
"""Options, beside the preset, that decide which images there are; of the head's key `choices`."""
_SHARED = ("bands", "size", "pixel", "error", "rgb")
"""Options that all images share; the head's key `common` has them."""
_NOT_COMPARED = ("munsell", "illuminants", "identity", "inputs")
"""Names of files, what identifies them, and the digest of what is in them, which has words."""
_KEYS = {"name", "geometry", "job", "files"}  # some of the keys that the entry of every image has


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


_JSON = json.JSONDecoder(parse_constant=_refuse_constant)
_AGAIN = "run the data set again with --resume"

Pairs = dict[str, tuple[Any, Any]]
Head = dict[str, Any]


def check_code(wanted: dict[str, str]) -> None:
    """Check that the versions here are those wanted, so that images are the same bit for bit."""
    from photonmap.results.record import describe_code

    here = describe_code()
    pairs = {name: (wanted[name], here.get(name)) for name in wanted}
    if differences := describe_differences(pairs):
        problem = f"this worker has other versions: {differences}"
        raise InputError(f"{problem}; install those of the data set")


def check_dataset_folder(path: str | PathLike[str], head: dict[str, Any], resume: bool) -> Path:
    """Check that a data set of this head may be started in a folder, or resumed there."""
    folder = check_output_folder(path, "the data set")
    if not folder.is_dir() or all(path.name.startswith(".") for path in folder.iterdir()):
        return folder
    if not (folder / HEAD).is_file():
        raise InputError("holds other files; choose a new or an empty folder", folder)
    there = read_head(folder, GROWN_HEAD_KINDS)
    if not resume:
        raise InputError("holds a data set already; add --resume, or choose another folder", folder)
    if difference := _difference(there, head):
        remedy = "choose another folder, or restore what the data set was begun with"
        raise InputError(f"holds another data set: {difference}; {remedy}", folder)
    return folder


def _difference(there: Head, here: Head) -> str:
    """Describe how two heads differ in what the images of one set share; "" if they do not."""
    if there["format"] != here["format"]:
        return describe_differences({"format": (there["format"], here["format"])})
    options = {option: (there.get(key), here[key]) for key, option in _FILES.items()}
    options |= _common(there["common"], here["common"])
    options["--sensor"] = (_sensor(there), _sensor(here))
    begun = [_begun(name, *pair) for name, pair in options.items() if pair[0] != pair[1]]
    if there["common"].get("inputs") != here["common"]["inputs"]:
        begun.append("with other curves of bands or measured sets")
    words = f"it was begun {' and '.join(begun)}" if begun else ""
    pairs = {name: (there["versions"].get(name), own) for name, own in here["versions"].items()}
    versions = describe_differences(pairs)
    if not words and not versions and not set(there["images"]) & set(here["images"]):
        return (
            f"none of its images is asked for (preset {there['preset']} there, {here['preset']} "
            "here), as scenes, seeds, views or lights differ, or what is in their files"
        )
    return "; ".join(filter(None, [words, versions]))


def describe_differences(pairs: Pairs) -> str:
    """Describe the pairs whose values, there and here, differ; "" if none does."""
    return ", ".join(
        f"{name} {_typed(there)} there, {_typed(here)} here"
        for name, (there, here) in pairs.items()
        if there != here
    )


def _common(there: dict[str, Any], here: dict[str, Any]) -> Pairs:
    """Return the settings of all images by option, but for files that `inputs` tells apart."""
    there = {"own_noise": True, **there}
    pairs = {name: (there.get(name), here[name]) for name in here if name not in _NOT_COMPARED}
    if here.get("identity"):
        for name in CURVES:
            if all(map(table_of, pairs[name])):
                del pairs[name]
    return {f"--{name.replace('_', '-')}": pair for name, pair in pairs.items()}


def _sensor(head: Head) -> dict[str, Any] | None:
    """Return what a head says of its sensor, but for the name of its file of sensitivities."""
    sensor = head.get("sensor")
    if sensor is None or table_of(sensor["camera"]) is None:
        return sensor
    return {**sensor, "camera": "a file"}


def _begun(option: str, there: Any, here: Any) -> str:
    """Say what was given, or left out, when a set was begun.

    >>> _begun("--full", False, True), _begun("--size", [8, 6], [4, 3])
    ('without --full', 'with --size 8x6, not 4x3')
    """
    if option == "--recolor":
        return f"with recolor = {str(bool(there)).lower()} in its preset"
    if there is None or there is False:
        return f"without {option}"
    if isinstance(there, dict):
        return f"with {option}" if here is None else f"with another {option}"
    given = "" if there is True else f" {_typed(there, option)}"
    other = f", not {_typed(here, option)}" if here else ""
    return f"with {option}{given}{other}"


def _typed(value: Any, option: str = "") -> str:
    """Return a value as it is typed."""
    if isinstance(value, list | tuple):
        return ("x" if option == "--size" else ",").join(map(str, value))
    return "none" if value is None else str(value)


def read_head(folder: str | PathLike[str], kinds: Any = HEAD_KINDS) -> dict[str, Any]:
    """Return the head of a data set, in which values of some kinds must be."""
    path = Path(folder) / HEAD
    try:
        head = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("does not hold a data set; choose a folder that does", folder) from None
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"is damaged and cannot be read ({error})", path) from None
    if not isinstance(head, dict) or head.get("format") not in READABLE:
        raise InputError("does not describe a data set of this version", path)
    if fault := next(misfits(head, kinds), ""):
        raise InputError(f"is damaged: {fault}; {_AGAIN}", path)
    for name in head["images"]:
        check_inside(name, path, is_part=True)
    return head


def read_options(folder: Path) -> dict[str, Any]:
    """Return the options, by name, that a data set was begun with or last grown by.

    Curves are those that the set keeps; a preset of one's own is a name alone. Measured sets and
    the sensor are left out, and so is what the heads of older sets lack.
    """
    head = read_head(folder, GROWN_HEAD_KINDS)
    common = {name: head["common"].get(name) for name in _SHARED}
    common["size"] = tuple(head["common"]["size"])
    for role in CURVES:
        keep = partial(_kept, folder, role)
        common[role] = with_table(common[role] or "", keep) or None
    common["own_noise"] = head["common"].get("own_noise", True)
    files = {"format": head["formats"], "full": head.get("full"), "buffers": head.get("buffers")}
    options = {"preset": head["preset"], **common, **files, **head.get("choices", {})}
    return {name: value for name, value in options.items() if value is not None}


def _kept(folder: Path, role: str, path: Path) -> str:
    return str(inside(folder, kept_as(role, path)))


def read_lines(folder: str | PathLike[str]) -> list[dict[str, Any]]:
    """Return the entries of all images, in the order of the manifest."""
    path = Path(folder) / LINES
    try:
        lines = path.read_text(encoding="utf-8").removesuffix("\n").split("\n")
        entries = [_JSON.decode(line) for line in lines if lines != [""]]
        if any(not isinstance(entry, dict) or not entry.keys() >= _KEYS for entry in entries):
            raise ValueError("a line does not describe an image")
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"cannot be read ({error}); {_AGAIN}", path) from None
    names = set[str]()
    for number, entry in enumerate(entries, start=1):
        check_names(entry, f"{path}:{number}")
        if entry["name"] in names:
            raise InputError(f"has the image {shown(entry['name'])} twice; {_AGAIN}", path, number)
        names.add(entry["name"])
    return entries


def check_names(entry: Mapping[str, Any], place: str) -> None:
    """Check that the image of an entry, and its files, are inside the set; `place` has the entry.

    Raises
    ------
    InputError : one is not
    """
    owner = f"{place}: {check_inside(entry['name'], place, is_part=True)}"
    if not isinstance(entry["files"], dict):
        raise InputError(f"files {shown(entry['files'])} must be a table; {_AGAIN}", owner)
    for each in entry["files"]:
        check_inside(each, owner)


def write_head(folder: Path, head: dict[str, Any], finished: Container[str]) -> None:
    """Write the head atomically; it lists what is asked for, and what an earlier run finished."""
    if (folder / HEAD).is_file():
        asked = head["images"]
        there = read_head(folder)
        listed = [name for name in there["images"] if name in finished or name in asked]
        sizes = there.get("split_sizes", {}) | head.get("split_sizes", {})
        head = {**head, "split_sizes": sizes} if sizes else head
        head = {**head, "images": list(dict.fromkeys([*listed, *asked]))}
    _write_atomically(folder / HEAD, json.dumps(head, indent=2, ensure_ascii=False) + "\n")


def write_lines(folder: Path, entries: Iterable[dict[str, Any]]) -> None:
    """Write the entries of all images atomically."""
    text = "".join(json.dumps(entry, ensure_ascii=False) + "\n" for entry in entries)
    _write_atomically(folder / LINES, text)


def append_line(folder: Path, entry: dict[str, Any]) -> None:
    """Append the entry of an image."""
    line = json.dumps(entry, ensure_ascii=False) + "\n"
    with naming_written(folder / LINES, len(line)), (folder / LINES).open("ab") as file:
        file.write(line.encode())


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other runs of this machine out of a data set's folder; where files can be locked."""
    try:
        import fcntl
    except ImportError:  # Windows
        yield
        return
    place = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(place)
        message = "another run is making this data set; wait for it, or choose another folder"
        raise InputError(message, folder) from None
    except OSError:  # a file system without locks
        pass
    try:
        yield
    finally:
        os.close(place)


def remove_leftovers(folder: Path) -> None:
    """Remove temporary folders of a run that was killed."""
    for path in folder.glob(".photonmap-*"):
        shutil.rmtree(path, ignore_errors=True)


def _write_atomically(path: Path, text: str) -> None:
    data = text.encode()
    with replacing(path, len(data)) as part:
        part.write_bytes(data)


INPUTS = "inputs"
"""Folder of a data set with the small files that it was made from."""
CURVES, SENSOR, LIGHTS = ("bands", "rgb"), "sensor", "lights"
"""What files of sensitivities and of spectra are for; each has a folder of its own."""


def kept_as(role: str, path: Path) -> str:
    """Return the copy of a file of curves, as seen from the folder of its data set."""
    return f"{INPUTS}/{role}/{path.name}"


def role_of_light(digest: str) -> str:
    """Return the folder of a light's spectrum: lights of one name may have several."""
    return f"{LIGHTS}/{digest}"


def with_table(text: str, rename: Callable[[Path], str]) -> str:
    """Return bands, an RGB space or a light with their file, if they are one, renamed."""
    path = table_of(text)
    if path is None:
        return text
    return (EXTRAPOLATE if text.strip().startswith(EXTRAPOLATE) else "") + rename(path)


def seen_from(folder: Path, path: str) -> str:
    """Return a file beside a data set, or below its parent, as seen from there; else its name.

    >>> seen_from(Path("/data/set"), "/data/rooms/a.obj"), seen_from(Path("/data/set"), "/b.obj")
    ('../rooms/a.obj', 'b.obj')
    """
    near = Path(os.path.relpath(path, folder))
    return Path(path).name if near.parts[:2] == ("..", "..") else near.as_posix()


def reason_of(path: str, error: Exception) -> str:
    """Return why a scene file cannot be read, with files named as seen from its folder."""
    folders = (Path(path).parent, Path(path).resolve().parent)
    names = "|".join(re.escape(f"{folder}{os.sep}") for folder in folders)
    return re.sub(rf"(?<![^\s'\"(])(?:{names})", "", str(error))


def as_line(scene: str, reason: str) -> str:
    """Return a scene file and its reason.

    >>> as_line("mine/a.obj", "a.obj:1: no number"), as_line("mine/a.obj", "a.mtl: no name")
    ('mine/a.obj:1: no number', 'mine/a.obj: a.mtl: no name')
    """
    rest = reason.removeprefix(Path(scene).name)
    return f"{scene}{rest}" if rest != reason and rest.startswith(":") else f"{scene}: {reason}"


def describe_left_out(folder: Path, faults: Mapping[str, str]) -> list[dict[str, str]]:
    """Return what a head says of scene files that it leaves out, from faults by their paths."""
    here = folder.resolve()
    return [
        {"scene": seen_from(here, str(Path(path).resolve())), "reason": reason}
        for path, reason in faults.items()
    ]


def lines_of(head: Mapping[str, Any]) -> list[str]:
    """Return a line for each scene file that a data set leaves out; none of older sets."""
    return [as_line(**each) for each in head.get("left_out", ())]


def warn_of_left_out(head: Mapping[str, Any]) -> None:
    """Warn of scene files that a data set leaves out."""
    scenes = [each["scene"] for each in head.get("left_out", ())]
    if scenes:
        count, them = ("1 file", "it") if len(scenes) == 1 else (f"{len(scenes)} files", "them")
        warn(
            f"scenes of {count} are missing from the set, as {enumerated(scenes, 1)} could not be "
            f"read; mend {them}, and run the data set again with --resume"
        )
