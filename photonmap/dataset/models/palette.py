"""Materials of a scene: Munsell chips drawn at random, coats, metal and glass."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.scene.material import Material
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell, shipped_set

_NOTATION = re.compile(r"([\d.]+)([A-Z]+) ([\d.]+)/([\d.]+)")
HUES = ("R", "YR", "Y", "GY", "G", "BG", "B", "PB", "P", "RP")
"""Munsell hue families in the order of the hue circle, ten steps each."""
COAT = 0.05
"""Specular reflectance of glaze and varnish."""
GLAZED = "glazed "
"""What the name of a chip under a coat begins with."""
MATERIALS = ("lambertian", "mixed")


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
    materials : "lambertian"; or "mixed", where ceramics and varnished wood have a specular coat,
        metal is a mirror and bottles are glass

    lightness : mean reflectance of the finished scene, see `photonmap.dataset.models.lightness`;
        None for that of the chips as they are drawn

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
                f"materials {materials!r} is neither {' nor '.join(map(repr, MATERIALS))}"
            )
        self._rng, self._known = rng, dict[str, Material]()
        self.mixed, self.lightness = materials == "mixed", lightness
        self.key = float(rng.uniform(0.0, 100.0))
        """The dominant hue, 0 to 100."""

    def grey(self, value: int) -> Material:
        """Return the neutral chip of a Munsell value from 2 to 9."""
        return self._material(f"N{value}")

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
            return self._material(names[int(self._rng.integers(len(names)))])
        away = np.abs((hues - hue + 50.0) % 100.0 - 50.0)
        fits = np.flatnonzero(away <= max(spread, float(away.min())))
        return self._material(names[int(fits[self._rng.integers(len(fits))])])

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
        """Draw a chip in a colour of wood."""
        return self.chip(float(self._rng.uniform(14.0, 22.0)), (4, 6), (4, 6))

    def fabric(self) -> Material:
        """Draw a chip of medium chroma."""
        return self.chip(None, (3, 7), (4, 8))

    def pale(self) -> Material:
        """Draw a light chip of low chroma."""
        return self.chip(None, (7, 8), (2, 4))

    def glazed(self, material: Material) -> Material:
        """Return a chip under a specular coat; the base receives only what the coat transmits."""
        if not self.mixed or not isinstance(material.reflectance, Spectrum):
            return material
        name = f"{GLAZED}{material.name}"
        made = Material(name, (1.0 - COAT) * material.reflectance, mirror=COAT)
        return self._known.setdefault(name, made)

    def metal(self) -> Material:
        """Return polished metal; a grey chip if materials are Lambertian."""
        made = Material.polished("metal", 0.85)
        return self._known.setdefault(made.name, made) if self.mixed else self.grey(6)

    def glass(self, material: Material) -> Material:
        """Return clear glass for a closed shape; `material` itself if materials are Lambertian."""
        made = Material.glass("glass", 1.5, 0.97)
        return self._known.setdefault(made.name, made) if self.mixed else material

    def choice(self, materials: Sequence[Material]) -> Material:
        """Draw one of several materials."""
        return materials[int(self._rng.integers(len(materials)))]

    def _material(self, name: str) -> Material:
        if name not in self._known:
            self._known[name] = Material(name, munsell(name))
        return self._known[name]
