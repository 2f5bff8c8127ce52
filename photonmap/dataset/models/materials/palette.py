"""Materials of a scene: Munsell chips drawn at random, coats, metal and glass."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.materials.surfaces import GLAZED, GLOSSY, Surface, chips, surface_of
from photonmap.errors import InputError
from photonmap.scene.material import Material

_TEXTURED = ("textured", "rich")
_METAL, _GLASS = "metal", "glass"
MATERIALS = ("lambertian", "mixed", "textured", "glossy", "rich")
"""Chips alone; with mirror coats, metal and glass; with textures; with rough coats and metal, and
glass; the last two together."""


@cache
def _chips_within(
    value: tuple[float, float], chroma: tuple[float, float]
) -> tuple[list[str], NDArray[np.float64]]:
    """Return names and hues of the chips within ranges of value and chroma."""
    names, rows = chips()
    low, high = np.array([value, chroma]).T
    fits = np.flatnonzero(((rows[:, 1:] >= low) & (rows[:, 1:] <= high)).all(axis=1))
    return [names[row] for row in fits], rows[fits, 0]


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
        `photonmap.dataset.models.materials.lightness`; None for that of the chips as they are drawn

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
        self._rough, self._textured = materials in ("glossy", "rich"), materials in _TEXTURED
        self.key = float(rng.uniform(0.0, 100.0))
        """The dominant hue, 0 to 100."""

    def grey(self, value: int) -> Material:
        """Return the neutral chip of a Munsell value from 2 to 9."""
        return Surface(f"N{value}").material()

    def chip(
        self,
        hue: float | None = None,
        value: tuple[float, float] = (4, 7),
        chroma: tuple[float, float] = (6, 12),
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

    def colors(
        self, count: int, value: tuple[float, float] = (4, 8), chroma: float = 6.0
    ) -> list[Material]:
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

    def patterned(self, procedure: str, material: Material) -> Material:
        """Return a chip in a pattern of `PROCEDURES`, if materials are textured."""
        if not self._textured:
            return material
        return surface_of(material.name)._replace(pattern=procedure).material()

    def varnished(self, material: Material) -> Material:
        """Return a floor's material, under a rough coat if materials are glossy."""
        if not self._rough:
            return material
        return surface_of(material.name)._replace(finish=GLOSSY).material()

    def glazed(self, material: Material) -> Material:
        """Return a chip under a coat, if there are coats."""
        if not self.mixed or material.name in (_METAL, _GLASS):
            return material
        finish = GLOSSY if self._rough else GLAZED
        return surface_of(material.name)._replace(finish=finish).material()

    def metal(self) -> Material:
        """Return metal, polished or rough; a grey chip where there is none."""
        if not self.mixed:
            return self.grey(6)
        return _rough_metal() if self._rough else _polished_metal()

    def glass(self, material: Material) -> Material:
        """Return clear glass for a closed shape; `material` itself where there is none."""
        return _clear_glass() if self.mixed else material

    def choice(self, materials: Sequence[Material]) -> Material:
        """Draw one of several materials."""
        return materials[int(self._rng.integers(len(materials)))]


@cache
def _polished_metal() -> Material:
    return Material.polished(_METAL, 0.85)


@cache
def _rough_metal() -> Material:
    return Material.metal(_METAL, 0.85, 0.35)


@cache
def _clear_glass() -> Material:
    return Material.glass(_GLASS, 1.5, 0.97)
