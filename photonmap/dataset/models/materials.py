"""Materials of a scene: Munsell chips drawn at random, with patterns and finishes; metal; glass.

Their names say what they are made of: "5R 5/10", "glazed 5R 5/10", "glossy wood of 10YR 5/6". So
what a scene is made of can be made lighter or darker by its names alone.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.procedures import LEVELS, PROCEDURES, paint
from photonmap.errors import InputError
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
MATERIALS = ("lambertian", "mixed", "textured", "glossy", "rich")
"""Chips alone; with mirror coats, metal and glass; with textures; with rough coats and metal, and
glass; the last two together."""
_ROUGH = (0.12, 0.45)
"""Range of the roughness of glossy surfaces, which the chip decides."""
_DARKEST, _LIGHTEST = 2, 9
"""Munsell values of the grey chips."""
_METAL, _GLASS = "metal", "glass"
_NOTATION = re.compile(r"([\d.]+)([A-Z]+) ([\d.]+)/([\d.]+)")
_GREY = re.compile(r"N(\d)")
_NAME = re.compile(rf"({GLAZED}|{GLOSSY})?(?:({'|'.join(PROCEDURES)}) of )?(.+)")

Ends = tuple[float, float]
"""Lowest and highest value."""
T = TypeVar("T")


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

    def lighter(self, step: float) -> Surface | None:
        """Return it with a chip so many values lighter; None if it is made of no chip.

        It is rounded up or down, as the chip decides, so that the mean over chips is the step.
        """
        chip = _chip_beside(self.chip, math.floor(step + _fraction(self.chip)))
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
def _chips_within(value: Ends, chroma: Ends) -> tuple[list[str], NDArray[np.float64]]:
    """Return names and hues of the chips within ranges of value and chroma."""
    names, rows = chips()
    low, high = np.array([value, chroma]).T
    fits = np.flatnonzero(((rows[:, 1:] >= low) & (rows[:, 1:] <= high)).all(axis=1))
    return [names[row] for row in fits], rows[fits, 0]


@cache
def _chip_beside(name: str, shift: int) -> str | None:
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
    # Recovered chips end at 730 nm, while curves of cameras and observers lead to 780 nm or more.
    chip = replace(munsell(surface.chip), extrapolate=True)
    paint_ = _texture(surface) if surface.pattern else chip
    if surface.finish == GLAZED and isinstance(paint_, Spectrum):
        return Material(surface.name, (1.0 - COAT) * paint_, mirror=COAT)
    if surface.finish == GLOSSY:
        low, high = _ROUGH
        rough = low + (high - low) * _fraction(surface.chip)
        return Material.plastic(surface.name, paint_, roughness=round(rough, 2))
    return Material(surface.name, paint_)


def _texture(surface: Surface) -> SpectralTexture:
    """Return an image of mixtures of a chip with one that is darker, or lighter."""
    procedure, notation = PROCEDURES[surface.pattern], _NOTATION.fullmatch(surface.chip)
    value = float(notation[3] if notation else surface.chip.removeprefix("N"))
    away = -procedure.darker if value > _DARKEST + procedure.darker else 1
    first = munsell(surface.chip)
    second = munsell(_chip_beside(surface.chip, away) or surface.chip)(first.wavelengths)
    palette = [
        Spectrum(first.wavelengths, (1.0 - share) * first.values + share * second)
        for share in np.linspace(0.0, 1.0, LEVELS)
    ]
    seed = zlib.crc32(f"{surface.pattern} of {surface.chip}".encode())
    image = paint(surface.pattern, np.random.Generator(np.random.PCG64(seed)))
    wide, high = procedure.period
    return SpectralTexture.from_palette(image, palette, scale=(1.0 / wide, 1.0 / high))


def _fraction(name: str) -> float:
    """Return a number from 0 to 1 that a name decides."""
    return zlib.crc32(name.encode()) / 2.0**32


class Palette:
    """Draws the materials of one scene; the same chip is the same material.

    Parameters
    ----------
    rng : draws the chips
    materials : one of `MATERIALS`: where they are "mixed", ceramics and varnished wood have a
        specular coat, metal is a mirror and bottles are glass; where "glossy", coats and metal are
        rough, as are floors; where "textured", wood, cloth, stone and walls have patterns;
        "rich" is both of these
    lightness : mean reflectance of the finished scene, see
        `photonmap.dataset.models.scene_object.with_lightness`; None for that of the
        chips as they are drawn

    Raises
    ------
    InputError : materials of another name
    """

    def __init__(
        self,
        rng: np.random.Generator,
        materials: str = "lambertian",
        lightness: float | None = None,
    ) -> None:
        if materials not in MATERIALS:
            raise InputError(
                f"materials {materials!r} must be one of {', '.join(map(repr, MATERIALS))}"
            )
        self._rng, self.lightness = rng, lightness
        self.mixed = materials in ("mixed", "glossy", "rich")
        self._rough = materials in ("glossy", "rich")
        self._textured = materials in ("textured", "rich")
        self.key = float(rng.uniform(0.0, 100.0))
        """The dominant hue, 0 to 100."""

    def grey(self, value: int) -> Material:
        """Return the neutral chip of a Munsell value from 2 to 9."""
        return Surface(f"N{value}").material()

    def chip(
        self,
        hue: float | None = None,
        value: Ends = (4, 7),
        chroma: Ends = (6, 12),
        spread: float = 4.0,
    ) -> Material:
        """Draw a chip.

        Parameters
        ----------
        hue : 0 to 100, from red through yellow, green, blue and purple; None for any
        value, chroma : lowest and highest
        spread : greatest distance of the chip's hue from `hue`
        """
        names, hues = _chips_within(value, chroma)
        if hue is None:
            return Surface(names[int(self._rng.integers(len(names)))]).material()
        away = np.abs((hues - hue + 50.0) % 100.0 - 50.0)
        fits = np.flatnonzero(away <= max(spread, float(away.min())))
        return Surface(names[int(fits[self._rng.integers(len(fits))])]).material()

    def colors(self, count: int, value: Ends = (4, 8), chroma: float = 6.0) -> list[Material]:
        """Draw chips whose hues are spread evenly around the circle, in random order."""
        start = self._rng.uniform(0.0, 100.0)
        hues = self._rng.permutation((start + 100.0 * np.arange(count) / count) % 100.0)
        return [self.chip(float(hue), value, (chroma, 14)) for hue in hues]

    def accent(self) -> Material:
        """Draw a saturated chip; two in five are close to the dominant hue."""
        hue = self.key if self._rng.random() < 0.4 else None
        return self.chip(hue, (4, 7), (8, 14), 8.0)

    def wood(self) -> Material:
        """Draw a chip in a colour of wood, with its grain if materials are textured."""
        chip = self.chip(float(self._rng.uniform(14.0, 22.0)), (4, 6), (4, 6))
        return self.patterned("wood", chip)

    def fabric(self) -> Material:
        """Draw a chip of medium chroma, woven if materials are textured."""
        return self.patterned("cloth", self.chip(None, (3, 7), (4, 8)))

    def pale(self) -> Material:
        """Draw a light chip of low chroma."""
        return self.chip(None, (7, 8), (2, 4))

    def leaf(self) -> Material:
        """Draw a chip in a colour of leaves."""
        return self.chip(38.0, (3, 6), (4, 8), 6.0)

    def patterned(self, procedure: str, material: Material) -> Material:
        """Return a chip in a pattern of `PROCEDURES`, if materials are textured."""
        return _changed(material, pattern=procedure) if self._textured else material

    def varnished(self, material: Material) -> Material:
        """Return a floor's material, under a rough coat if materials are glossy."""
        return _changed(material, finish=GLOSSY) if self._rough else material

    def glazed(self, material: Material) -> Material:
        """Return a chip under a coat, if there are coats."""
        if not self.mixed or material.name in (_METAL, _GLASS):
            return material
        return _changed(material, finish=GLOSSY if self._rough else GLAZED)

    def metal(self) -> Material:
        """Return metal, polished or rough; a grey chip where there is none."""
        return _metal(self._rough) if self.mixed else self.grey(6)

    def glass(self, material: Material) -> Material:
        """Return clear glass for a closed shape; `material` itself where there is none."""
        return _clear_glass() if self.mixed else material

    def material_among(self, materials: Sequence[Material]) -> Material:
        """Draw one of several materials."""
        return materials[int(self._rng.integers(len(materials)))]


