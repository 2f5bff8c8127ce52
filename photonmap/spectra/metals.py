"""What metals reflect, by their complex index of refraction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import suggest
from photonmap.spectra.curves import FILES, Floats, Spectrum
from photonmap.spectra.tables import read_table

SHIPPED = Path(__file__).parents[1] / "data" / "metals.csv"  # Made by `tools/make_metals.py`
LARGEST_INDEX = 1e3
"""More is no index of refraction but a wavelength or a percentage in the wrong column."""
_PARTS = "n or k of the index"
EDGE_COSINE = 1.0 / 7.0
"""Of the angle of 82° at which the reflectance of metals is given beside that at normal incidence:
where they reflect least, compared with Schlick's formula."""


@dataclass(frozen=True, eq=False, repr=False)
class Metal(Spectrum):
    """The reflectance of a metal in air, at normal incidence and at an angle of 82°.

    The `Spectrum` is that at normal incidence; `edge` is that at 82°, None for what Schlick's
    formula says.
    """

    edge: Spectrum | None = None

    def __mul__(self, factor: float) -> Metal:
        """Return the metal with all it reflects multiplied."""
        edge = None if self.edge is None else self.edge * factor
        return replace(self, values=self.values * float(factor), edge=edge)

    __rmul__ = __mul__


def metal(name: str) -> Metal:
    """Return a metal by its chemical symbol, as "Au"; the error suggests the nearest."""
    metals = _metals()
    if name not in metals:
        raise InputError(f"there is no metal {name!r}; {suggest(name, tuple(metals))}")
    return metals[name]


def metal_by_source(source: str, folder: Path) -> Metal:
    """Return a metal by its symbol or a table of its complex index.

    The columns of the table, a file relative to a folder, are wavelength (nm), n and k. What is
    neither is an `InputError`.
    """
    if Path(source).suffix.lower() not in FILES:
        with naming(f"metal:{source}"):
            return metal(source)
    path = named_file(folder, source)
    table = read_table(path, 0.0, LARGEST_INDEX, _PARTS)
    if len(table) != 2:
        raise InputError(
            f"has {len(table)} column(s) after the wavelength; a metal's index has two, n and k",
            path,
        )
    return _from_index(table.wavelengths, *table.values)


def conductor_reflectance(
    n: Floats | float, k: Floats | float, cosine: Floats | float = 1.0
) -> Floats:
    """Return what a surface of index n + ik reflects of unpolarised light in air (Fresnel)."""
    index = np.square(np.asarray(n) + 1j * np.asarray(k))
    inside = np.sqrt(index - (1.0 - cosine * cosine))
    across, along = cosine + inside, index * cosine + inside
    ratios = (cosine - inside) / _nonzero(across), (index * cosine - inside) / _nonzero(along)
    return np.asarray(sum(np.abs(ratio) ** 2 for ratio in ratios) / 2.0)


def _nonzero(values: Floats) -> Floats:
    return np.where(values == 0.0, 1e-30, values)


def _from_index(wavelengths: Floats, n: Floats, k: Floats, extrapolate: bool = False) -> Metal:
    edge = Spectrum(wavelengths, conductor_reflectance(n, k, EDGE_COSINE), extrapolate=True)
    return Metal(wavelengths, conductor_reflectance(n, k), extrapolate, edge)


@cache
def _metals() -> dict[str, Metal]:
    """Return the metals of the table that is shipped, by their symbols."""
    table = read_table(SHIPPED, 0.0, LARGEST_INDEX, _PARTS)
    rows = dict(zip(table.names, table.values, strict=True))
    symbols = dict.fromkeys(name.split()[0] for name in table.names)
    return {
        symbol: _from_index(table.wavelengths, rows[f"{symbol} n"], rows[f"{symbol} k"], True)
        for symbol in symbols
    }
