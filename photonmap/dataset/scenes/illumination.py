"""Illuminations: the spectra of a scene's lights, and their shares, by name or drawn at random.

Lights whose spectra are in files are identified by what is in the files, not by where they are.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path

import numpy as np

from photonmap.dataset.scenes.random_lights import RANDOM, RandomLights
from photonmap.errors import InputError
from photonmap.runtime.wording import suggest
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import EXTRAPOLATE, Spectrum
from photonmap.spectra.daylight import ClearSky
from photonmap.spectra.sensitivities import table_of
from photonmap.spectra.tables import read_table

WHITE = "D65"
COLORED = ("planck:2200", "planck:20000", "HPS", "H38HT-100 (Mercury)", "LED-RGB1")
WARM = ("planck:2300", "planck:2700", "planck:3000")
COOL = ("planck:9000", "planck:12000", "planck:20000")
NON_PLANCKIAN = (
    ("H38HT-100 (Mercury)", "LED-V1"),
    ("HPS", "FL3.15"),
    ("F40/C75 (Broadband FL)", "LED-RGB1"),
    ("FL12", "LED-B5"),
)
NON_PLANCKIAN_ULTRAVIOLET = (("led:405,15", "led:560,120"), ("black light", "led:590,100"))
"""Instead of these, in bands of ultraviolet, where lamps were not measured."""
ILLUMINATIONS = ("white", "colored", "two_planckian", "two_mixed")
"""White; one coloured light; a cool and a warm black body; two lights that are not black bodies."""
CLEAR_SKY = "clear_sky"
"""A clear sky, of random haze and hour; outdoors with its sun."""
ULTRAVIOLET = {"black_light": ("black light",), "led_405": ("led:405,15",)}
"""Lamps that excite fluorescence and can hardly be seen."""
NAMED = (*ILLUMINATIONS, *RANDOM, CLEAR_SKY, *ULTRAVIOLET)
"""All illuminations that have a name."""

_SKY = re.compile(r"D\d+|daylight:.*|sky:.*|planck:(\d+(?:\.\d+)?)")
_CLEAR = re.compile(r"sky:\s*([\d.]+)[,\s]+([\d.]+)")
_HAZE, _HEIGHT = (2.0, 6.0), (12.0, 65.0)
"""Ranges of the turbidity of clear skies, and of the height of their sun, degrees."""
_BY_POWER = ("led:", "black light")
_COOLEST = 4500.0  # lowest temperature of a black body that may be a sky, kelvins

MAIN_SHARE = 0.6
"""Share of the first of several lights whose shares are not given; the others divide the rest."""
_DIGITS = 10  # digits of the digest of a light's file
_SUM = 1e-3  # largest difference between 1 and the sum of shares


@dataclass(frozen=True)
class Illumination:
    """The spectra of a scene's lights.

    Parameters
    ----------
    name : of the illumination, such as one of `ILLUMINATIONS`
    colors : one or more lights, as text that `photonmap.spectra.color_text` reads
    shares : of the light, one for each colour; () for `MAIN_SHARE` from the scene's main lights,
        the rest divided evenly

    Raises
    ------
    InputError : there is no colour, or the shares do not fit
    """

    name: str
    colors: tuple[str, ...]
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check that shares fit the colours."""
        if isinstance(self.colors, str) or not self.colors:
            raise InputError(
                f"illumination {self.name!r} has the colours {self.colors!r}; "
                'give one or more in a tuple, as in ("D65",)'
            )
        if not self.shares:
            return
        if len(self.shares) != len(self.colors):
            raise InputError(
                f"illumination {self.name!r} has {len(self.colors)} colours and "
                f"{len(self.shares)} shares; give one share for each colour"
            )
        if not (min(self.shares) > 0.0 and abs(sum(self.shares) - 1.0) <= _SUM):
            raise InputError(
                f"illumination {self.name!r} has shares {list(self.shares)}; give positive numbers "
                f"that add up to 1"
            )


AnyIllumination = str | Illumination | RandomLights
"""One of `NAMED`, or your own."""


def find_illumination(illumination: AnyIllumination) -> AnyIllumination:
    """Return the lights that a name of `NAMED` draws at random; any other illumination unchanged.

    Raises
    ------
    InputError : there is no illumination of that name
    """
    if not isinstance(illumination, str):
        return illumination
    if illumination not in NAMED:
        raise InputError(
            f"there is no illumination {illumination!r}; {suggest(illumination, NAMED)}"
        )
    return RANDOM.get(illumination, illumination)


