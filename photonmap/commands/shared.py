"""What commands share: options, how their values are read, lines of progress and of failures."""

from __future__ import annotations

import argparse
import math
import sys
from argparse import ArgumentTypeError
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from photonmap.errors import InputError
from photonmap.io.scene_source import SceneSource
from photonmap.runtime.options import Option
from photonmap.runtime.wording import enumerated
from photonmap.runtime.workers import AUTO
from photonmap.settings import GROUPS, OPTIONS, RENDER, taken_by

T = TypeVar("T")
_NAMED = 4  # largest number of failed images that one line names
_CAMERA = ("origin", "target", "up", "fov")
"""Options that replace the camera of the scene, or parts of it."""

Row = tuple[str, str | None, str, dict[str, Any]]
"""An option: its name in Python, placeholder, what it does, and further fields of `Option`."""


def add_options(
    parser: argparse.ArgumentParser, command: str, **changes: dict[str, Any]
) -> dict[str, argparse._ArgumentGroup]:
    """Add the options of a render that a command takes, changed by name; return groups by title."""
    groups: dict[str, argparse._ArgumentGroup] = {}
    taken = [OPTIONS[name] for name in taken_by(command)]
    for title, description in GROUPS.items():
        if members := [each for each in taken if each.group == title]:
            alone = len(members) == 1
            groups[title] = parser.add_argument_group(title, None if alone else description)
            for each in members:
                add_option(groups[title], replace(each, **changes.get(each.name, {})))
    return groups


def add_option(group: argparse._ActionsContainer, option: Option) -> None:
    """Add one of a list of options."""
    if isinstance(option.default, bool):
        action = "store_false" if option.default else "store_true"
        text = f"turn off {option.help}" if option.default else option.help
        group.add_argument(option.flag, dest=option.name, action=action, help=_escape(text))
        return
    default = _default_text(option)
    stands_alone = {} if option.bare is None else {"nargs": "?", "const": option.bare}
    letter = [f"-{option.short}"] if option.short else []
    group.add_argument(
        *letter,
        option.flag,
        dest=option.name,
        type=reader(option.read or str),
        choices=option.choices or None,
        default=option.default,
        metavar=option.metavar,
        help=_escape(option.help + f"; {option.written}" * bool(option.written) + default),
        **stands_alone,
    )


def add_value(
    group: argparse._ActionsContainer, name: str, metavar: str | None, text: str, **more: Any
) -> None:
    """Add an option by its name in Python, placeholder, meaning, and further fields of `Option`."""
    add_option(group, Option(name=name, metavar=metavar, help=text, **more))


def add_group(
    parser: argparse.ArgumentParser, title: str, rows: Iterable[Row], text: str | None = None
) -> argparse._ArgumentGroup:
    """Add options under a heading, and perhaps a sentence."""
    group = parser.add_argument_group(title, text)
    for name, metavar, meaning, more in rows:
        add_value(group, name, metavar, meaning, **more)
    return group


def _default_text(option: Option) -> str:
    """Return the default as help texts give it."""
    text = option.default_text
    if not text and option.default is not None:
        pair = isinstance(option.default, tuple)
        text = "x".join(map(str, option.default)) if pair else str(option.default)
    return f" (default: {text})" if text else ""


def _escape(text: str) -> str:
    return text.replace("%", "%%")  # as argparse wants it


def add_render_options(parser: argparse.ArgumentParser) -> None:
    """Add all options of the command that renders a scene."""
    add_scene_options(parser)
    groups = add_options(parser, RENDER)
    add_range(groups["image"])
    text = "where to write the result: .exr; .nc or .hdf5 (netCDF); or .hdr or .img (ENVI)"
    usual = "the scene's name, in the current folder"
    more = {"default_text": usual, "short": "o", "read": file_name}
    add_value(groups["files"], "output", "FILE.exr", text, **more)
    text = (
        "light that is white in the preview: scene, for all lights of the scene together; or one "
        "by name, such as D65, which leaves colours as they are"
    )
    add_value(groups["files"], "white", "LIGHT", text, read=_white, default="scene")
    add_quiet(parser)


