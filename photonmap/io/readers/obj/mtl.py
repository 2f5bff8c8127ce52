"""Read the MTL files of Wavefront OBJ scenes."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, naming, warn
from photonmap.io.readers.decoding import SHEEN, plain
from photonmap.io.readers.obj.lines import Source, read_source
from photonmap.io.readers.obj.mtl_models import NUMBERS, Draft, has_exponent, make_material
from photonmap.io.readers.registry import OR_WITHOUT, MissingTextures
from photonmap.runtime.files import named_image
from photonmap.runtime.wording import enumerated, listed, shown, suggest
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, Emission, Number, Parameter, Part, parameters_of
from photonmap.scene.surfaces.relief import BumpMap, NormalMap
from photonmap.scene.textures import Texture, Triple, check_texture, mean_number, shared_image
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_NUMBERS = {
    "-s": (1.0, 1.0, 1.0),
    "-o": (0.0, 0.0, 0.0),
    "-t": (0.0, 0.0, 0.0),
    "-mm": (0.0, 1.0),
    "-bm": (1.0,),
    "-boost": (0.0,),
    "-texres": (math.nan,),
}
"""Options of numbers, and the values at which they change nothing; of three, one is enough."""
_SIMULATED = ("-s", "-o", "-bm")
_SWITCHES = {"-clamp": "off", "-blendu": "on", "-blendv": "on", "-cc": "off"}
_SIDES = ("front", "back", "top", "bottom", "left", "right")
_WORDS = {
    "-imfchan": ("r", "g", "b", "m", "l", "z"),
    "-type": ("sphere", *(f"cube_{side}" for side in _SIDES)),
}
OPTIONS = (*_NUMBERS, *_SWITCHES, *_WORDS)
_PARAMETERS = {
    parameter.mtl: parameter for parameter in parameters_of(Material).values() if parameter.mtl
} | NUMBERS
"""What statements describe, by keyword."""
_MAPS = {f"map_{key}": parameter for key, parameter in _PARAMETERS.items() if parameter.textured}
_MAPS["map_Ks"] = _PARAMETERS["Ks"]
_DATA = {f"map_{key}": NUMBERS[key] for key in ("Pr", "Pm", "Ns")}
"""Maps in place of a number; they hold linear data."""
_LINEAR = (
    *_DATA, "map_roughness", "map_Pc", "map_Pcr", "map_transmission",
    "map_fluorescence_concentration", "map_d",
)  # fmt: skip
_PHONG = ("map_Ks", "map_Ns")
"""Maps that are read only where they count, as many files name some that are not there."""
_RELIEFS = ("norm", "bump", "map_bump", "map_Bump")
_FLAT, _NEAR_FLAT = (0.5, 0.5, 0.9), 0.15
"""Mean of images that hold normals, and by how much it may differ"""
_OPACITIES = ("d", "Tr")
_OFTEN_WRONG = ("Ni", "Ns")  # Statements that exporters without a value for them write as -1, or 0
_MEANING = {"Ps": f": {SHEEN}", "map_Ps": f": {SHEEN}"}
"""Of statements that are not simulated, what they would do"""


def read_mtl(
    path: Path, missing_textures: MissingTextures = "error", used: Container[str] | None = None
) -> dict[str, Material]:
    """Read the materials of an MTL file.

    `Kd` is the reflectance and `Ke` the radiance: linear RGB, `xyz` and CIE XYZ, or `spectral` and
    what `photonmap.spectra.color_text` describes; a material without them keeps the defaults of
    `Material`. `map_Kd` and `map_Ke` are textures, multiplied by `Kd` and `Ke` where these are
    given. `d`, or 1 - `Tr`, times `map_d` is the opacity. `illum` says what becomes of `Ks`, `Ni`
    and `Tf`, see `make_material`; `Ns`, `Pr` and `Pm` make a surface glossy, see `gloss_of`, and
    so do `map_Pr` and `map_Pm`, which replace them, and `map_Ns` and `map_Ks`, which multiply
    them. `Pc` or `map_Pc` is a clear coat, and `Pcr` its roughness; `Ps` or `map_Ps` is a sheen.
    `Ka` is ignored: ambient light is not physical. Whatever else would change the picture is named
    in one warning.

    missing_textures : "error", or "grey": with a warning, a texture that cannot be read is 0.5
        grey, and as opacity 1
    used : names of the materials that are needed, or None for all; of others, no statement is
        read, and they are grey
    Returns dict from name to Material; of two with one name the last, with a warning
    """
    textures = _Textures(missing_textures)
    source, blender = read_source(path, "MTL"), _blender_scale(path)
    drafts: dict[str, Draft] = {}
    repeated: list[str] = []
    draft: Draft | None = None
    later: list[tuple[_Statement, Draft]] = []
    is_read = False
    for offset, keyword, rest in source.statements():
        if keyword == "newmtl":
            if rest in drafts:
                repeated.append(rest)
            drafts[rest] = draft = Draft(blender)
            is_read = used is None or rest in used
        elif draft is None:
            raise source.error(f"{shown(keyword)} before any newmtl; begin with newmtl", offset)
        elif not is_read:
            continue
        elif keyword in _PHONG:
            later.append((_Statement(source, offset, keyword, rest), draft))
        else:
            _read_statement(_Statement(source, offset, keyword, rest), draft, textures)
    if drafts.pop("", None):
        warn(f"{source.path}: a newmtl without a name is left out")
    for draft in drafts.values():
        means = {key: min(mean_number(map), 1.0) for key, map in draft.data.items()}
        draft.numbers |= means
    for line, draft in later:
        if has_exponent(draft):
            _read_map(line, draft, textures)
        else:
            draft.ignored.append(line.keyword)
    materials = {name: make_material(name, draft) for name, draft in drafts.items()}
    _warn_of_changes(source, drafts, repeated)
    textures.warn()
    return materials


def _blender_scale(path: Path) -> float:
    """Return the `Ns` that Blender's exporter writes for roughness 0; 0 of any other program's.

    Since 3.3 it states its version, and (1 - roughness)² times 1000; it was 900.
    """
    with path.open("rb") as file:
        header = file.readline(64)
    if not header.startswith(b"# Blender "):
        return 0.0
    return 900.0 if header.startswith(b"# Blender MTL") else 1000.0


@dataclass(frozen=True)
class _Statement:
    """A line of a material: its keyword, the rest, and where it stands."""

    source: Source
    offset: int
    keyword: str
    rest: str

    def error(self, message: str) -> InputError:
        """Return an error that names the file and the line."""
        return self.source.error(message, self.offset)

    def naming(self, file: str) -> str:
        """Return a file's name with the file and the line that name it."""
        return f"{self.source.path}:{self.source.line_number(self.offset)} {shown(file)}"

    def numbers(self, words: list[str] | None = None) -> list[float]:
        """Parse decimal numbers, all words by default; NaN and infinity pass."""
        words = self.rest.split() if words is None else words
        try:
            if any("_" in word for word in words):
                raise ValueError
            return [float(word) for word in words]
        except ValueError:
            message = f"{self.keyword} {shown(' '.join(words))} is not a number"
            remedy = "write numbers with a decimal point, separated by spaces"
            raise self.error(f"{message}; {remedy}") from None


