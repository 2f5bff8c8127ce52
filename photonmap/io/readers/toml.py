"""TOML files that remember the lines of their keys, and the values of declared parameters."""

from __future__ import annotations

import math
import re
import tomllib
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

from photonmap.errors import InputError
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene import parameters
from photonmap.scene.parameters import Parameter, Part, parameters_of
from photonmap.scene.surfaces.spectral_texture import SpectralTexture, is_spectral
from photonmap.scene.textures import Texture, check_texture, shared_image
from photonmap.spectra.curves import LARGEST_REFLECTANCE
from photonmap.spectra.fluorophores import read_fluorophores

_PLACED = ("scale", "offset", "clamp", "nearest")
_DEEPEST = 100  # Parts of a key; tomllib takes time with the square of their number
_KEY = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DEEP_KEY = re.compile(rf"(?<![\w.-])(?:{_KEY}\.[ \t]*+){{{_DEEPEST}}}")


@dataclass(frozen=True)
class Toml:
    """A parsed file."""

    path: Path  # the file
    text: str  # what it holds
    sections: dict[str, Any]  # the same, parsed

    def line(self, *names: str | int) -> int | None:
        """Find the line of the section or key that this path of names leads to.

        A number, from 0, counts the sections `[[NAME]]` of the name before it.
        """
        at, last = 0, ""
        for name in names:
            if isinstance(name, int):
                start = self._header(last, name)
            else:
                pattern = rf"(?<![\w-]){re.escape(name)}[\"']?[ \t]*[=.\]]"
                start, last = self._find(pattern, at), name
            if start is None:
                return None
            at = start + len(last)
        return self.text.count("\n", 0, at) + 1

    def _find(self, pattern: str, at: int) -> int | None:
        """Find where a pattern begins, from an offset on, outside of comments."""
        sought = re.compile(pattern)
        while found := sought.search(self.text, at):
            if "#" not in self.text[self.text.rfind("\n", 0, found.start()) + 1 : found.start()]:
                return found.start()
            at = self.text.find("\n", found.start())
            if at < 0:
                break
        return None

    def _header(self, name: str, index: int) -> int | None:
        """Find a section `[[NAME]]`, or else the array of that name."""
        pattern = rf"^[ \t]*\[\[[ \t]*[\"']?{re.escape(name)}[\"']?[ \t]*\]\]"
        found = [match.end() - 2 for match in re.finditer(pattern, self.text, re.MULTILINE)]
        if index < len(found):
            return found[index] - len(name)
        return self._find(rf"(?<![\w-]){re.escape(name)}[ \t]*=", 0)

    def error(self, message: str, *names: str | int) -> InputError:
        """Return an error about the section or key that this path of names leads to."""
        return InputError(message, self.path, self.line(*names))

    @contextmanager
    def naming(self, *names: str | int) -> Iterator[None]:
        """Give an `InputError` the file, and the line that this path of names leads to."""
        try:
            yield
        except InputError as error:
            raise self.error(str(error), *names) from None

    def section(self, label: str, known: Collection[str], *at: str) -> dict[str, Any]:
        """Return a section whose keys are all known; `label` is how it is written."""
        section: Any = self.sections
        for step in at:
            section = section[step]
        if not isinstance(section, dict):
            message = f"{'.'.join(at)} is not a section; write {label} above its keys"
            raise self.error(message, *at)
        self.check_known(known, f"{label} key", *at)
        return section

    def check_known(self, known: Collection[str], kind: str, *at: str | int) -> None:
        """Raise `InputError` if a section's key, or a section, is not among the known ones."""
        section: Any = self.sections
        for step in at:
            section = section[step]
        for name in section:
            if name not in known:
                message = f"{kind} {shown(name)} is not known; {suggest(name, known)}"
                raise self.error(message, *at, name)


def parse_value(parameter: Parameter, value: Any, folder: Path) -> Any:
    """Return what a TOML value stands for: a colour, an image, what a file holds, or a number."""
    if parameter.textured and isinstance(value, dict):
        return _parse_texture(parameter, value, folder)
    match parameter:
        case parameters.Colored():
            return parameter.parse(_color_text(value), folder)
        case parameters.File():
            if not isinstance(value, str):
                example = f"{parameter.key} = {parameter.example}"
                raise InputError(f"{shown(value)} is not a file name; write {example}")
            return parameter.read(named_file(folder, value))
        case parameters.Fluorescent():
            return read_fluorophores(value, folder)
        case Part():
            return _parse_part(parameter, value, folder)
    return parameter.check(value)


def _parse_texture(parameter: Parameter, table: dict[str, Any], folder: Path) -> Texture:
    """Return the texture that a table describes; those of numbers are linear by default."""
    if not isinstance(table.get("file"), str):
        raise InputError(f'{shown(table)} names no file; write {{ file = "IMAGE" }}')
    path = named_file(folder, table["file"])
    if "palette" in table or is_spectral(path):
        return _parse_spectral(parameter, table, path)
    _check_keys(table, ("file", *_PLACED, "factor", "linear"))
    placed, is_mask = _placement(table), parameter.noun == "opacity"
    linear = _flag(table, "linear", isinstance(parameter, parameters.Number))
    red, green, blue = _numbers(table, "factor", [1, 1, 1])
    image = shared_image(path, linear=linear, mask=is_mask)
    texture = Texture(image, **placed, factor=(red, green, blue))
    is_light = isinstance(parameter, parameters.Emission)
    check_texture(texture, math.inf if is_light else LARGEST_REFLECTANCE)
    return texture