def _changed(material: Material, **parts: str) -> Material:
    return surface_of(material.name)._replace(**parts).material()


@cache
def _metal(rough: bool) -> Material:
    return Material.metal(_METAL, 0.85, 0.35) if rough else Material.polished(_METAL, 0.85)


@cache
def _clear_glass() -> Material:
    return Material.glass(_GLASS, 1.5, 0.97)


class Draw(Palette):
    """Draws the numbers of one scene, and, from random numbers of their own, its materials.

    Parameters
    ----------
    rng : draws the numbers
    materials, lightness : as of `Palette`
    """

    def __init__(
        self,
        rng: np.random.Generator,
        materials: str = "lambertian",
        lightness: float | None = None,
    ) -> None:
        super().__init__(rng.spawn(1)[0], materials, lightness)
        self.rng = rng

    def number(self, low: float, high: float) -> float:
        """Draw a number from a range."""
        return float(self.rng.uniform(low, high))

    def whole(self, least: int, most: int) -> int:
        """Draw a whole number from `least` to `most`."""
        return int(self.rng.integers(least, most + 1))

    def chance(self, probability: float) -> bool:
        """Draw whether something happens that has a probability."""
        return bool(self.rng.random() < probability)

    def one_of(self, options: Sequence[T]) -> T:
        """Draw one of several things."""
        return options[int(self.rng.integers(len(options)))]

    def several(self, options: Sequence[T], count: int) -> list[T]:
        """Draw some of several things, perhaps one more than once."""
        return [options[int(i)] for i in self.rng.integers(0, len(options), count)]
