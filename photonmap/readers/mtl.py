"""Read the MTL files of Wavefront OBJ scenes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from os import PathLike
from typing import Literal

from photonmap.errors import InputError, warn
from photonmap.messages import listed, shown
from photonmap.readers.illumination import Draft, make_material
from photonmap.readers.map_options import parse_map
from photonmap.readers.wavefront import Source, read_source
from photonmap.scene import Material
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color
from photonmap.spectra.text import emission, reflectance
from photonmap.textures import Texture, check_texture, shared_image

_AMBIENT = ("Ka", "map_Ka")
_COLORS = {
    "Kd": ("reflectance", "keep it within [0, 1]"),
    "Ks": ("reflectance", "keep it within [0, 1]"),
    "Tf": ("transmittance", "keep it within [0, 1]"),
    "Ke": ("radiance", "write finite numbers from 0"),
}
_NUMBERS = ("illum", "Ni")
_MAPS = {"map_Kd": LARGEST_REFLECTANCE, "map_Ke": math.inf, "map_d": LARGEST_REFLECTANCE}
"""And the largest value in each."""
_OPACITIES = ("d", "Tr")
_NEUTRAL = {"d": 1.0, "Pm": 0.0, "Ps": 0.0, "Pc": 0.0}

Missing = Literal["error", "grey"]


@dataclass
class _Textures:
    """How textures are read, and those that could not be."""

    missing: Missing
    lost: list[str]


def read_mtl(path: str | PathLike[str], missing_textures: Missing = "error") -> dict[str, Material]:
    """Read the materials of an MTL file.

    `Kd` is the reflectance and `Ke` the radiance: linear RGB, `xyz` and CIE XYZ, or `spectral` and
    what `photonmap.spectra.text` describes; a material without them keeps the defaults of
    `Material`. `map_Kd` and `map_Ke` are textures, multiplied by `Kd` and `Ke` where these are
    given. `d`, or 1 - `Tr`, times `map_d` is the opacity. `illum` says what becomes of `Ks`, `Ni`
    and `Tf`, as `make_material` tells. `Ka` is passed over: ambient light is not physical. All
    else that would change the picture is named in one warning.

    Parameters
    ----------
    path : the file
    missing_textures : "error", or "grey": with a warning, a texture that cannot be read is 0.5
        grey, and as opacity 1

    Returns
    -------
    dict from name to Material; of two with one name the last, with a warning

    Raises
    ------
    InputError : the file is missing or no text, a number is malformed, `Kd` is outside [0, 1]
        or `Ke` is negative or not finite, or a texture cannot be read
    """
    if missing_textures not in ("error", "grey"):
        raise InputError(f"missing_textures {missing_textures!r} is neither 'error' nor 'grey'")
    textures = _Textures(missing_textures, [])
    source = read_source(path, "MTL")
    drafts: dict[str, Draft] = {}
    repeated: list[str] = []
    name = ""
    for offset, keyword, rest in source.statements():
        if keyword == "newmtl":
            name = rest
            if not name:
                raise source.error("newmtl without a name; give it one", offset)
            if name in drafts:
                repeated.append(name)
            drafts[name] = Draft()
        elif not name:
            raise source.error(f"{shown(keyword)} before any newmtl; begin with newmtl", offset)
        elif keyword in _COLORS:
            _read_color(source, offset, keyword, rest, drafts[name])
        elif keyword in _MAPS:
            _read_map(source, offset, keyword, rest, drafts[name], textures)
        elif keyword in _OPACITIES and not rest.startswith("-halo"):
            drafts[name].numbers[keyword] = _read_opacity(source, offset, keyword, rest)
        elif keyword in _NUMBERS:
            drafts[name].numbers[keyword] = _read_number(source, offset, keyword, rest)
        elif keyword not in _AMBIENT and not _is_neutral(source, offset, keyword, rest):
            halo = " -halo" if keyword == "d" else ""
            drafts[name].ignored.append(keyword + halo)
    materials = {name: make_material(name, draft) for name, draft in drafts.items()}
    _warn_of_changes(source, drafts, repeated)
    if textures.lost:
        count = f"{len(textures.lost)} texture{'s' * (len(textures.lost) > 1)}"
        places = ", ".join(textures.lost[:8])
        warn(f"{count} cannot be read, and stand as grey: {places}")
    return materials


def _read_color(source: Source, offset: int, keyword: str, rest: str, draft: Draft) -> None:
    """Read a colour; what rounding left above 1 in a reflectance is lowered to 1."""
    color = _parse_color(source, offset, keyword, rest)
    if keyword != "Ke" and isinstance(color, tuple):
        if max(color) > 1:
            draft.clamped.append(keyword)
        red, green, blue = (min(value, 1.0) for value in color)
        color = red, green, blue
    draft.colors[keyword] = color


def _parse_color(source: Source, offset: int, keyword: str, rest: str) -> Color:
    """Parse one number, which stands for a grey, three, or `spectral` or `xyz` and theirs."""
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
    highest = math.inf if keyword == "Ke" else LARGEST_REFLECTANCE
    if not all(0 <= value <= highest and math.isfinite(value) for value in (red, green, blue)):
        message = f"{keyword} {shown(rest)} is no {_COLORS[keyword][0]}"
        raise source.error(f"{message}; {_COLORS[keyword][1]}", offset)
    return red, green, blue


def _read_map(
    source: Source, offset: int, keyword: str, rest: str, draft: Draft, textures: _Textures
) -> None:
    """Read a texture, and note its options that are left out."""
    try:
        options, name = parse_map(rest)
    except InputError as error:
        raise source.error(f"{keyword}: {error}", offset) from None
    draft.ignored += [f"{keyword} {option}" for option in options.ignored]
    try:
        path = source.path.parent / name
        if "\\" in name and not path.exists():
            path = source.path.parent / name.replace("\\", "/")
        image = shared_image(path, mask=keyword == "map_d")
        texture = Texture(image, options.scale[:2], options.offset[:2], options.clamp)
        check_texture(texture, _MAPS[keyword])
    except InputError as error:
        place = source.error(f"{keyword}: {error}", offset)
        if textures.missing == "error":
            raise place from None
        textures.lost.append(f"{str(place).partition(': ')[0]} {shown(name)}")
        draft.maps[keyword] = None
        return
    draft.maps[keyword] = texture


def _read_opacity(source: Source, offset: int, keyword: str, rest: str) -> float:
    """Read `d` or `Tr`, which may be repeated for red, green and blue."""
    numbers = _parse_numbers(source, offset, keyword, rest.split())
    if not numbers or len(set(numbers)) > 1 or not math.isfinite(numbers[0]):
        raise source.error(f"{keyword} {shown(rest)}; write a finite number", offset)
    if not 0.0 <= numbers[0] <= 1.0:
        message = f"{keyword} {shown(rest)} is no opacity; keep it within [0, 1]"
        raise source.error(message, offset)
    return numbers[0] if keyword == "d" else 1.0 - numbers[0]


def _read_number(source: Source, offset: int, keyword: str, rest: str) -> float:
    """Read `illum` or `Ni`."""
    numbers = _parse_numbers(source, offset, keyword, rest.split())
    if len(numbers) != 1 or not math.isfinite(numbers[0]):
        raise source.error(f"{keyword} {shown(rest)}; write a finite number", offset)
    if keyword == "Ni" and numbers[0] <= 0.0:
        message = f"Ni {shown(rest)} is no index of refraction; write one above 0, such as 1.5"
        raise source.error(message, offset)
    return numbers[0]


def _read_text(source: Source, offset: int, keyword: str, text: str) -> Color:
    """Read a colour that is named, or stands in a file beside this one."""
    read = emission if keyword == "Ke" else reflectance
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


def _is_neutral(source: Source, offset: int, keyword: str, rest: str) -> bool:
    """Tell whether a statement changes nothing that is simulated, or could be."""
    words = rest.removeprefix("-halo").split()
    if keyword not in _NEUTRAL:
        return False
    numbers = _parse_numbers(source, offset, keyword, words)
    if not numbers or not all(map(math.isfinite, numbers)):
        raise source.error(f"{keyword} {shown(rest)}; write finite numbers", offset)
    return all(number == _NEUTRAL[keyword] for number in numbers)


def _warn_of_changes(source: Source, drafts: dict[str, Draft], repeated: list[str]) -> None:
    """Name what was read but is not simulated, or not as it was written."""
    ignored: dict[str, dict[str, None]] = {}
    for name, draft in drafts.items():
        for keyword in draft.ignored:
            ignored.setdefault(keyword, {})[name] = None
    if ignored:
        uses = [f"{shown(keyword)} of {listed(names)}" for keyword, names in ignored.items()]
        warn(f"{source.path}: not simulated: {'; '.join(uses)}")
    for keyword in ("Kd", "Ks", "Tf"):
        if clamped := [name for name, draft in drafts.items() if keyword in draft.clamped]:
            warn(f"{source.path}: {keyword} above 1 is lowered to 1 in {listed(clamped)}")
    if repeated:
        warn(f"{source.path}: newmtl is repeated, the last one is taken: {listed(repeated)}")
