"""What metals reflect at normal incidence."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

from photonmap.spectra.curves import Spectrum, SpectrumSet
from photonmap.spectra.tables import read_table

SHIPPED = Path(__file__).parents[1] / "data" / "metals.csv"
"""Made by `tools/make_metals.py`."""


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


@cache
def _metals() -> SpectrumSet:
    return read_table(SHIPPED, 0.0, 1.0, "reflectance")
