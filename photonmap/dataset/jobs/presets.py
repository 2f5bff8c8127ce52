"""Presets: the scenes, illuminations and views of a data set, by name or from a TOML file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any

from photonmap.dataset.files.splits import PARTS
from photonmap.dataset.models.materials import MATERIALS
from photonmap.dataset.scenes.build import PAPER_SCENES, SCENES, check_looks
from photonmap.dataset.scenes.illumination import (
    ILLUMINATIONS,
    NAMED,
    Illumination,
    light_spectrum,
    located_light,
)
from photonmap.dataset.scenes.random_lights import RANDOM, RandomLights
from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError, naming
from photonmap.io.readers.registry import mesh_suffixes
from photonmap.io.readers.toml import Toml, read_toml
from photonmap.runtime.options import check_size
from photonmap.runtime.wording import shown, suggest

_LISTS = ("scenes", "illuminations", "files")
_PLAIN = (*_LISTS, "materials", "lightness", "scale", "recolor")
_KEYS = (*_PLAIN, "illumination", "view", "trajectory", "split")
_VIEW = ("name", "yaw", "pitch", "distance", "fov", "baseline")
_LIGHT = ("name", "colors", "shares", "lights")
_PATH, _LOOK = (*_VIEW, "frames"), ("size", "fov")
_RANGE = {"yaw": 30.0, "pitch": 8.0, "distance": 1.25}
"""How far trajectories lead by default, as `View` takes it."""
_MOST_FRAMES = 100_000
_FORBIDDEN = set('/\\:*?"<>|\n')
"""Characters that names may not have, as they become names of folders."""

Lights = str | Illumination | RandomLights
"""An illumination by name, of given lights, or of lights that are drawn."""


@dataclass(frozen=True)
class Look:
    """What the images of a split have of their own; None for what all images have."""

    size: tuple[int, int] | None = None  # (width, height), pixels
    fov: float | None = None  # full vertical angle of view, degrees


@dataclass(frozen=True)
class Preset:
    """The scenes of a data set, and how they are varied."""

    name: str  # of the preset, or the path of its file
    scenes: tuple[str, ...]  # names from `photonmap.dataset.scenes.build.SCENES`
    files: tuple[str, ...] = ()  # scene files of the user
    # names from `photonmap.dataset.scenes.illumination.NAMED`, or objects
    illuminations: tuple[Lights, ...] = ILLUMINATIONS
    views: tuple[View, ...] = (View(),)  # of each scene
    materials: str = MATERIALS[0]  # of procedural scenes, as `build_scene` takes them
    recolor: bool = False  # give the surfaces of the user's scenes random Munsell chips
    splits: Mapping[str, Look] = field(default_factory=dict)  # the looks of splits by their names
    lightness: float | None = None
    scale: float = 1.0


PRESETS = {
    "small": Preset("small", ("jug", "boulder", "living_room", "pottery")),
    "icip2013": Preset("icip2013", PAPER_SCENES),
    "varied": Preset("varied", SCENES, illuminations=tuple(RANDOM)[1:]),
}
"""Presets by name; icip2013 has as many objects and rooms as Beigpour et al. 2013."""


def load_preset(name: str) -> Preset:
    """Return a preset of `PRESETS`, or of a TOML file.

    The file has `scenes` (names) or `files` (scene files and folders of them) or both. It may have
    `illuminations` (names); sections `[[illumination]]` with `name`, and `colors` and perhaps
    `shares`, or `lights`, the lowest and the highest number of lights that are drawn; sections
    `[[view]]` with `name`, `yaw` and `pitch` (degrees), `distance`, `fov` and, for a stereo pair,
    `baseline`; sections `[[trajectory]]` with the same and `frames`; sections `[split.NAME]` with
    `size` and `fov`; `materials`; `lightness`; `scale`; `recolor`.
    """
    if name in PRESETS:
        return PRESETS[name]
    if not name.lower().endswith(".toml"):
        remedy = suggest(name, PRESETS)
        raise InputError(f"there is no preset {shown(name)}; {remedy} (or give a FILE.toml)")
    path = Path(name)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    return _read(read_toml(path))


def with_illuminations(preset: Preset, names: Sequence[str]) -> Preset:
    """Return a preset under illuminations by name, its own among them; no names change nothing."""
    own: dict[str, Lights] = {
        each if isinstance(each, str) else each.name: each for each in preset.illuminations
    }
    if unknown := [name for name in names if name not in {*own, *NAMED}]:
        known = suggest(unknown[0], [*own, *NAMED])
        raise InputError(f"there is no illumination {unknown[0]!r}; {known}")
    chosen = tuple(own.get(name, name) for name in names)
    return replace(preset, illuminations=chosen or preset.illuminations)


def _read(toml: Toml) -> Preset:
    """Read a preset's file."""
    toml.check_known(_KEYS, "key")
    lists = {key: _strings(toml, key) for key in _LISTS}
    for key, known in (("scenes", SCENES), ("illuminations", NAMED)):
        for value in lists[key]:
            if value not in known:
                raise toml.error(f"there is no {key[:-1]} {value!r}; {suggest(value, known)}", key)
    files = tuple(each for text in lists["files"] for each in _scene_files(toml, text))
    if not lists["scenes"] and not files:
        remedy = 'write scenes = ["vase"] or files = ["room.obj"]'
        raise InputError(f"has no scenes; {remedy}", toml.path)
    made = _illuminations(toml)
    for index, each in enumerate(made):
        if each.name in lists["illuminations"]:
            message = f"two illuminations are called {each.name!r}; choose another name"
            raise toml.error(message, "illumination", index)
    lights: tuple[Lights, ...] = (*lists["illuminations"], *made)
    return Preset(
        str(toml.path),
        lists["scenes"],
        files,
        lights or ILLUMINATIONS,
        _views(toml),
        splits=_looks(toml),
        **_surfaces(toml),
    )