def _read_statement(line: _Statement, draft: Draft, textures: _Textures) -> None:
    keyword = line.keyword
    parameter = _PARAMETERS.get(keyword)
    if isinstance(parameter, Colored):
        _read_color(line, parameter, draft)
    elif keyword in _MAPS or keyword in _DATA:
        _read_map(line, draft, textures)
    elif keyword in _RELIEFS:
        _read_relief(line, draft, textures)
    elif keyword in _OPACITIES and not line.rest.startswith("-halo"):
        draft.numbers[keyword] = _read_opacity(line)
    elif keyword == "illum" or (isinstance(parameter, Number) and keyword not in _OPACITIES):
        number = _read_number(line, None if keyword in _OFTEN_WRONG else parameter)
        if (keyword in _OFTEN_WRONG and number < 0.0) or (keyword, number) == ("Ni", 0.0):
            draft.ignored.append(f"{keyword} {line.rest}")
        else:
            draft.numbers[keyword] = number
    elif keyword == "Ka" and draft.blender:
        numbers = line.numbers()
        draft.numbers[keyword] = numbers[0] if numbers and 0.0 <= numbers[0] <= 1.0 else 0.0
    elif keyword not in ("Ka", "map_Ka") and not _is_neutral(line):
        halo = " -halo" if keyword == "d" else ""
        draft.ignored.append(keyword + halo)