def _white(text: str) -> str:
    """Check the name of a light."""
    from photonmap.spectra.color_text import emission

    if text != "scene":
        emission(text)
    return text


def file_name(text: str) -> str:
    """Return the name of a file or folder; an empty one is refused."""
    if not text:
        raise ArgumentTypeError("'' is not the name of a file or folder; give one")
    return text


def name_output(options: argparse.Namespace) -> str:
    """Return the file to write the result to."""
    return options.output or f"{Path(options.scene).stem or 'image'}.exr"


def add_name(file: str | Path, name: str | None) -> str:
    """Return the name of a file with that of a camera at the end of its stem."""
    path = Path(file)
    return str(path.with_name(f"{path.stem}-{name}{path.suffix}") if name else path)


def add_range(group: argparse._ArgumentGroup) -> None:
    """Add the range of the bands."""
    text, usual = "wavelengths that the bands cover, nm", "400:700, or those of FILE.csv"
    add_value(group, "range", "LOW:HIGH", text, read=limits, default_text=usual)


def add_quiet(parser: argparse.ArgumentParser) -> None:
    """Add the option to print less."""
    parser.add_argument("--quiet", action="store_true", help="print only errors and warnings")


def scheduler_rows(may_be_auto: bool = False) -> list[Row]:
    """Return where several renders run; perhaps `auto`, for as many workers as are fastest."""
    where = (
        "local: this machine; or the address of a dask.distributed scheduler, as in tcp://host:8786"
    )
    auto = (
        "auto: one per processor if a trial at the start shows that to be faster than one for all"
    )
    count = {"read": _workers, "written": auto, "default": AUTO}
    return [
        ("scheduler", "ADDRESS", where, {"default": "local"}),
        ("workers", "N", "processes to start on this machine",
         count if may_be_auto else {"read": int, "default": 1}),
    ]  # fmt: skip


def _workers(text: str) -> int | str:
    """Read a number of processes, or `auto`."""
    return text if text == AUTO else reader(int)(text)


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Add SCENE and the options that say how to read it."""
    text = "OBJ, PLY, STL, glTF, OFF, USD or Mitsuba (XML) file; or TOML that describes a scene"
    parser.add_argument("scene", metavar="SCENE", help=text)
    rows: list[Row] = [
        ("camera", "NAME", "camera of the scene to use; all: one image by each, in FILE-NAME.exr",
         {"default_text": "the first"}),
        ("origin", "x,y,z", "position of the camera, scene units", {"read": vector}),
        ("target", "x,y,z", "point that the camera looks at, scene units", {"read": vector}),
        ("up", "x,y,z",
         "direction that is up in the image, or an axis, as in --up z (default: y)",
         {"read": direction}),
        ("fov", "DEG", "full vertical field of view of a pinhole camera",
         {"read": float, "default_text": "40"}),
    ]  # fmt: skip
    add_group(parser, "camera", rows, "choose one of the scene's, or replace it")
    add_material_options(parser)


def add_material_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how to read materials."""
    add_group(parser, "materials", [*MEASURED_SETS, *_MATERIALS])


MEASURED_SETS: list[Row] = [
    ("munsell", "PATH", "measured Munsell chips for colours named munsell:…",
     {"default_text": "$PHOTONMAP_MUNSELL"}),
    ("illuminants", "PATH", "measured lights for colours named sfu:…",
     {"default_text": "$PHOTONMAP_ILLUMINANTS"}),
]  # fmt: skip
"""Options that name files of measured spectra."""
_MATERIALS: list[Row] = [
    ("missing_textures", None, "what to do about textures that cannot be read",
     {"choices": ("error", "grey"), "default": "error"}),
    ("strict", None,
     "refuse a scene that is read with a warning, such as of an unsupported feature",
     {"default": False}),
    ("root", "FOLDER",
     "folder that must contain all files named by the scene; others are not opened",
     {"default_text": "the scene's own folder"}),
]  # fmt: skip


