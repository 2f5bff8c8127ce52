"""Illuminations: one or two colours of light, Planckian and not, and how a scene takes them on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.shapes import joined
from photonmap.dataset.things import Thing
from photonmap.errors import InputError
from photonmap.messages import suggest
from photonmap.scene import Material
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.text import emission

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
ILLUMINATIONS = ("white", "colored", "two_planckian", "two_mixed")
"""White light; colored light; warm and cool black bodies; two lamps that are no black bodies."""

_NEAREST = 0.15
"""Metres from a lamp, within which things are taken to be no brighter."""
_LEVEL = 1.0
"""Irradiance averaged over directions, W·m⁻², that lamps are set to."""

SHARES = (0.6, 0.4)
"""Of the light, that the first and the second of two lights give."""


@dataclass(frozen=True)
class Illumination:
    """The colours of a scene's lights.

    Parameters
    ----------
    name : one of `ILLUMINATIONS`, or any other
    colors : one or two lights, as `photonmap.spectra.text` describes them
    """

    name: str
    colors: tuple[str, ...]

    def __post_init__(self) -> None:
        """Refuse what is not one colour or two."""
        if len(self.colors) not in (1, 2):
            count = len(self.colors)
            raise InputError(f"illumination {self.name!r} has {count} colours; give one or two")


def choose_illumination(illumination: str | Illumination, rng: np.random.Generator) -> Illumination:
    """Draw the colours of an illumination; one that has them stays as it is.

    Raises
    ------
    InputError : it is none of `ILLUMINATIONS`
    """
    if isinstance(illumination, Illumination):
        return illumination
    if illumination not in ILLUMINATIONS:
        remedy = suggest(str(illumination), ILLUMINATIONS)
        raise InputError(f"there is no illumination {illumination!r}; {remedy}")
    pick = {
        "white": (WHITE,),
        "colored": (str(rng.choice(COLORED)),),
        "two_planckian": (str(rng.choice(COOL)), str(rng.choice(WARM))),
        "two_mixed": NON_PLANCKIAN[int(rng.integers(len(NON_PLANCKIAN)))],
    }
    return Illumination(illumination, pick[illumination])


@cache
def light(name: str) -> Spectrum:
    """Return a light by its text, scaled to a luminance of 1.

    Raises
    ------
    InputError : it names none
    """
    from photonmap.spectra.observer import normalise_luminance

    color = emission(name)
    if isinstance(color, Spectrum):
        return normalise_luminance(color)
    raise InputError(f"{name!r} is no spectrum of light; give a name, planck:K, or a file of one")


def radiance_of(
    things: Sequence[Thing], group: str, points: NDArray[np.float64], bounced: float = 0.0
) -> float:
    """Return the radiance at which a group of lamps, all alone, lights points to a common level.

    Shadows are left out: this sets exposures, and need not be exact.

    Parameters
    ----------
    points : (P, 3), metres; the mean over them counts, of irradiance averaged over directions
    bounced : what surfaces add, of the lamps' power, m⁻²
    """
    lamps = joined([p.shape for thing in things for p in thing.parts if p.lamp == group])
    a, b, c = (lamps.vertices[lamps.faces[:, i]] for i in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    way = points[:, None] - (a + b + c) / 3.0
    square = (way**2).sum(axis=2)
    seen = np.maximum((way * area).sum(axis=2), 0.0) / np.maximum(square, _NEAREST**2) ** 1.5
    level = 0.25 * float(seen.sum(axis=1).mean()) + bounced * math.pi * lamps.area
    return _LEVEL / level


def lamp_materials(
    illumination: Illumination, radiances: Mapping[str, float]
) -> dict[str, Material]:
    """Return what the lamps of each group are made of; those of further groups stay dark.

    Parameters
    ----------
    radiances : luminance of each group at which it lights the scene alone, the main one first
    """
    shares = SHARES if len(illumination.colors) == 2 else (1.0,)
    return {
        group: Material(group, 0.0, light(color) * (share * radiance))
        for (group, radiance), color, share in zip(
            radiances.items(), illumination.colors, shares, strict=False
        )
    }