def _read_color(line: _Statement, parameter: Colored, draft: Draft) -> None:
    """Read a colour; a reflectance that rounding left above 1 is lowered to 1."""
    color = _parse_color(line, parameter)
    if isinstance(color, tuple) and max(color) > parameter.largest:
        draft.clamped.append(line.keyword)
        color = plain(min(value, parameter.largest) for value in color)
    draft.colors[line.keyword] = color


def _parse_color(line: _Statement, parameter: Colored) -> Color:
    """Parse one number, which stands for a grey, three, or `spectral` or `xyz` and theirs."""
    words = line.rest.split()
    if words[:1] == ["spectral"]:
        return _parse_text(line, parameter, line.rest.removeprefix("spectral").strip())
    space = words.pop(0) if words[:1] == ["xyz"] else ""
    numbers = line.numbers(words)
    if len(numbers) not in (1, 3):
        message = f"{line.keyword} {shown(line.rest)} has {len(numbers)} numbers"
        raise line.error(f"{message}; write one or three")
    red, green, blue = numbers if len(numbers) == 3 else numbers * 3
    if space:
        return _parse_text(line, parameter, f"xyz:{red},{green},{blue}")
    highest = max(parameter.largest, LARGEST_REFLECTANCE)
    if not all(0 <= value <= highest and math.isfinite(value) for value in (red, green, blue)):
        message = f"{line.keyword} {shown(line.rest)} is not a {parameter.noun}"
        raise line.error(f"{message}; {parameter.remedy}")
    return red, green, blue


def _parse_text(line: _Statement, parameter: Colored, text: str) -> Color:
    """Parse a colour that is named, or stands in a file beside this one."""
    with naming(line.keyword, line.source.path, lambda: line.source.line_number(line.offset)):
        return parameter.parse(text, line.source.path.parent)


def _read_map(line: _Statement, draft: Draft, textures: _Textures) -> None:
    options, name = _parse_options(line, draft)
    if options.bump != 1.0:
        draft.ignored.append(f"{line.keyword} -bm")
    is_data, parameter = line.keyword in _DATA, (_MAPS | _DATA)[line.keyword]
    is_linear, is_mask = line.keyword in _LINEAR, line.keyword == "map_d"
    most = math.inf if isinstance(parameter, Emission) else LARGEST_REFLECTANCE
    texture = _read_texture(line, options, name, textures, (is_linear, is_mask, most))
    if not is_data:
        draft.maps[line.keyword] = texture
    elif texture is not None:
        draft.data[line.keyword.removeprefix("map_")] = texture


def _parse_options(line: _Statement, draft: Draft) -> tuple[MapOptions, str]:
    try:
        options, name = parse_map(line.rest)
    except InputError as error:
        raise line.error(f"{line.keyword}: {error}") from None
    draft.ignored += [f"{line.keyword} {option}" for option in options.ignored]
    return options, name


def _read_texture(
    line: _Statement,
    options: MapOptions,
    name: str,
    textures: _Textures,
    kind: tuple[bool, bool, float],
) -> Texture | None:
    """Return a texture; None, and noted, where it cannot be read and that is allowed.

    kind : whether it is linear, whether it is a mask, and up to which value it may reach
    """
    is_linear, is_mask, most = kind
    folder = line.source.path.parent
    try:
        image = shared_image(named_image(folder, name), linear=is_linear, mask=is_mask)
        texture = Texture(image, options.scale[:2], options.offset[:2], options.clamp)
        check_texture(texture, most)
    except InputError as error:
        if textures.missing == "error":
            raise line.error(f"{line.keyword}: {error}{OR_WITHOUT}") from None
        textures.lost.append(line.naming(name))
        return None
    return texture