def _surfaces(toml: Toml) -> dict[str, Any]:
    """Read what all scenes share: materials, their lightness, recolouring and the rooms' scale."""
    materials = toml.sections.get("materials", MATERIALS[0])
    if materials not in MATERIALS:
        raise toml.error(f"materials {shown(materials)} must be one of {MATERIALS}", "materials")
    recolor = toml.sections.get("recolor", False)
    if not isinstance(recolor, bool):
        raise toml.error(f"recolor {shown(recolor)} must be true or false", "recolor")
    given: dict[str, Any] = {"materials": materials, "recolor": recolor}
    for key in [key for key in ("lightness", "scale") if key in toml.sections]:
        value = toml.sections[key]
        if isinstance(value, bool) or not isinstance(value, Real):
            raise toml.error(f"{key} {shown(value)} is not a number", key)
        given[key] = float(value)
        with toml.naming(key):
            check_looks(**{key: given[key]})
    return given


def _strings(toml: Toml, key: str) -> tuple[str, ...]:
    """Read a list of strings."""
    values = toml.sections.get(key, [])
    if not _is_list(values, str):
        raise toml.error(f'{key} {shown(values)} is not a list of names; write ["one", "two"]', key)
    return tuple(values)


def _scene_files(toml: Toml, text: str) -> tuple[str, ...]:
    """Return a scene file, or those of a folder; TOML files of meshes are read with the mesh."""
    path = toml.path.parent / text
    if path.is_file():
        return (str(path),)
    if not path.is_dir():
        raise toml.error(f"there is no file or folder {path}; check the name", "files")
    meshes = sorted(p for p in path.iterdir() if p.suffix.lower() in mesh_suffixes())
    if not meshes:
        raise toml.error(f"the folder {path} has no scene files; choose another", "files")
    return tuple(map(str, meshes))


