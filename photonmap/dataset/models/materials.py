"""Materials of a scene: Munsell chips drawn at random, with patterns and finishes; metal; glass.

Their names say what they are made of: "5R 5/10", "glazed 5R 5/10", "glossy wood of 10YR 5/6". So
what a scene is made of can be made lighter or darker by its names alone.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.shapes import Floats, Random
from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import mean_color
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.fluorophores import named
from photonmap.spectra.munsell import munsell, shipped_set

LEVELS = 16
"""Mixtures of the two colours of a pattern, the pure ones included."""
HUES = ("R", "YR", "Y", "GY", "G", "BG", "B", "PB", "P", "RP")
"""Munsell hue families in the order of the hue circle, ten steps each."""
GLAZED, GLOSSY, FLUORESCENT = "glazed ", "glossy ", "fluorescent "
"""Finishes: a smooth coat that mirrors, a rough one, and a dye or brightener."""
COAT = 0.05
"""Specular reflectance of glaze and varnish."""
MATERIALS = ("lambertian", "mixed", "textured", "glossy", "rich", "fluorescent")
"""Chips alone; with mirror coats, metal and glass; with textures; with rough coats and metal, and
glass; the last two together; chips of which white ones, textiles and saturated ones fluoresce."""
_DYES = {
    "R": "lumogen red 305", "YR": "rhodamine b", "Y": "rhodamine 6g", "GY": "fluorescein",
    "G": "coumarin 6",
}  # fmt: skip
"""By the hue of chips; others, and greys, have the brightener of paper and textiles."""
_BRIGHTENER = "optical brightener"
_TAKEN = 0.8  # fraction of the light that a dye takes up at its peak
_DYED: Floats = np.arange(280.0, 801.0)
_ROUGH = (0.12, 0.45)  # range of the roughness of glossy surfaces, which the chip decides
_DARKEST, _LIGHTEST = 2, 9  # Munsell values of the grey chips
_METAL, _GLASS = "metal", "glass"
_ROUGH_METAL, _POLISHED_METAL = Material.metal(_METAL, 0.85, 0.35), Material.polished(_METAL, 0.85)
_CLEAR_GLASS = Material.glass(_GLASS, 1.5, 0.97)
_NOTATION = re.compile(r"([\d.]+)([A-Z]+) ([\d.]+)/([\d.]+)")
_GREY = re.compile(r"N(\d)")

Range = tuple[float, float]
"""Lowest and highest value."""
T = TypeVar("T")


class Procedure(NamedTuple):
    """A way to paint.

    Parameters
    ----------
    paint : returns which mixture a texel has, (H, W), from 0, the first colour, to `LEVELS` - 1
    size : (H, W), texels
    period : width and height of the image on surfaces, metres; u runs along the grain
    darker : steps of Munsell value from the first colour to the second
    """

    paint: Callable[[Random, Floats, Floats], Floats]
    size: tuple[int, int]
    period: tuple[float, float]
    darker: int


def _waves(rng: Random, x: Floats, y: Floats, most: tuple[int, int], count: int = 24) -> Floats:
    """Return smooth noise of variance about 1 that repeats; up to `most` waves along x and y."""
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    strength = 0.0
    for _ in range(count):
        i, k = int(rng.integers(-most[0], most[0] + 1)), int(rng.integers(0, most[1] + 1))
        weight = 1.0 / (1.0 + np.hypot(i / max(most[0], 1), k / max(most[1], 1)) * 3.0)
        phase = rng.uniform(0.0, 2.0 * np.pi)
        total += weight * np.cos(2.0 * np.pi * (i * x + k * y) + phase)
        strength += 0.5 * weight**2
    return total / np.sqrt(strength)


def wood(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return year rings cut along the grain, which is along x, with fine pores."""
    bend = 0.35 * _waves(rng, x, y, (2, 3))
    rings = 0.5 + 0.5 * np.sin(2.0 * np.pi * (6.0 * y + bend))
    fibre = _waves(rng, x, y, (5, 60), 40)
    return 0.15 + 0.6 * rings**3 + 0.09 * fibre


