"""Materials by what they are made of: a Munsell chip, perhaps a pattern and a finish.

Their names say it all: "5R 5/10", "glazed 5R 5/10", "glossy wood of 10YR 5/6". So what a scene is
made of can be made lighter or darker by its names alone.
"""

from __future__ import annotations

import math
import re
import zlib
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.materials.procedures import LEVELS, PROCEDURES, paint
from photonmap.scene.material import Material
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import mean_color
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell, shipped_set

HUES = ("R", "YR", "Y", "GY", "G", "BG", "B", "PB", "P", "RP")
"""Munsell hue families in the order of the hue circle, ten steps each."""
GLAZED, GLOSSY = "glazed ", "glossy "
"""Finishes: a smooth coat that mirrors, and a rough one."""
COAT = 0.05
"""Specular reflectance of glaze and varnish."""
_ROUGH = (0.12, 0.45)
"""Range of the roughness of glossy surfaces, which the chip decides."""
_DARKEST, _LIGHTEST = 2, 9
"""Munsell values of the grey chips."""
_NOTATION = re.compile(r"([\d.]+)([A-Z]+) ([\d.]+)/([\d.]+)")
_GREY = re.compile(r"N(\d)")
_NAME = re.compile(rf"({GLAZED}|{GLOSSY})?(?:({'|'.join(PROCEDURES)}) of )?(.+)")


class Surface(NamedTuple):
    """What a material is made of: a chip, the name of a procedure or "", a finish or ""."""

    chip: str
    pattern: str = ""
    finish: str = ""

    @property
    def name(self) -> str:
        """The material's name."""
        return f"{self.finish}{f'{self.pattern} of ' * bool(self.pattern)}{self.chip}"

    def material(self) -> Material:
        """Return the material; equal surfaces have the same."""
        return _material(self)

    def lighter(self, step: int) -> Surface | None:
        """Return it with a chip so many values lighter; None if it is made of no chip."""
        chip = chip_beside(self.chip, step)
        return None if chip is None else self._replace(chip=chip)


def surface_of(name: str) -> Surface:
    """Return what a material is made of by its name."""
    found = _NAME.fullmatch(name)
    assert found is not None
    return Surface(found[3], found[2] or "", found[1] or "")


def reflectance_of(material: Material) -> float:
    """Return the mean reflectance of a material over its wavelengths, diffuse and mirrored."""
    color = mean_color(material.reflectance)
    diffuse = float(color.values.mean()) if isinstance(color, Spectrum) else 0.0
    mirrored = [part for part in (material.mirror, material.glossy) if isinstance(part, float)]
    return diffuse + sum(mirrored)


@cache
def chips() -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """Return the chromatic chips that are shipped: names, and hue (0 to 100), value and chroma."""
    found = [match for name in shipped_set().names if (match := _NOTATION.fullmatch(name))]
    rows = [
        (10.0 * HUES.index(match[2]) + float(match[1]), float(match[3]), float(match[4]))
        for match in found
    ]
    return tuple(match[0] for match in found), np.array(rows)


@cache
def chip_beside(name: str, shift: int) -> str | None:
    """Return the chip that is `shift` values lighter; None if the name is not that of a chip."""
    if grey := _GREY.fullmatch(name):
        return f"N{min(max(int(grey[1]) + shift, _DARKEST), _LIGHTEST)}"
    names, rows = chips()
    if name not in names:
        return None
    hue, value, chroma = rows[names.index(name)]
    turn = np.abs((rows[:, 0] - hue + 50.0) % 100.0 - 50.0)
    cost = 100.0 * np.abs(rows[:, 1] - value - shift) + turn + 0.5 * np.abs(rows[:, 2] - chroma)
    return names[int(np.argmin(cost))]


@cache
def _material(surface: Surface) -> Material:
    paint_ = _texture(surface) if surface.pattern else _chip(surface.chip)
    if surface.finish == GLAZED and isinstance(paint_, Spectrum):
        return Material(surface.name, (1.0 - COAT) * paint_, mirror=COAT)
    if surface.finish == GLOSSY:
        low, high = _ROUGH
        rough = low + (high - low) * _fraction(surface.chip)
        return Material.plastic(surface.name, paint_, roughness=round(rough, 2))
    return Material(surface.name, paint_)


def _chip(notation: str) -> Spectrum:
    """Return a chip's reflectance; the outer values hold beyond, where cameras still see a trace.

    Recovered chips end at 730 nm, while curves of cameras and observers lead to 780 nm or more.
    """
    return replace(munsell(notation), extrapolate=True)


def _texture(surface: Surface) -> SpectralTexture:
    """Return an image of mixtures of a chip with one that is darker, or lighter."""
    procedure = PROCEDURES[surface.pattern]
    away = -procedure.darker if _value(surface.chip) > _DARKEST + procedure.darker else 1
    first = munsell(surface.chip)
    second = munsell(chip_beside(surface.chip, away) or surface.chip)(first.wavelengths)
    palette = [
        Spectrum(first.wavelengths, (1.0 - share) * first.values + share * second)
        for share in np.linspace(0.0, 1.0, LEVELS)
    ]
    seed = zlib.crc32(f"{surface.pattern} of {surface.chip}".encode())
    image = paint(surface.pattern, np.random.Generator(np.random.PCG64(seed)))
    wide, high = procedure.period
    return SpectralTexture.from_palette(image, palette, scale=(1.0 / wide, 1.0 / high))


def _value(chip: str) -> float:
    """Return the Munsell value of a chip."""
    found = _NOTATION.fullmatch(chip)
    return float(found[3]) if found else float(chip.removeprefix("N"))


def _fraction(name: str) -> float:
    """Return a number from 0 to 1 that a name decides."""
    return zlib.crc32(name.encode()) / 2.0**32


def whole_step(chip: str, step: float) -> int:
    """Return a step rounded up or down, as a chip decides, so that the mean is the step."""
    return math.floor(step + _fraction(chip))
