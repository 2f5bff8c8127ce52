"""Read the MTL files of Wavefront OBJ scenes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike

from photonmap.errors import InputError, warn
from photonmap.messages import listed, shown
from photonmap.readers.wavefront import Source, read_source
from photonmap.scene import Material, Vector
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color
from photonmap.spectra.text import emission, reflectance

_AMBIENT = ("Ka", "map_Ka")
_NEUTRAL = {"Ks": 0.0, "Tf": 1.0, "Ni": 1.0, "d": 1.0, "Tr": 0.0, "Pm": 0.0, "Ps": 0.0, "Pc": 0.0}
_CURVES = ("spectral", "xyz")


@dataclass
class _Draft:
    """A material as far as it has been read."""

    colors: dict[str, Color] = field(default_factory=dict)
    clamped: bool = False
    ignored: list[str] = field(default_factory=list)


def read_mtl(path: str | PathLike[str]) -> dict[str, Material]:
    """Read the materials of an MTL file.

    `Kd` is the reflectance and `Ke` the radiance: linear RGB, `xyz` and CIE XYZ, or `spectral` and
    what `photonmap.spectra.text` describes; a material without them keeps the defaults of
    `Material`. `Ka` is passed over: ambient light is not physical. All
    else that would change the picture is named in one warning.

    Parameters
    ----------
    path : the file

    Returns
    -------
    dict from name to Material; of two with one name the last, with a warning

    Raises
    ------
    InputError : the file is missing or no text, a number is malformed, `Kd` is outside [0, 1]
        or `Ke` is negative or not finite
    """
    source = read_source(path, "MTL")
    drafts: dict[str, _Draft] = {}
    repeated: list[str] = []
    name = ""
    for offset, keyword, rest in source.statements():
        if keyword == "newmtl":
            name = rest
            if not name:
                raise source.error("newmtl without a name; give it one", offset)
            if name in drafts:
                repeated.append(name)
            drafts[name] = _Draft()
        elif not name:
            raise source.error(f"{shown(keyword)} before any newmtl; begin with newmtl", offset)
        elif keyword in _READERS:
            _READERS[keyword](source, offset, rest, drafts[name])
        elif keyword not in _AMBIENT and not _is_neutral(source, offset, keyword, rest):
            drafts[name].ignored.append(keyword)
    _warn_of_changes(source, drafts, repeated)
    return {name: Material(name, **draft.colors) for name, draft in drafts.items()}


def _read_color(source: Source, offset: int, keyword: str, rest: str) -> Color:
    """Read a colour: one number, which stands for a grey, three, or `spectral` or `xyz`."""
    words = rest.split()
    if words[:1] == ["spectral"]:
        return _read_text(source, offset, keyword, rest.removeprefix("spectral").strip())
    space = words.pop(0) if words[:1] == ["xyz"] else ""
    numbers = _parse_numbers(source, offset, keyword, words)
    if len(numbers) not in (1, 3):
        message = f"{keyword} {shown(rest)} has {len(numbers)} numbers; write one or three"
        raise source.error(message, offset)
    red, green, blue = numbers if len(numbers) == 3 else numbers * 3
    if space:
        return _read_text(source, offset, keyword, f"xyz:{red},{green},{blue}")
    return _CHECKS[keyword](source, offset, rest, (red, green, blue))


def _read_text(source: Source, offset: int, keyword: str, text: str) -> Color:
    """Read a colour that is named, or stands in a file beside this one."""
    read = {"Kd": reflectance, "Ke": emission}[keyword]
    try:
        return read(text, source.path.parent)
    except InputError as error:
        raise source.error(f"{keyword}: {error}", offset) from None


def _parse_numbers(source: Source, offset: int, keyword: str, words: list[str]) -> list[float]:
    """Read decimal numbers; NaN and infinity pass."""
    try:
        if any("_" in word for word in words):
            raise ValueError
        return [float(word) for word in words]
    except ValueError:
        message = f"{keyword} {shown(' '.join(words))} is no number"
        remedy = "write numbers with a decimal point, apart by spaces"
        raise source.error(f"{message}; {remedy}", offset) from None


def _check_reflectance(source: Source, offset: int, rest: str, color: Vector) -> Vector:
    """Refuse what is no RGB of a reflectance."""
    if not all(0 <= value <= LARGEST_REFLECTANCE for value in color):
        message = f"Kd {shown(rest)} is no reflectance; keep it within [0, 1]"
        raise source.error(message, offset)
    return color


def _check_radiance(source: Source, offset: int, rest: str, color: Vector) -> Vector:
    """Refuse what is no RGB of a light."""
    if min(color) < 0 or not all(map(math.isfinite, color)):
        message = f"Ke {shown(rest)} is no radiance; write finite numbers from 0"
        raise source.error(message, offset)
    return color


_CHECKS = {"Kd": _check_reflectance, "Ke": _check_radiance}


def _read_reflectance(source: Source, offset: int, rest: str, draft: _Draft) -> None:
    """Read `Kd`; what rounding left above 1 is lowered to 1."""
    color = _read_color(source, offset, "Kd", rest)
    draft.clamped = isinstance(color, tuple) and max(color) > 1
    if isinstance(color, tuple):
        red, green, blue = (min(value, 1.0) for value in color)
        color = red, green, blue
    draft.colors["reflectance"] = color


def _read_emission(source: Source, offset: int, rest: str, draft: _Draft) -> None:
    """Read `Ke`."""
    draft.colors["emission"] = _read_color(source, offset, "Ke", rest)


_READERS: dict[str, Callable[[Source, int, str, _Draft], None]] = {
    "Kd": _read_reflectance,
    "Ke": _read_emission,
}
"""What is simulated. A texture's reader (`map_Kd`) goes here."""


def _is_neutral(source: Source, offset: int, keyword: str, rest: str) -> bool:
    """Tell whether a statement changes nothing that is simulated, or could be."""
    words = rest.removeprefix("-halo").split()
    if keyword not in (*_NEUTRAL, "illum") or (words and words[0] in _CURVES):
        return False
    numbers = _parse_numbers(source, offset, keyword, words)
    if not numbers or not all(map(math.isfinite, numbers)):
        raise source.error(f"{keyword} {shown(rest)}; write finite numbers", offset)
    if keyword == "illum":
        return numbers[0] <= 2
    return all(number == _NEUTRAL[keyword] for number in numbers)


def _warn_of_changes(source: Source, drafts: dict[str, _Draft], repeated: list[str]) -> None:
    """Name what was read but is not simulated, or not as it was written."""
    ignored: dict[str, dict[str, None]] = {}
    for name, draft in drafts.items():
        for keyword in draft.ignored:
            ignored.setdefault(keyword, {})[name] = None
    if ignored:
        uses = [f"{shown(keyword)} of {listed(names)}" for keyword, names in ignored.items()]
        warn(f"{source.path}: not simulated: {'; '.join(uses)}")
    if clamped := [name for name, draft in drafts.items() if draft.clamped]:
        warn(f"{source.path}: Kd above 1 is lowered to 1 in {listed(clamped)}")
    if repeated:
        warn(f"{source.path}: newmtl is repeated, the last one is taken: {listed(repeated)}")
