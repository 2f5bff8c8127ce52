"""Colours as text, as scene files and the command line write them.

    [extrapolate:] SOURCE [FACTOR]

where SOURCE is a number, `rgb:r,g,b`, `xyz:X,Y,Z`, `xyY:x,y,Y`, `planck:2856`,
`daylight:6504`, `sun:3,45` or `sky:3,45` (turbidity and height of the sun, degrees),
`led:405,15` (peak and full width at half maximum, nm), `black light`,
`munsell:5R 5/10`, `metal:Au`, `sfu:NAME`, a FILE.csv, or a name that colour-science knows: of a
light for an emission, of a ColorChecker patch for a reflectance.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import shown, suggest
from photonmap.spectra import names
from photonmap.spectra.curves import (
    EXTRAPOLATE,
    FILES,
    LARGEST_REFLECTANCE,
    VISIBLE,
    Color,
    Spectrum,
    SpectrumSet,
    check_reflectance,
)
from photonmap.spectra.daylight import ClearSky
from photonmap.spectra.metals import metal_by_source
from photonmap.spectra.munsell import munsell
from photonmap.spectra.observer import emission_of_xyz, normalise_luminance, reflectance_of_xyz
from photonmap.spectra.sensitivities import ENDS
from photonmap.spectra.tables import read_table

ILLUMINANTS = "PHOTONMAP_ILLUMINANTS"  # Environment variable that names the file of measured lights

_Source = Callable[[str, Path], Color]

_BY_TEMPERATURE: dict[str, Callable[[float], Spectrum]] = {
    "planck": names.planck,
    "daylight": names.daylight,
}
"""Lights that a temperature in K names."""
_BY_HEIGHT: dict[str, Callable[[ClearSky], Spectrum]] = {
    "sun": ClearSky.sun,
    "sky": ClearSky.skylight,
}
"""Lights that the turbidity and the height of the sun, degrees, name."""

_BLACK_LIGHT = ("black light", 368.0, 18.0)  # Of lamps of BaSi₂O₅:Pb behind Wood's glass
_PREFIXES = ("rgb", "xyz", "xyY", "munsell", "metal", *_BY_TEMPERATURE, *_BY_HEIGHT, "led", "sfu")
"""Of notations; no name has a colon."""

_UNFINISHED = re.compile(
    r"\w+:|munsell:( *N|.*/)|(rgb|xyz|xyY):[ ,]*[^ ,]+[ ,]+[^ ,]+[ ,]*"
    r"|(sun|sky|led):[ ,]*[^ ,]+[ ,]*",
    re.I,
)
"""What lacks the number after it, which is then no factor: "munsell:N" of "munsell:N 5"."""
_FACTOR = re.compile(r"\s+(?=[-+]?(?:[\d.]|nan\b|inf))", re.I)
"""What separates a source from what begins like a factor."""


def reflectance(text: str, folder: str | os.PathLike[str] = ".") -> Color:
    """Return the reflectance that a text names, within [0, 1].

    Parameters
    ----------
    text : as this module describes it
    folder : that file names are relative to

    Raises
    ------
    InputError : it names none, or one that leaves [0, 1] or covers less than 400 to 700 nm
    """
    color = _read(text, Path(folder), _reflectance_source)
    if isinstance(color, Spectrum):
        check_reflectance(color.wavelengths, color.values)
    elif not all(0.0 <= value <= 1.0 for value in _numbers_of(color)):
        raise InputError(f"{shown(text)} is not a reflectance; keep it between 0 and 1")
    return color


def emission(text: str, folder: str | os.PathLike[str] = ".") -> Color:
    """Return the radiance that a text names, W·m⁻²·sr⁻¹; named lights have Y = 1.

    Parameters
    ----------
    text : as this module describes it
    folder : that file names are relative to

    Raises
    ------
    InputError : it names none, or one that is negative or covers less than 400 to 700 nm
    """
    color = _read(text, Path(folder), _emission_source)
    values = color.values if isinstance(color, Spectrum) else _numbers_of(color)
    if not all(0.0 <= value < math.inf for value in values):
        raise InputError(f"{shown(text)} is not a light; write finite values of 0 or more")
    return color


def _read(text: str, folder: Path, source: _Source) -> Color:
    """Read a colour: its source, a prefix and a factor."""
    body = text.strip()
    held = body.startswith(EXTRAPOLATE)
    body = body.removeprefix(EXTRAPOLATE).strip()
    if not body:
        raise InputError(f"{shown(text)} is not a colour; write a number, a name or a file")
    color = _scaled(body, folder, source)
    if not isinstance(color, Spectrum):
        return color
    color = replace(color, extrapolate=held or color.extrapolate)
    with naming(shown(text.strip())):
        color.check_covers(*VISIBLE)
    return color


def _scaled(body: str, folder: Path, source: _Source) -> Color:
    """Read a source times the factor after it; what is wrong with that is told."""
    try:
        return _product(body, folder, source)
    except InputError:
        _check_factor(body, folder, source)
        raise


def _check_factor(body: str, folder: Path, source: _Source) -> None:
    """Raise `InputError` where a source is followed by what begins like a factor, but is none."""
    for found in _FACTOR.finditer(body):
        head, rest = body[: found.start()], body[found.end() :]
        if _UNFINISHED.fullmatch(head):
            continue
        try:
            source(head, folder)
        except InputError:
            continue
        problem = f"{shown(rest)} in {shown(body)} is not a factor"
        raise InputError(f"{problem}; write one finite number, as in {shown(f'{head} 0.5')}")


def _product(body: str, folder: Path, source: _Source) -> Color:
    """Read a source times the factor after it; a name may end in a number of its own."""
    head, _, last = body.rpartition(" ")
    head, factor = head.strip(), _number(last)
    if not head or factor is None or _UNFINISHED.fullmatch(head):
        return source(body, folder)
    prefix, colon, _ = head.partition(":")
    notation = colon and prefix != "sfu"
    if notation or _number(head) is not None or Path(head).suffix.lower() in FILES:
        return _times(source(head, folder), factor)
    try:
        return source(body, folder)
    except InputError as unknown:
        try:
            return _times(source(head, folder), factor)
        except InputError:
            raise unknown from None


def _times(color: Color, factor: float) -> Color:
    if isinstance(color, tuple):
        red, green, blue = color
        return red * factor, green * factor, blue * factor
    return color * factor


def _numbers_of(color: float | tuple[float, float, float]) -> tuple[float, ...]:
    return color if isinstance(color, tuple) else (color,)


def _reflectance_source(body: str, folder: Path) -> Color:
    prefix, _, rest = body.partition(":")
    if prefix in ("xyz", "xyY"):
        return reflectance_of_xyz(_xyz(prefix, rest))
    if prefix == "munsell":
        return munsell(rest)
    if prefix == "metal":
        return metal_by_source(rest.strip(), folder)
    if prefix in (*_BY_TEMPERATURE, *_BY_HEIGHT, "led", "sfu"):
        raise InputError(f"{shown(body)} is a light, not a reflectance; name a reflectance")
    common = _common_source(body, folder, LARGEST_REFLECTANCE, "reflectance")
    return names.patch(body) if common is None else common


def _emission_source(body: str, folder: Path) -> Color:
    prefix, _, rest = body.partition(":")
    if prefix in ("xyz", "xyY"):
        return emission_of_xyz(_xyz(prefix, rest))
    if prefix in _BY_TEMPERATURE:
        kelvin = _number(rest)
        if kelvin is None:
            raise InputError(f"{shown(body)} needs a temperature in K, as in {prefix}:5000")
        return _BY_TEMPERATURE[prefix](kelvin)
    if prefix in _BY_HEIGHT:
        haze, height = _several(body, rest, ("3", "45"))
        return normalise_luminance(_BY_HEIGHT[prefix](ClearSky(haze, height)))
    if prefix == "led":
        return _led(*_several(body, rest, ("405", "15")))
    if body.lower() == _BLACK_LIGHT[0]:
        return _led(*_BLACK_LIGHT[1:])
    if re.sub(r"\W|_", "", body.lower()) == "blacklight":
        raise InputError(f"there is no light {shown(body)}; {suggest(body, _BLACK_LIGHT[:1])}")
    if prefix == "sfu":
        return measured_illuminants()[rest.strip()]
    if prefix in ("munsell", "metal"):
        raise InputError(f"{shown(body)} is a reflectance, not a light; name a light")
    common = _common_source(body, folder, math.inf, "emission")
    return names.light(body) if common is None else common


def _led(peak: float, width: float) -> Spectrum:
    """Return a Gaussian of a peak and a width, nm, as bright as the constant 1 over 400 to 700 nm.

    Its radiance in all, not its luminance, which is next to nothing in the ultraviolet.
    """
    if not (ENDS[0] <= peak <= ENDS[1] and 2.0 <= width <= 200.0):
        raise InputError(
            f"led:{peak:g},{width:g}: give a peak from {ENDS[0]:g} to {ENDS[1]:g} nm, and a width "
            "from 2 to 200 nm"
        )
    wavelengths = np.arange(ENDS[0], ENDS[1] + 0.5)
    curve = np.exp(-4.0 * math.log(2.0) * ((wavelengths - peak) / width) ** 2)
    curve[curve < 1e-6] = 0.0
    scale = (VISIBLE[1] - VISIBLE[0]) / np.trapezoid(curve, wavelengths)
    return Spectrum(wavelengths, scale * curve)


def _common_source(body: str, folder: Path, highest: float, kind: str) -> Color | None:
    """Read a number, an RGB triple or a file; None if it is a name."""
    if (number := _number(body)) is not None:
        return number
    if body.startswith("rgb:"):
        return _triple(body, body.removeprefix("rgb:"))
    if Path(body).suffix.lower() in FILES:
        path = named_file(folder, body)
        table = read_table(path, 0.0, highest, kind)
        if len(table) > 1:
            raise InputError(
                f"has {len(table)} curves; keep one wavelength and one value per row", path
            )
        return table[0]
    prefix, colon, _ = body.partition(":")
    if colon:
        known = suggest(f"{prefix}:", [f"{each}:" for each in _PREFIXES])
        what = "a light" if kind == "emission" else f"a {kind}"
        problem = f"{shown(body)} is not {what}: there is no notation '{prefix}:'"
        raise InputError(f"{problem}; {known}")
    return None


def _xyz(prefix: str, rest: str) -> tuple[float, float, float]:
    first, second, third = _triple(f"{prefix}:{rest}", rest)
    if prefix == "xyz":
        return first, second, third
    if not 0.0 < second <= 1.0:
        raise InputError(f"xyY:{rest}: y must be above 0 and at most 1")
    return first * third / second, third, (1.0 - first - second) * third / second


def _triple(text: str, numbers: str) -> tuple[float, float, float]:
    first, second, third = _several(text, numbers, (".2", ".3", ".4"))
    return first, second, third


def _several(text: str, numbers: str, example: tuple[str, ...]) -> list[float]:
    """Return as many numbers as an example has."""
    values = [_number(word) for word in numbers.replace(",", " ").split()]
    found = [value for value in values if value is not None]
    if len(found) == len(values) == len(example):
        return found
    count = {2: "two", 3: "three"}[len(example)]
    name = text.partition(":")[0]
    raise InputError(f"{shown(text)} needs {count} numbers, as in {name}:{','.join(example)}")


def _number(text: str) -> float | None:
    """Return a finite decimal number; None if the text is not one."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def measured_illuminants() -> SpectrumSet:
    """Return the measured lights of the file that `ILLUMINANTS` names, or raise `InputError`."""
    path = os.environ.get(ILLUMINANTS)
    if not path:
        raise InputError(
            f"sfu: needs the file of measured lights; give --illuminants PATH, or set {ILLUMINANTS}"
        )
    return _read_illuminants(path)


@cache
def _read_illuminants(path: str) -> SpectrumSet:
    from photonmap.spectra.measured import read_illuminants

    return read_illuminants(path)