def choose_scene(options: argparse.Namespace) -> SceneSource:
    """Return the scene that the options of `add_scene_options` describe."""
    camera = {name: getattr(options, name) for name in _CAMERA}
    given = {name: value for name, value in camera.items() if value is not None}
    return SceneSource(options.scene, camera=given, view=options.camera, **how_to_read(options))


def how_to_read(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options of `add_material_options` say, as `SceneSource` takes it."""
    names = ("missing_textures", "munsell", "illuminants", "root", "strict")
    return {name: getattr(options, name) for name in names}


def choose_options(options: argparse.Namespace, command: str = RENDER) -> dict[str, Any]:
    """Return the options of a render that a command was given, by name."""
    from photonmap.spectra.bands import Bands

    given = {name: getattr(options, name) for name in taken_by(command)}
    return given | {"bands": Bands.parse(options.bands, options.range)}


def reader(read: Callable[[str], T]) -> Callable[[str], T]:
    """Return a function that reads text as `read` does, with errors in full sentences."""

    def convert(text: str) -> T:
        try:
            return read(text)
        except InputError as error:
            raise ArgumentTypeError(str(error)) from None
        except ValueError:
            kind = "whole number" if read is int else "number"
            raise ArgumentTypeError(f"{text!r} is not a {kind}") from None

    return convert


def _numbers(text: str, mark: str, count: int, problem: str) -> tuple[float, ...]:
    """Read numbers that a mark separates."""
    try:
        values = tuple(map(float, text.split(mark)))
    except ValueError:
        values = ()
    if len(values) != count:
        raise ArgumentTypeError(f"{text!r} is not a {problem}")
    return values


vector = partial(_numbers, mark=",", count=3, problem="vector; write it as x,y,z")
limits = partial(_numbers, mark=":", count=2, problem="range; write it as 400:700")


def direction(text: str) -> tuple[float, ...]:
    """Read "1,2,3", or an axis: "z" or "-z"."""
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    axis = axes.get(text.lower().removeprefix("-"))
    if axis is None:
        return vector(text)
    return tuple(-value for value in axis) if text.startswith("-") else axis


def number(low: float, high: float, unit: str = "") -> Callable[[str], float]:
    """Return what reads a number from `low` to `high`; `unit` is named in errors."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise ArgumentTypeError(f"{text!r} is not a number from {low:g} to {high:g}{unit}")
        return value

    return convert


def whole_number(low: int, high: int, unit: str = "") -> Callable[[str], int]:
    """Return what reads a whole number from `low` to `high`; `unit` is named in errors."""

    def convert(text: str) -> int:
        if not text.strip().isdecimal() or not low <= int(text) <= high:
            raise ArgumentTypeError(f"{text!r} is not a whole number from {low} to {high}{unit}")
        return int(text)

    return convert


def progress_log(options: argparse.Namespace) -> Callable[[str], None]:
    """Return what prints lines about progress on stderr; with --quiet, what does nothing."""
    if options.quiet:
        return lambda line: None
    return partial(print, file=sys.stderr, flush=True)


def say(options: argparse.Namespace, *lines: object) -> None:
    """Print lines at once; with --quiet, none."""
    if not options.quiet:
        print(*lines, sep="\n", flush=True)


def print_failures(failures: Mapping[str, str], method: str = "") -> None:
    """Print each reason of failures by image, with some of the images, perhaps of a method."""
    for reason in dict.fromkeys(failures.values()):
        images = [image for image, why in failures.items() if why == reason]
        named = f"{method}: " * bool(method) + enumerated(images, _NAMED)
        print(f"photonmap: failed: {named}: {reason}", file=sys.stderr)