def _parse_spectral(parameter: Parameter, table: dict[str, Any], path: Path) -> Texture:
    """Return a texture of spectra: a hyperspectral image, or indices into a palette."""
    if not isinstance(parameter, parameters.Reflectance) or parameter.mtl != "Kd":
        raise InputError("spectra on a surface are for its reflectance; give an image here")
    if "palette" not in table:
        _check_keys(table, ("file", *_PLACED, "factor", "extrapolate"))
        held, (gain,) = _flag(table, "extrapolate", False), _numbers(table, "factor", [1])
        return SpectralTexture.read(path, extrapolate=held, gain=gain, **_placement(table))
    _check_keys(table, ("file", *_PLACED, "palette"))
    colors = table["palette"]
    if not isinstance(colors, list):
        raise InputError(f"palette {shown(colors)}; write a list of colours")
    palette = [parameter.parse(_color_text(color), path.parent) for color in colors]
    return SpectralTexture.from_palette(path, palette, **_placement(table))


def _check_keys(table: dict[str, Any], known: Collection[str]) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"key {shown(key)} is not known; {suggest(key, known)}")


def _flag(table: dict[str, Any], key: str, default: bool) -> bool:
    value = table.get(key, default)
    if not isinstance(value, bool):
        raise InputError(f"{key} {shown(value)}; write true or false")
    return value


def _placement(table: dict[str, Any]) -> dict[str, Any]:
    scale, offset = _numbers(table, "scale", [1, 1]), _numbers(table, "offset", [0, 0])
    clamp, nearest = table.get("clamp", False), _flag(table, "nearest", False)
    if isinstance(clamp, list) and [type(each) for each in clamp] == [bool, bool]:
        clamp = tuple(clamp)
    elif not isinstance(clamp, bool):
        wanted = "write true or false, or a list of one for u and one for v"
        raise InputError(f"clamp {shown(clamp)}; {wanted}")
    return {"scale": tuple(scale), "offset": tuple(offset), "clamp": clamp, "nearest": nearest}


def _numbers(table: dict[str, Any], key: str, default: list[int]) -> list[float]:
    """Return as many numbers as the default has; one stands for all."""
    value = table.get(key, default)
    numbers = value if isinstance(value, list) else [value] * len(default)
    if len(numbers) != len(default) or any(parameters.finite(number) is None for number in numbers):
        raise InputError(f"{key} {shown(value)}; write {len(default)} numbers, or one for all")
    return [float(number) for number in numbers]


def _parse_part(part: Part, table: Any, folder: Path) -> Any:
    kinds = part.kinds
    if not isinstance(table, dict):
        raise part.error(table, "write a table, { key = value, ... }")
    kind = table.get("type", next(iter(kinds)) if len(kinds) == 1 else None)
    if kind is None:
        raise InputError(f"has no type; add one of {listed(kinds, len(kinds))}")
    if not isinstance(kind, str) or kind not in kinds:
        raise InputError(f"type {shown(kind)} is not known; {suggest(str(kind), kinds)}")
    described: Any = kinds[kind]
    keys = {declared.key or name: name for name, declared in parameters_of(described).items()}
    _check_keys(table, ("type", *keys))
    required = {each.name for each in fields(described) if each.default is MISSING}
    values = {}
    for key, name in keys.items():
        declared = parameters_of(described)[name]
        if key in table:
            is_file = isinstance(declared, parameters.File)
            values[name] = parse_value(declared, table[key], folder) if is_file else table[key]
        elif name in required:
            raise InputError(f"lacks {key}; add {key} = {declared.example}")
    return described(**values)


def _color_text(value: Any) -> str:
    numbers = value if isinstance(value, list) else [value]
    if isinstance(value, str):
        return value
    if len(numbers) not in (1, 3) or any(type(number) not in (int, float) for number in numbers):
        raise InputError(
            f"{shown(value)} is not a colour; write a number, three numbers, or a text"
        )
    return repr(value) if value is numbers[0] else "rgb:" + ",".join(map(repr, numbers))


def read_toml(path: Path) -> Toml:
    """Read a TOML file; a missing one counts as empty."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        text = ""
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror}); check the file", path) from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise InputError("is not in UTF-8; save it in that encoding", path, line) from None
    if deep := _DEEP_KEY.search(text):
        line = text.count("\n", 0, deep.start()) + 1
        raise InputError(f"has a key of more than {_DEEPEST} parts; correct it", path, line)
    try:
        return Toml(path, text, tomllib.loads(text))
    except (ValueError, RecursionError) as error:
        reason, _, at = str(error).partition(" (at ")
        found = re.match(r"line (\d+)", at)
        last = int(found[1]) if found else len(text.splitlines()) if at else None
        reason = _why_twice(text) or f"is not valid TOML: {reason}; correct it"
        raise InputError(reason, path, last) from None


def _why_twice(text: str) -> str | None:
    """Return what is wrong with sections of one name, at least one of which stands alone."""
    headers = re.findall(r"^[ \t]*(\[\[?)[ \t]*([\w.-]+)[ \t]*\]", text, re.MULTILINE)
    counts = Counter(name for _, name in headers)
    for name in dict.fromkeys(name for bracket, name in headers if bracket == "["):
        count = counts[name]
        if count > 1:
            both = ("[[", name) in headers
            written = f"both [{name}] and [[{name}]]" if both else f"[{name}] {count} times"
            return f"has {written}; write [[{name}]] above each of several, or remove all but one"
    return None