def _read_relief(line: _Statement, draft: Draft, textures: _Textures) -> None:
    """Read a map of normals, or of heights, times `-bm`.

    Blender writes normal maps as `map_Bump`: what looks like one is one. An image that cannot be
    read is named and left out, as many files name some that are not there.
    """
    options, name = _parse_options(line, draft)
    try:
        strict = _Textures("error")
        texture = _read_texture(line, options, name, strict, (True, False, math.inf))
    except InputError:
        textures.flat.append(line.naming(name))
        return
    if texture is None or options.bump == 0.0:
        return
    looks = np.allclose(texture.mean, _FLAT, atol=_NEAR_FLAT)
    is_directions = line.keyword == "norm" or looks
    try:
        kind = NormalMap if is_directions else BumpMap
        relief = kind(texture, options.bump)
        Part("relief", kinds={kind.kind: kind}).check(relief)
    except InputError as error:
        raise line.error(f"{line.keyword}: {error}") from None
    if isinstance(draft.relief, NormalMap) and not is_directions:
        draft.ignored.append(line.keyword)
        return
    if isinstance(draft.relief, BumpMap) and is_directions:
        draft.ignored.append(draft.relief_keyword)
    draft.relief, draft.relief_keyword = relief, line.keyword


def _read_opacity(line: _Statement) -> float:
    numbers = line.numbers()
    if not numbers or len(set(numbers)) > 1 or not math.isfinite(numbers[0]):
        raise line.error(f"{line.keyword} {shown(line.rest)}; write a finite number")
    if not 0.0 <= numbers[0] <= 1.0:
        message = f"{line.keyword} {shown(line.rest)} is not an opacity; keep it within [0, 1]"
        raise line.error(message)
    return numbers[0] if line.keyword == "d" else 1.0 - numbers[0]


def _read_number(line: _Statement, parameter: Parameter | None) -> float:
    numbers = line.numbers()
    if len(numbers) != 1 or not math.isfinite(numbers[0]):
        raise line.error(f"{line.keyword} {shown(line.rest)}; write a finite number")
    if parameter is not None:
        try:
            return parameter.check(numbers[0])
        except InputError as error:
            raise line.error(f"{line.keyword} {error}") from None
    return numbers[0]


def _is_neutral(line: _Statement) -> bool:
    """Return whether a statement that is not simulated has the value at which it does nothing."""
    if line.keyword != "d":
        return False
    numbers = line.numbers(line.rest.removeprefix("-halo").split())
    if not numbers or not all(map(math.isfinite, numbers)):
        raise line.error(f"{line.keyword} {shown(line.rest)}; write finite numbers")
    return all(number == 1.0 for number in numbers)


def _warn_of_changes(source: Source, drafts: dict[str, Draft], repeated: list[str]) -> None:
    """Name what was read but is not simulated, or not as it was written."""
    ignored: dict[str, dict[str, None]] = {}
    for name, draft in drafts.items():
        for keyword in draft.ignored:
            ignored.setdefault(keyword, {})[name] = None
    if ignored:
        uses = [
            f"{shown(keyword)} of {listed(names)}{_MEANING.get(keyword, '')}"
            for keyword, names in ignored.items()
        ]
        warn(f"{source.path}: not simulated: {'; '.join(uses)}")
    for keyword in _PARAMETERS:
        if clamped := [name for name, draft in drafts.items() if keyword in draft.clamped]:
            warn(f"{source.path}: {keyword} above 1 is lowered to 1 in {listed(clamped)}")
    for keyword in (*_DATA, "map_Ks"):
        if averaged := [name for name, draft in drafts.items() if keyword in draft.averaged]:
            warn(f"{source.path}: the mean of {keyword} stands for it in {listed(averaged)}")
    if repeated:
        warn(f"{source.path}: newmtl is repeated, and the last one is used: {listed(repeated)}")