def _sections(toml: Toml, key: str, known: tuple[str, ...]) -> list[dict[str, Any]]:
    """Read sections `[[KEY]]`, each of which needs a unique name."""
    sections = toml.sections.get(key, [])
    if not _is_list(sections, dict):
        raise toml.error(f"{key} is not a list of sections; write [[{key}]]", key)
    names = []
    for index, section in enumerate(sections):
        toml.check_known(known, f"key of {key}", key, index)
        name = section.get("name")
        if not isinstance(name, str) or not name or set(name) & _FORBIDDEN or name in names:
            message = f"{key} {index + 1} needs a unique name that is valid as the name of a folder"
            raise toml.error(message, key, index)
        names.append(name)
    return sections


def _illuminations(toml: Toml) -> list[Illumination | RandomLights]:
    """Read the illuminations that the file defines."""
    made: list[Illumination | RandomLights] = []
    for index, section in enumerate(_sections(toml, "illumination", _LIGHT)):
        colors, shares, lights = (section.get(key) for key in ("colors", "shares", "lights"))
        given = {"colors": (colors, str), "shares": (shares, Real), "lights": (lights, int)}
        for key, (values, kind) in given.items():
            if values is not None and not _is_list(values, kind):
                raise toml.error(f"{key} {shown(values)} is not a list", "illumination", index)
        if (colors is None) == (lights is None) or (lights and (shares or len(lights) != 2)):
            message = (
                f'{section["name"]!r} needs colors, as in ["planck:5000", "LED-B3"], or the number '
                "of lights to draw, as in lights = [2, 4]"
            )
            raise toml.error(message, "illumination", index)
        with toml.naming("illumination", index, "colors"):
            for color in colors or ():
                light_spectrum(color, toml.path.parent)
            lit = tuple(located_light(color, toml.path.parent) for color in colors or ())
        key = "lights" if lights else "shares" if shares else "colors"
        with toml.naming("illumination", index, key):
            if lights:
                made.append(RandomLights(section["name"], *lights))
            else:
                made.append(Illumination(section["name"], lit, tuple(shares or ())))
    return made


def _is_list(values: Any, kind: type) -> bool:
    return isinstance(values, list) and all(
        isinstance(v, kind) and not isinstance(v, bool) for v in values
    )


def _views(toml: Toml) -> tuple[View, ...]:
    """Read the views that the file defines; that of the scene's camera if there are none.

    A pair is two views, and a trajectory as many as it has frames.
    """
    found: list[View] = []
    for index, section in enumerate(_sections(toml, "view", _VIEW)):
        with toml.naming("view", index):
            found += View(**section).pair()
    for index, section in enumerate(_sections(toml, "trajectory", _PATH)):
        frames = section.get("frames")
        if not isinstance(frames, int) or not 1 <= frames <= _MOST_FRAMES:
            message = f"trajectory {section['name']!r} needs frames, 1 to {_MOST_FRAMES}"
            raise toml.error(message, "trajectory", index)
        with toml.naming("trajectory", index):
            path = View(**{**_RANGE, **section, "path": section["name"]})
        for frame in range(frames):
            found += replace(path, frame=frame).renamed().pair()
    if double := [name for name, count in Counter(v.name for v in found).items() if count > 1]:
        raise toml.error(f"two views are called {double[0]!r}; choose other names", "view")
    return tuple(found) or (View(),)


def _looks(toml: Toml) -> dict[str, Look]:
    """Read what splits have of their own."""
    sections = toml.sections.get("split", {})
    if not isinstance(sections, dict):
        raise toml.error("split is not a section; write [split.test] above size and fov", "split")
    looks = {}
    for name in sections:
        if name not in PARTS:
            raise toml.error(f"there is no split {name!r}; {suggest(name, PARTS)}", "split", name)
        values = dict(toml.section(f"[split.{name}]", _LOOK, "split", name))
        with toml.naming("split", name), naming(f"split {name}"):
            if "size" in values:
                values["size"] = check_size(values["size"])
            View(name, fov=values.get("fov"))
        looks[name] = Look(**values)
    return looks