def marble(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return thin veins, warped twice, on a cloudy ground."""
    shift = [0.06 * _waves(rng, x, y, (4, 4)) for _ in range(2)]
    field = _waves(rng, x + shift[0], y + shift[1], (3, 3), 12)
    finer = _waves(rng, x + shift[1], y - shift[0], (7, 7), 20)
    veins = np.exp(-14.0 * np.abs(field)) + 0.5 * np.exp(-18.0 * np.abs(finer))
    return 0.1 + 0.08 * finer + 0.8 * veins


def cloth(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return a plain weave in a check: threads of two colours cross over and under."""
    threads = 48
    i, k = np.floor(x * threads).astype(int), np.floor(y * threads).astype(int)
    stripe = np.repeat(rng.random(threads // 4) < 0.4, 4)
    over = (i + k) % 2 == 0
    colored = np.where(over, stripe[i % threads], stripe[k % threads])
    across = np.where(over, x, y) * threads % 1.0
    shade = 0.25 * (2.0 * across - 1.0) ** 2
    return 0.1 + 0.6 * colored + shade


def tiles(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return tiles of slightly different shades with grout between them."""
    count = 4
    i, k = np.floor(x * count).astype(int), np.floor(y * count).astype(int)
    shade = 0.3 * rng.random((count, count))[i % count, k % count]
    edge = np.minimum.reduce([x * count % 1, 1 - x * count % 1, y * count % 1, 1 - y * count % 1])
    return np.where(edge < 0.025, 1.0, shade)


def print_(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return a pattern in two colours with sharp edges: dots, leaves, waves or diamonds."""
    kind, count = int(rng.integers(4)), int(rng.integers(3, 7))
    row = np.floor(y * 2 * count)
    u = (x * count + 0.5 * (row % 2)) % 1.0 - 0.5
    v = (y * 2 * count) % 1.0 - 0.5
    if kind == 0:
        inside = np.hypot(u, 0.5 * v) < 0.2
    elif kind == 1:
        inside = np.abs(v) < 0.42 * np.cos(np.pi * np.clip(2.2 * u, -0.5, 0.5)) ** 2 * (
            np.abs(u) < 0.23
        )
    elif kind == 2:
        inside = (y * count + 0.18 * np.sin(2.0 * np.pi * count * x)) % 1.0 < 0.4
    else:
        inside = np.abs(u) + 0.5 * np.abs(v) < 0.24
    return inside.astype(np.float64)


PROCEDURES = {
    "wood": Procedure(wood, (256, 256), (1.2, 0.5), 1),
    "marble": Procedure(marble, (256, 256), (1.1, 1.1), 3),
    "cloth": Procedure(cloth, (240, 240), (0.24, 0.24), 2),
    "tiles": Procedure(tiles, (240, 240), (0.8, 0.8), 2),
    "print": Procedure(print_, (256, 256), (0.6, 0.6), 1),
}
"""By the names that materials have."""


def paint(name: str, rng: Random) -> NDArray[np.int32]:
    """Return the image of a procedure: which mixture of two colours each texel is, (H, W)."""
    procedure = PROCEDURES[name]
    height, width = procedure.size
    x = (np.arange(width) + 0.5) / width
    y = (np.arange(height) + 0.5) / height
    amount = procedure.paint(rng, *np.meshgrid(x, y))
    return np.rint(np.clip(amount, 0.0, 1.0) * (LEVELS - 1)).astype(np.int32)


_NAME = re.compile(rf"({GLAZED}|{GLOSSY}|{FLUORESCENT})?(?:({'|'.join(PROCEDURES)}) of )?(.+)")


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
def chips() -> tuple[tuple[str, ...], Floats]:
    """Return the chromatic chips that are shipped: names, and hue (0 to 100), value and chroma."""
    found = [match for name in shipped_set().names if (match := _NOTATION.fullmatch(name))]
    rows = [
        (10.0 * HUES.index(match[2]) + float(match[1]), float(match[3]), float(match[4]))
        for match in found
    ]
    return tuple(match[0] for match in found), np.array(rows)


@cache
def _chips_within(value: Range, chroma: Range) -> tuple[list[str], Floats]:
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
    if surface.finish == FLUORESCENT:
        return _dyed(surface, chip)
    paint_ = _texture(surface) if surface.pattern else chip
    if surface.finish == GLAZED and isinstance(paint_, Spectrum):
        return Material(surface.name, (1.0 - COAT) * paint_, mirror=COAT)
    if surface.finish == GLOSSY:
        low, high = _ROUGH
        rough = low + (high - low) * _fraction(surface.chip)
        return Material.plastic(surface.name, paint_, roughness=round(rough, 2))
    return Material(surface.name, paint_)


def _dyed(surface: Surface, chip: Spectrum) -> Material:
    """Return a chip with a dye, which takes away what it takes up."""
    notation = _NOTATION.fullmatch(surface.chip)
    dye = named(_DYES.get(notation[2], _BRIGHTENER) if notation else _BRIGHTENER)
    dye = replace(dye, excitation=dye.excitation * _TAKEN)
    left = chip(_DYED) * (1.0 - dye.excitation(_DYED))
    return Material(surface.name, Spectrum(_DYED, left), fluorescence=dye)


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
        "rich" is both of these; where "fluorescent", white surfaces and textiles are brightened,
        and half of the saturated chips are dyes
    lightness : mean reflectance of the finished scene, see
        `photonmap.dataset.models.scene_object.with_lightness`; None for that of the
        chips as they are drawn

    Raises
    ------
    InputError : materials of another name
    """

    def __init__(
        self, rng: Random, materials: str = "lambertian", lightness: float | None = None
    ) -> None:
        if materials not in MATERIALS:
            known = ", ".join(map(repr, MATERIALS))
            raise InputError(f"materials {materials!r} must be one of {known}")
        self._rng, self.lightness = rng, lightness
        self.mixed = materials in ("mixed", "glossy", "rich")
        self._rough = materials in ("glossy", "rich")
        self._textured = materials in ("textured", "rich")
        self._fluorescent = materials == "fluorescent"
        self.key = float(rng.uniform(0.0, 100.0))
        """The dominant hue, 0 to 100."""

    def grey(self, value: int) -> Material:
        """Return the neutral chip of a Munsell value from 2 to 9."""
        white = Surface(f"N{value}").material()
        return self._fluoresce(white) if value == _LIGHTEST else white

    def _fluoresce(self, material: Material, share: float = 1.0) -> Material:
        """Return a chip with a dye, if materials fluoresce; `share` of the chips have one."""
        has_dye = self._fluorescent and _fraction(material.name) < share
        return _changed(material, finish=FLUORESCENT) if has_dye else material

    def chip(
        self,
        hue: float | None = None,
        value: Range = (4, 7),
        chroma: Range = (6, 12),
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

    def colors(self, count: int, value: Range = (4, 8), chroma: float = 6.0) -> list[Material]:
        """Draw chips whose hues are spread evenly around the circle, in random order."""
        start = self._rng.uniform(0.0, 100.0)
        hues = self._rng.permutation((start + 100.0 * np.arange(count) / count) % 100.0)
        chips_ = [self.chip(float(hue), value, (chroma, 14)) for hue in hues]
        return [self._fluoresce(chip, 0.5) for chip in chips_]

    def accent(self) -> Material:
        """Draw a saturated chip; two in five are close to the dominant hue."""
        hue = self.key if self._rng.random() < 0.4 else None
        return self._fluoresce(self.chip(hue, (4, 7), (8, 14), 8.0), 0.5)

    def wood(self) -> Material:
        """Draw a chip in a colour of wood, with its grain if materials are textured."""
        chip = self.chip(float(self._rng.uniform(14.0, 22.0)), (4, 6), (4, 6))
        return self.patterned("wood", chip)

    def fabric(self) -> Material:
        """Draw a chip of medium chroma, woven if materials are textured."""
        return self._fluoresce(self.patterned("cloth", self.chip(None, (3, 7), (4, 8))))

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
        if not self.mixed:
            return self.grey(6)
        return _ROUGH_METAL if self._rough else _POLISHED_METAL

    def glass(self, material: Material) -> Material:
        """Return clear glass for a closed shape; `material` itself where there is none."""
        return _CLEAR_GLASS if self.mixed else material

    def material_among(self, materials: Sequence[Material]) -> Material:
        """Draw one of several materials."""
        return materials[int(self._rng.integers(len(materials)))]


def _changed(material: Material, **parts: str) -> Material:
    return surface_of(material.name)._replace(**parts).material()


class Draw(Palette):
    """Draws the numbers of one scene, and, from random numbers of their own, its materials."""

    def __init__(
        self, rng: Random, materials: str = "lambertian", lightness: float | None = None
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