@dataclass(frozen=True)
class MapOptions:
    """How a texture lies on a surface.

    The texture is looked up at `scale` · (u, v, w) + `offset`.
    """

    scale: Triple = (1.0, 1.0, 1.0)  # `-s`
    offset: Triple = (0.0, 0.0, 0.0)  # `-o`
    clamp: bool = False  # `-clamp`, the texture ends at the unit square; otherwise it repeats
    bump: float = 1.0  # `-bm`, by which heights are multiplied
    ignored: tuple[str, ...] = ()  # options that would change the picture, such as "-mm"


def parse_map(words: str | Sequence[str]) -> tuple[MapOptions, str]:
    """Read what follows `map_Kd` and similar keywords.

    words : options and a file name; given as one text, the name keeps its spaces
    Returns the options, and the file name
    """
    text = (words if isinstance(words, str) else " ".join(words)).strip()
    numbers: dict[str, tuple[float, ...]] = dict(_NUMBERS)
    clamp = False
    ignored: dict[str, None] = {}
    while text.startswith("-"):
        option, text = _pop(text)
        if option not in OPTIONS:
            message = f"option {shown(option)} is not known"
            raise InputError(f"{message}; {suggest(option, OPTIONS)}")
        if option in _NUMBERS:
            numbers[option], text = _read_numbers(option, text)
            changes = numbers[option] != _NUMBERS[option]
        else:
            word, text = _read_word(option, text)
            changes = word != _SWITCHES.get(option)
        if option == "-clamp":
            clamp = word == "on"
        elif option not in _SIMULATED and changes:
            ignored[option] = None
        else:
            ignored.pop(option, None)
    if not text:
        raise InputError("names no file; write one after the options")
    (s, t, w), (u, v, depth), (bump,) = (numbers[option] for option in _SIMULATED)
    return MapOptions((s, t, w), (u, v, depth), clamp, bump, tuple(ignored)), text


def _pop(text: str) -> tuple[str, str]:
    word, *rest = text.split(maxsplit=1) or [""]
    return word, "".join(rest)


def _read_numbers(option: str, text: str) -> tuple[tuple[float, ...], str]:
    """Read the numbers of an option; those that may be left out change nothing."""
    neutral, numbers = _NUMBERS[option], list[float]()
    while len(numbers) < len(neutral):
        word, rest = _pop(text)
        if not _NUMBER.fullmatch(word):
            break
        if not math.isfinite(float(word)):
            raise InputError(f"{option} {shown(word)} is too large; write a smaller number")
        numbers.append(float(word))
        text = rest
    if not numbers or (len(numbers) < len(neutral) < 3):
        plural = f"{len(neutral)} number{'s' * (len(neutral) > 1)}"
        raise _lacks(option, "one to three numbers" if len(neutral) == 3 else plural, text)
    return (*numbers, *neutral[len(numbers) :]), text


def _read_word(option: str, text: str) -> tuple[str, str]:
    known = ("on", "off") if option in _SWITCHES else _WORDS[option]
    word, rest = _pop(text)
    if word.lower() not in known:
        raise _lacks(option, f"{', '.join(known[:-1])} or {known[-1]}", text)
    return word.lower(), rest


def _lacks(option: str, needed: str, text: str) -> InputError:
    found = shown(_pop(text)[0]) if text else "nothing"
    return InputError(f"{option} is followed by {found}; write {needed} after it")


@dataclass
class _Textures:
    """How textures are read."""

    missing: MissingTextures  # what becomes of one that cannot be read
    lost: list[str] = field(default_factory=list)  # those that could not be read
    flat: list[str] = field(default_factory=list)  # images of relief that could not be read

    def warn(self) -> None:
        """Name what could not be read, and what became of it."""
        for names, one, several, fate in (
            (self.lost, "texture was", "textures were", "replaced by grey"),
            (self.flat, "image of relief was", "images of relief were", "left out"),
        ):
            if names:
                count = f"{len(names)} {several if len(names) > 1 else one}"
                warn(f"{count} not readable and {fate}: {enumerated(names)}")
