"""What metals reflect at normal incidence."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.runtime.named_files import named_file
from photonmap.spectra.curves import FILES, Floats, Spectrum, SpectrumSet
from photonmap.spectra.tables import read_table

SHIPPED = Path(__file__).parents[1] / "data" / "metals.csv"
"""Made by `tools/make_metals.py`."""
LARGEST_INDEX = 1e3
"""More is no index of refraction but a wavelength or a percentage in the wrong column."""


def metal(name: str) -> Spectrum:
    """Return the reflectance of a metal in air.

    Parameters
    ----------
    name : its chemical symbol, as "Au"

    Raises
    ------
    InputError : there is none of this name; the error suggests the nearest
    """
    return replace(_metals()[name], extrapolate=True)


def metal_by_source(source: str, folder: Path) -> Spectrum:
    """Return the reflectance of a metal in air, by its symbol or a table of its complex index.

    Parameters
    ----------
    source : "Au", or the name of a file whose columns are wavelength (nm), n and k
    folder : that file names are relative to

    Raises
    ------
    InputError : no metal has this symbol, or the file is not such a table
    """
    if Path(source).suffix.lower() not in FILES:
        with naming(f"metal:{source}"):
            return metal(source)
    path = named_file(folder, source)
    table = read_table(path, 0.0, LARGEST_INDEX, "index")
    if len(table) != 2:
        raise InputError(
            f"has {len(table)} column(s) after the wavelength; a metal's index has two, n and k",
            path,
        )
    n, k = table.values
    return Spectrum(table.wavelengths, normal_reflectance(n, k))


def normal_reflectance(n: Floats, k: Floats) -> Floats:
    """Return what a surface of index n + ik reflects at normal incidence in air (Fresnel)."""
    return np.asarray(((n - 1.0) ** 2 + k**2) / np.maximum((n + 1.0) ** 2 + k**2, 1e-30))


@cache
def _metals() -> SpectrumSet:
    return read_table(SHIPPED, 0.0, 1.0, "reflectance")
