"""Lights drawn at random: how many, of which spectra, and with which shares."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from photonmap.errors import InputError
from photonmap.spectra.color_text import ILLUMINANTS, measured_illuminants
from photonmap.spectra.names import DAYLIGHT

MOST_LIGHTS = 4
"""The number of light groups that every procedural scene has at least."""
LEAST_SHARE = 0.1
"""Least share of a light among several."""
SKY_ALONE = 0.5
"""Probability that an only light is a sky."""

_BLACK_BODY = (1800.0, 8000.0)
"""Range of temperature, K; reciprocal temperatures are drawn evenly, as the eye sees them."""
_LEDS = tuple(f"LED-{name}" for name in ("B1", "B2", "B3", "B4", "B5", "BH1", "RGB1", "V1", "V2"))
_FLUORESCENT = (*(f"FL{i}" for i in range(1, 13)), *(f"FL3.{i}" for i in range(1, 16)))
_DISCHARGE = ("HP1", "HP2", "HP3", "HP4", "HP5")
# fmt: off
_MEASURED = (
    "3-LED-1 (457/540/605)", "3-LED-4 (455/547/623)", "4-LED-1 (461/526/576/624)",
    "60 A/W (Soft White)", "C100S54 (HPS)", "F32T8/TL830 (Triphosphor)",
    "F32T8/TL850 (Triphosphor)", "F34/CW/RS/EW (Cool White FL)", "F40/C75 (Broadband FL)",
    "H38HT-100 (Mercury)", "H38JA-100/DX (Mercury DX)", "Luxeon WW 2880", "MHC100/U/MP/3K",
    "MHC100/U/MP/4K", "Metal Halide", "Neodimium Incandescent", "PHOS-1", "Phosphor LED YAG",
    "SDW-T 100W/LV (Super HPS)", "Thorn Kolor-rite",
)
"""Measured lamps that colour-science has, one of each sort."""
# fmt: on


@dataclass(frozen=True)
class RandomLights:
    """An illumination whose lights are drawn for each scene and seed.

    The number of lights is uniform. An only light is a sky or a lamp; of several, one is a sky. A
    sky is a phase of daylight. A lamp is, equally often, a black body, a CIE LED, a CIE fluorescent
    lamp, a CIE high-pressure discharge lamp, or a measured lamp. The shares of several lights are
    uniform over all that are at least `LEAST_SHARE` and add up to 1.

    Parameters
    ----------
    name : of the illumination
    least, most : number of lights, from 1 to `MOST_LIGHTS`

    Raises
    ------
    InputError : there are no such numbers
    """

    name: str
    least: int = 1
    most: int = MOST_LIGHTS

    def __post_init__(self) -> None:
        """Check the numbers of lights."""
        if not 1 <= self.least <= self.most <= MOST_LIGHTS:
            raise InputError(
                f"illumination {self.name!r} of {self.least} to {self.most} lights; give two "
                f"numbers from 1 to {MOST_LIGHTS}, the lower one first"
            )

    def draw(
        self, rng: np.random.Generator, is_known: Callable[[str], bool] = lambda _: True
    ) -> tuple[tuple[str, ...], tuple[float, ...]]:
        """Draw the lights, each by its name and different from the others, and their shares.

        Lamps of which `is_known` says no are drawn again; of black bodies it must not.
        """
        count = int(rng.integers(self.least, self.most + 1))
        has_sky = count > 1 or bool(rng.random() < SKY_ALONE)
        lights = [draw_sky(rng)] if has_sky else []
        while len(lights) < count:
            lamp = draw_lamp(rng)
            if lamp not in lights and is_known(lamp):
                lights.append(lamp)
        return tuple(lights), draw_shares(rng, count)


RANDOM = {
    "random": RandomLights("random"),
    **{f"random_{n}": RandomLights(f"random_{n}", n, n) for n in range(1, MOST_LIGHTS + 1)},
}
"""Illuminations by name whose lights are drawn: of any number, or of a given one."""


def draw_sky(rng: np.random.Generator) -> str:
    """Draw a phase of daylight, as text."""
    return f"daylight:{_temperature(rng, DAYLIGHT)}"


def draw_lamp(rng: np.random.Generator) -> str:
    """Draw a lamp, as text; among the measured ones are those of the user's set, if any."""
    families = (_LEDS, _FLUORESCENT, _DISCHARGE, _measured())
    family = int(rng.integers(len(families) + 1))
    if family == len(families):
        return f"planck:{_temperature(rng, _BLACK_BODY)}"
    return families[family][int(rng.integers(len(families[family])))]


def draw_shares(rng: np.random.Generator, count: int) -> tuple[float, ...]:
    """Draw shares, uniform over all that are at least `LEAST_SHARE` and add up to 1."""
    drawn = LEAST_SHARE + (1.0 - count * LEAST_SHARE) * rng.dirichlet(np.ones(count))
    rounded = np.round(drawn[:-1], 3).tolist()
    return (*rounded, round(1.0 - sum(rounded), 3))


def _measured() -> tuple[str, ...]:
    if not os.environ.get(ILLUMINANTS):
        return _MEASURED
    return (*_MEASURED, *(f"sfu:{name}" for name in measured_illuminants().names))


def _temperature(rng: np.random.Generator, limits: tuple[float, float]) -> int:
    """Draw a temperature whose reciprocal is uniform, in steps of 50 K."""
    low, high = 1.0 / limits[0], 1.0 / limits[1]
    return 50 * round(1.0 / rng.uniform(high, low) / 50.0)
