"""How the index of refraction of glass depends on wavelength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from photonmap.runtime.wording import suggest
from photonmap.scene.parameters import Number, Numbers, Text
from photonmap.spectra.curves import Floats

LINES = (587.5618, 486.1327, 656.2725)  # Wavelengths of the lines d, F and C, nm
ENDS = (380.0, 780.0)


_COEFFICIENT = Number("coefficient", at_least=-1e6, at_most=1e6)
GLASSES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "bk7": ((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),
    "sf10": ((1.62153902, 0.256287842, 1.64447552), (0.0122241457, 0.0595736775, 147.468793)),
    "sf11": ((1.73759695, 0.313747346, 1.89878101), (0.013188707, 0.0623068142, 155.23629)),
    "fused quartz": ((0.6961663, 0.4079426, 0.8974794), (0.0684043**2, 0.1162414**2, 9.896161**2)),
    "water": (
        (0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688),
        (0.005101829712, 0.01821153936, 0.02620722293, 10.69792721),
    ),
    "diamond": ((0.3306, 4.3356), (0.175**2, 0.106**2)),
    "sapphire": ((1.4313493, 0.65054713, 5.3414021), (0.0726631**2, 0.1193242**2, 18.028251**2)),
}
"""Coefficients of Sellmeier's equation, B and C (µm²): Schott's catalogue; I. H. Malitson, 1965
(fused quartz) and 1962 (sapphire, ordinary ray); M. Daimon and A. Masumura, 2007 (water, 20 °C);
F. Peter, 1923 (diamond)."""


def sellmeier(wavelengths: Floats | float, b: tuple[float, ...], c: tuple[float, ...]) -> Floats:
    """Return n at wavelengths (nm), where n² = 1 + Σ bᵢ λ² / (λ² - cᵢ), λ in µm."""
    square = np.square(np.asarray(wavelengths, np.float64) * 1e-3)
    return np.sqrt(1.0 + sum(over * square / (square - pole) for over, pole in zip(b, c)))  # noqa: B905


class _Curve:
    """An index of refraction by its formula."""

    def index(self, wavelengths: Floats | float) -> Floats:
        """Return the index of refraction at wavelengths (nm)."""
        raise NotImplementedError

    def find_conflict(self) -> str:
        """Return what is wrong with the coefficients, if anything."""
        with np.errstate(invalid="ignore", divide="ignore"):
            values = self.index(np.linspace(*ENDS, 101))
        if np.isfinite(values).all() and values.min() > 0.0 and values.max() < 10.0:
            return ""
        return (
            f"the index goes from {values.min():.3g} to {values.max():.3g} within {ENDS[0]:g} to "
            f"{ENDS[1]:g} nm; give coefficients for wavelengths in µm"
        )


@dataclass(frozen=True)
class Cauchy(_Curve):
    """Cauchy's equation: n = a + b / λ² + c / λ⁴, with λ in µm.

    Parameters
    ----------
    a : index of refraction far in the infrared
    b, c : µm², µm⁴
    """

    a: Annotated[float, Number("index of refraction", above=0.0, such_as="1.5")]
    b: Annotated[float, _COEFFICIENT]
    c: Annotated[float, _COEFFICIENT] = 0.0
    kind: ClassVar[str] = "cauchy"

    def index(self, wavelengths: Floats | float) -> Floats:
        """Return the index of refraction at wavelengths (nm)."""
        square = np.square(np.asarray(wavelengths, np.float64) * 1e-3)
        return np.asarray(self.a + self.b / square + self.c / square**2)


@dataclass(frozen=True)
class Sellmeier(_Curve):
    """Sellmeier's equation: n² = 1 + Σ bᵢ λ² / (λ² - cᵢ), with λ in µm.

    Parameters
    ----------
    b : up to four coefficients
    c : as many, µm²
    """

    b: Annotated[tuple[float, ...], Numbers("coefficient", counts=(1, 2, 3, 4), each=_COEFFICIENT)]
    c: Annotated[tuple[float, ...], Numbers("coefficient", counts=(1, 2, 3, 4), each=_COEFFICIENT)]
    kind: ClassVar[str] = "sellmeier"

    def __post_init__(self) -> None:
        """Take lists as well."""
        for name in ("b", "c"):
            object.__setattr__(self, name, tuple(getattr(self, name)))

    def index(self, wavelengths: Floats | float) -> Floats:
        """Return the index of refraction at wavelengths (nm)."""
        return sellmeier(wavelengths, self.b, self.c)

    def find_conflict(self) -> str:
        """Return what is wrong with the coefficients, if anything."""
        if len(self.b) != len(self.c):
            return f"b has {len(self.b)} numbers and c has {len(self.c)}; give as many of both"
        return super().find_conflict()


@dataclass(frozen=True)
class NamedGlass:
    """A glass or liquid by its name, see `GLASSES`."""

    name: Annotated[str, Text()]
    kind: ClassVar[str] = "named"

    def index(self, wavelengths: Floats | float) -> Floats:
        """Return the index of refraction at wavelengths (nm)."""
        return sellmeier(wavelengths, *GLASSES[self.name.lower()])

    def find_conflict(self) -> str:
        """Return what is wrong with the name, if anything."""
        if self.name.lower() in GLASSES:
            return ""
        return f"there is no glass {self.name!r}; {suggest(self.name, tuple(GLASSES))}"


def abbe_index(wavelengths: Floats | float, index: float, abbe: float) -> Floats:
    """Return n at wavelengths (nm) of glass of an index at the line d, and of an Abbe number.

    By Cauchy's equation, n = a + b / λ², of which nF - nC = (nd - 1) / V.
    """
    inverse = [1.0 / (line * line) for line in LINES]
    slope = (index - 1.0) / abbe / (inverse[1] - inverse[2])
    squares = np.square(np.asarray(wavelengths, np.float64))
    return np.asarray(index + slope * (1.0 / squares - inverse[0]))


def abbe_number(index: Callable[[float], Floats]) -> float:
    """Return (nd - 1) / (nF - nC)."""
    d, f, c = (float(index(line)) for line in LINES)
    return (d - 1.0) / (f - c) if f != c else np.inf