def choose_illumination(
    illumination: AnyIllumination, rng: np.random.Generator, bands: Bands | None = None
) -> Illumination:
    """Draw the lights of an illumination that leaves a choice, as `find_illumination` finds it.

    They are drawn among lights whose spectra are known in all bands, if these are given.
    """

    def is_known(light: str) -> bool:
        try:
            return bands is None or bands.emission(light_spectrum(light)) is not None
        except InputError:
            return False

    found = find_illumination(illumination)
    if isinstance(found, Illumination):
        return found
    if isinstance(found, RandomLights):
        return Illumination(found.name, *found.draw(rng, is_known))
    pairs = [pair for pair in NON_PLANCKIAN if all(map(is_known, pair))]
    pairs = pairs or [*NON_PLANCKIAN_ULTRAVIOLET]
    pick = {
        "white": (WHITE,),
        "colored": (str(rng.choice([*filter(is_known, COLORED)])),),
        "two_planckian": (str(rng.choice(COOL)), str(rng.choice(WARM))),
        "two_mixed": pairs[int(rng.integers(len(pairs)))],
        **ULTRAVIOLET,
        CLEAR_SKY: (f"sky:{rng.uniform(*_HAZE):.1f},{rng.uniform(*_HEIGHT):.0f}",),
    }
    return Illumination(found, pick[found])


def light_spectrum(name: str, folder: str | PathLike[str] = ".") -> Spectrum:
    """Return the spectrum of a light by its name, scaled to a luminance of 1.

    Narrow ultraviolet has next to none: LEDs by their peak, and black light, are scaled to a
    radiance of 1 in the mean over 400 to 700 nm.

    Parameters
    ----------
    name : as `photonmap.spectra.color_text` reads it
    folder : that the name of a file is relative to

    Raises
    ------
    InputError : the name is not that of a spectrum of light
    """
    return _known_light(name) if light_file(name) is None else _read_light(name, folder)


def _read_light(name: str, folder: str | PathLike[str] = ".") -> Spectrum:
    from photonmap.spectra.observer import normalise_luminance

    color = emission(name, folder)
    if isinstance(color, Spectrum) and name.lower().startswith(_BY_POWER):
        return color
    if isinstance(color, Spectrum):
        return normalise_luminance(color)
    raise InputError(
        f"{name!r} is not a spectrum of light; give a name, planck:K, or the file of a spectrum"
    )


_known_light = cache(_read_light)


def is_sky(color: str) -> bool:
    """Return whether a light, by its name, may be that of a sky: daylight, or a cool black body."""
    found = _SKY.fullmatch(color)
    return found is not None and (found[1] is None or float(found[1]) >= _COOLEST)


def clear_sky(color: str) -> ClearSky | None:
    """Return the sky that a light names, as in "sky:3,45"; None if it is another light."""
    found = _CLEAR.fullmatch(color)
    return None if found is None else ClearSky(float(found[1]), float(found[2]))


def light_file(color: str) -> Path | None:
    """Return the file that a light names, perhaps with a factor after it; None if it names none."""
    return table_of(color) or table_of(color.rpartition(" ")[0])


def located_light(color: str, folder: Path) -> str:
    """Return a light with the absolute path of its file, if it has one, seen from a folder.

    A factor is left out, as the lights of data sets are scaled to a luminance of 1.
    """
    path = light_file(color)
    if path is None:
        return color
    held = EXTRAPOLATE if color.strip().startswith(EXTRAPOLATE) else ""
    return f"{held}{(folder / path).resolve()}"


def digest_of_light(color: str) -> str:
    """Return the digest of the curve in the file of a light; "" if it names none."""
    path = light_file(color)
    if path is None:
        return ""
    curve = read_table(path, kind="emission")[0]
    samples = curve.wavelengths.tobytes() + curve.values.tobytes()
    return hashlib.sha256(samples).hexdigest()[:_DIGITS]


def check_unchanged(color: str, digest: str) -> None:
    """Raise `InputError` if the file of a light has another curve than that of a digest."""
    if digest_of_light(color) != digest:
        raise InputError("has changed since the data set was begun; restore it", light_file(color))
