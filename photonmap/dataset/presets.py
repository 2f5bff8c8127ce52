"""Presets: which scenes, illuminations and views a data set has; named ones, and TOML files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from photonmap.dataset import build
from photonmap.dataset.lighting import ILLUMINATIONS, Illumination
from photonmap.dataset.palette import MATERIALS
from photonmap.dataset.views import View
from photonmap.errors import InputError, naming
from photonmap.messages import shown, suggest
from photonmap.readers.meshes import SUFFIXES
from photonmap.readers.toml import Toml, read_toml

_LISTS = ("scenes", "illuminations", "files")
_KEYS = (*_LISTS, "materials", "recolor", "illumination", "view")
_VIEW, _LIGHT = ("name", "yaw", "pitch", "distance"), ("name", "colors")
_FORBIDDEN = set('/\\:*?"<>|\n')


@dataclass(frozen=True)
class Preset:
    """What a data set is made of.

    Parameters
    ----------
    name : as it was asked for
    scenes : of `photonmap.dataset.build.SCENES`
    files : scene files of the user's
    illuminations : names of `photonmap.dataset.lighting.ILLUMINATIONS`, or with colours
    views : of each scene
    materials : of procedural scenes
    recolor : give the user's scenes chips at random
    """

    name: str
    scenes: tuple[str, ...]
    files: tuple[str, ...] = ()
    illuminations: tuple[str | Illumination, ...] = ILLUMINATIONS
    views: tuple[View, ...] = (View(),)
    materials: str = MATERIALS[0]
    recolor: bool = False


def load_preset(name: str) -> Preset:
    """Return a preset of `photonmap.dataset.build.PRESETS`, or of a TOML file.

    The file has `scenes`, names, or `files`, scene files and folders of them, or both; and may have
    `illuminations`, names, and sections `[[illumination]]` with `name` and `colors`; sections
    `[[view]]` with `name`, and `yaw`, `pitch` (degrees) and `distance`; `materials`; `recolor`.

    Raises
    ------
    InputError : there is no such preset, or the file has what cannot be rendered
    """
    if name in build.PRESETS:
        return Preset(name, build.PRESETS[name])
    if not name.lower().endswith(".toml"):
        remedy = suggest(name, build.PRESETS)
        raise InputError(f"there is no preset {shown(name)}; {remedy} Or give a FILE.toml")
    path = Path(name)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    return _read(read_toml(path))


def _read(toml: Toml) -> Preset:
    """Read a preset's file."""
    toml.check_known(_KEYS, "key")
    lists = {key: _texts(toml, key) for key in _LISTS}
    for key, known in (("scenes", build.SCENES), ("illuminations", ILLUMINATIONS)):
        for value in lists[key]:
            if value not in known:
                raise toml.error(f"there is no {key[:-1]} {value!r}; {suggest(value, known)}", key)
    files = tuple(each for text in lists["files"] for each in _scene_files(toml, text))
    if not lists["scenes"] and not files:
        raise InputError('has no scene; write scenes = ["vase"] or files = ["room.obj"]', toml.path)
    materials = toml.sections.get("materials", MATERIALS[0])
    if materials not in MATERIALS:
        raise toml.error(f"materials {shown(materials)} must be one of {MATERIALS}", "materials")
    recolor = toml.sections.get("recolor", False)
    if not isinstance(recolor, bool):
        raise toml.error(f"recolor {shown(recolor)} is neither true nor false", "recolor")
    lights: tuple[str | Illumination, ...] = (*lists["illuminations"], *_illuminations(toml))
    views = _views(toml)
    return Preset(
        str(toml.path), lists["scenes"], files, lights or ILLUMINATIONS, views, materials, recolor
    )


def _texts(toml: Toml, key: str) -> tuple[str, ...]:
    """Read a list of texts."""
    values = toml.sections.get(key, [])
    if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
        raise toml.error(f'{key} {shown(values)} is no list of names; write ["one", "two"]', key)
    return tuple(values)


def _scene_files(toml: Toml, text: str) -> tuple[str, ...]:
    """Return a scene file, or those of a folder; of a mesh and its TOML file, the mesh."""
    path = toml.path.parent / text
    if path.is_file():
        return (str(path),)
    if not path.is_dir():
        raise toml.error(f"there is no file or folder {path}; check the name", "files")
    meshes = sorted(p for p in path.iterdir() if p.suffix.lower() in (".obj", *SUFFIXES))
    if not meshes:
        raise toml.error(f"the folder {path} has no scenes; name another", "files")
    return tuple(map(str, meshes))


def _sections(toml: Toml, key: str, known: tuple[str, ...]) -> list[dict[str, Any]]:
    """Read sections `[[KEY]]`, each with a name of its own."""
    sections = toml.sections.get(key, [])
    if not isinstance(sections, list) or not all(isinstance(s, dict) for s in sections):
        raise toml.error(f"{key} is no list of sections; write [[{key}]]", key)
    names = []
    for index, section in enumerate(sections):
        toml.check_known(known, f"key of {key}", key, index)
        name = section.get("name")
        if not isinstance(name, str) or not name or set(name) & _FORBIDDEN or name in names:
            message = f"{key} {index + 1} needs a name of its own that a folder may have"
            raise toml.error(message, key, index)
        names.append(name)
    return sections


def _illuminations(toml: Toml) -> list[Illumination]:
    """Read illuminations with colours."""
    made = []
    for index, section in enumerate(_sections(toml, "illumination", _LIGHT)):
        colors = section.get("colors")
        if not isinstance(colors, list) or not all(isinstance(c, str) for c in colors):
            message = f'{section["name"]!r} needs colors, as in ["planck:5000", "LED-B3"]'
            raise toml.error(message, "illumination", index)
        with naming(str(toml.path)):
            made.append(Illumination(section["name"], tuple(colors)))
    return made


def _views(toml: Toml) -> tuple[View, ...]:
    """Read views; the scene's own camera where there is none."""
    with naming(str(toml.path)):
        views = tuple(View(**section) for section in _sections(toml, "view", _VIEW))
    return views or (View(),)
