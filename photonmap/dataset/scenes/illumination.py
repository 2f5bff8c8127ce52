"""Illuminations: one or two spectra of light, and the emitter materials they give a scene."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import joined
from photonmap.dataset.models.wall_fixtures import WINDOW
from photonmap.errors import InputError
from photonmap.runtime.wording import suggest
from photonmap.scene.material import Material
from photonmap.spectra.color_text import emission
from photonmap.spectra.curves import Spectrum

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
"""White; one coloured light; a cool and a warm black body; two lights that are not black bodies."""

_NEAREST = 0.15
"""Least distance to an emitter in the estimate of exposure, metres."""
_LEVEL = 1.0
"""Irradiance averaged over orientations, W·m⁻², to which emitters are set."""

_SKY = re.compile(r"D\d+|planck:(\d+(?:\.\d+)?)")
_COOLEST = 4500.0
"""Lowest temperature of a black body that may be a sky, kelvins."""

SHARES = (0.6, 0.4)
"""Fractions of the light that come from the first and the second of two lights."""


@dataclass(frozen=True)
class Illumination:
    """The spectra of a scene's lights.

    Parameters
    ----------
    name : one of `ILLUMINATIONS`, or any other
    colors : one or two lights, as text that `photonmap.spectra.color_text` reads
    """

    name: str
    colors: tuple[str, ...]

    def __post_init__(self) -> None:
        """Reject anything but one or two colours."""
        if len(self.colors) not in (1, 2):
            count = len(self.colors)
            raise InputError(f"illumination {self.name!r} has {count} colours; give one or two")


def choose_illumination(illumination: str | Illumination, rng: np.random.Generator) -> Illumination:
    """Draw the colours of a named illumination; return an `Illumination` unchanged.

    Raises
    ------
    InputError : there is no illumination of that name
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
def light_spectrum(name: str) -> Spectrum:
    """Return the spectrum of a light by its name, scaled to a luminance of 1.

    Raises
    ------
    InputError : the name is not that of a spectrum of light
    """
    from photonmap.spectra.observer import normalise_luminance

    color = emission(name)
    if isinstance(color, Spectrum):
        return normalise_luminance(color)
    raise InputError(
        f"{name!r} is not a spectrum of light; give a name, planck:K, or the file of a spectrum"
    )


def radiance_for_exposure(
    objects: Sequence[SceneObject], group: str, points: NDArray[np.float64], indirect: float = 0.0
) -> float:
    """Return the radiance at which one light group alone lights points to a common exposure.

    An estimate without shadows, as it only sets the exposure.

    Parameters
    ----------
    objects : of the scene
    group : name of the light group
    points : (P, 3), metres; the median of their irradiances, averaged over orientations, counts
    indirect : irradiance that interreflection adds, as a fraction of the emitted power, m⁻²
    """
    emitters = joined([p.shape for obj in objects for p in obj.parts if p.light_group == group])
    a, b, c = (emitters.vertices[emitters.faces[:, i]] for i in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    to_points = points[:, None] - (a + b + c) / 3.0
    square = (to_points**2).sum(axis=2)
    received = (
        np.maximum((to_points * area).sum(axis=2), 0.0) / np.maximum(square, _NEAREST**2) ** 1.5
    )
    level = 0.25 * float(np.median(received.sum(axis=1))) + indirect * math.pi * emitters.area
    return _LEVEL / level


def emitter_materials(
    illumination: Illumination, radiances: Mapping[str, float]
) -> dict[str, Material]:
    """Return the emitting material of each light group that has a colour; other groups stay off.

    Windows show daylight: they take the colour of a sky if there is one, and a single colour that
    is none is left to the lamps.

    Parameters
    ----------
    radiances : luminance at which each group alone lights the scene to the common exposure, the
        main group first
    """
    groups, colors = list(radiances), list(illumination.colors)
    if WINDOW in groups and len(colors) == 1 and not is_sky(colors[0]):
        groups.sort(key=lambda group: group == WINDOW)
    elif WINDOW in groups and len(colors) == 2:
        colors.sort(key=is_sky, reverse=groups[0] == WINDOW)
    shares = SHARES if len(colors) == 2 else (1.0,)
    return {
        group: Material(group, 0.0, light_spectrum(color) * (share * radiances[group]))
        for group, color, share in zip(groups, colors, shares, strict=False)
    }


def is_sky(color: str) -> bool:
    """Return whether a light, by its name, may be that of a sky: daylight, or a cool black body."""
    found = _SKY.fullmatch(color)
    return found is not None and (found[1] is None or float(found[1]) >= _COOLEST)
