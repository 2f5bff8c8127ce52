"""Fluorophores by name, and as tables with files or numbers, for TOML files and glTF's extras.

    "fluorescein 0.3"                 a name, and what multiplies its excitation
    "matrix.npz"                      a Donaldson matrix
    { excitation = "in.csv", emission = "out.csv", quantum_efficiency = 0.9 }
    { matrix = "matrix.csv", anti_stokes = true }

A curve is a FILE.csv, or two rows: wavelengths (nm) and values; a matrix that is no file is a table
of `excitation` (nm), `emission` (nm) and `values` (nm⁻¹).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import shown, suggest
from photonmap.spectra.curves import FILES, Floats, Spectrum
from photonmap.spectra.fluorescence import (
    DonaldsonMatrix,
    Fluorescence,
    Fluorophore,
    Fluorophores,
    as_fluorophores,
)
from photonmap.spectra.tables import read_table

NAMED: dict[str, tuple[float, float, float]] = {
    "optical brightener": (360.0, 437.0, 0.80),
    "quinine sulfate": (347.0, 451.0, 0.546),
    "coumarin 6": (459.0, 500.0, 0.78),
    "fluorescein": (491.0, 514.0, 0.925),
    "eosin y": (525.0, 543.0, 0.67),
    "rhodamine 6g": (530.0, 552.0, 0.95),
    "rhodamine b": (543.0, 565.0, 0.70),
    "sulforhodamine 101": (576.0, 591.0, 0.90),
    "lumogen red 305": (578.0, 613.0, 0.98),
}
"""Peaks of excitation and emission, nm, and quantum efficiency.

Curves are synthetic: half Gaussians over wavenumber, mirror images of one another. Compared with
sources were the excitation and yields of coumarin 6, eosin y, the rhodamines and sulforhodamine in
ethanol, and eosin's emission (database of PhotochemCAD, H. Du et al., Photochemistry and
Photobiology 68(2), 1998, edition of 2017); fluorescein's emission in alkaline water (M. Martin and
L. Lindqvist, Journal of Luminescence 10(6), 1975; PhotochemCAD has 500 nm and 0.97 in alkaline
ethanol); and Lumogen's excitation (data of pvtrace). The others are near published peaks, but were
not compared with them; those of the brightener are usual ones."""
_NARROW, _WIDE = 450.0, 1300.0
"""σ of the halves that face the other curve, and of those that do not, cm⁻¹."""
_KEYS = ("excitation", "emission", "quantum_efficiency", "anti_stokes", "matrix")
_GRID: Floats = np.arange(280.0, 851.0)


def named(name: str) -> Fluorescence:
    """Return a fluorophore by its name in `NAMED`; the error suggests the nearest."""
    if name.lower() not in NAMED:
        raise InputError(f"there is no fluorophore {shown(name)}; {suggest(name.lower(), NAMED)}")
    taken, sent, efficiency = NAMED[name.lower()]
    wavenumber = 1e7 / _GRID

    def half_gaussians(peak: float, above: float, below: float) -> Spectrum:
        off = wavenumber - 1e7 / peak
        curve = np.exp(-0.5 * (off / np.where(off > 0.0, above, below)) ** 2)
        return Spectrum(_GRID, np.where(curve > 1e-4, curve, 0.0))

    excitation = half_gaussians(taken, _WIDE, _NARROW)
    return Fluorescence(excitation, half_gaussians(sent, _NARROW, _WIDE), efficiency)


def read_fluorophores(value: Any, folder: Path) -> Fluorophores:
    """Return what a text, a table or a list of these stands for.

    Parameters
    ----------
    value : as this module describes it
    folder : that file names are relative to

    Raises
    ------
    InputError : it is none of these, or no fluorophore can be so
    """
    if not isinstance(value, list):
        return _read(value, folder)
    several = tuple(_read(each, folder) for each in value)
    return several if len(several) > 1 else next(iter(several), None)


def describe_fluorophores(fluorescence: Fluorophores) -> list[dict[str, Any]]:
    """Return tables of numbers from which `read_fluorophores` makes the same again."""
    return [_describe(each) for each in as_fluorophores(fluorescence)]


def _describe(each: Fluorophore) -> dict[str, Any]:
    held = {"anti_stokes": True} if each.anti_stokes else {}
    if isinstance(each, DonaldsonMatrix):
        names = ("excitation", "emission", "values")
        return {"matrix": {name: getattr(each, name).tolist() for name in names}, **held}
    curves = {
        name: [curve.wavelengths.tolist(), curve.values.tolist()]
        for name, curve in (("excitation", each.excitation), ("emission", each.emission))
    }
    return {**curves, "quantum_efficiency": each.quantum_efficiency, **held}


def _read(value: Any, folder: Path) -> Fluorophore:
    if isinstance(value, str):
        return _read_text(value.strip(), folder)
    if not isinstance(value, dict):
        raise InputError(
            f"{shown(value)} is no fluorophore; give a name, a file or a table, or a list of these"
        )
    for key in value:
        if key not in _KEYS:
            raise InputError(f"key {shown(key)} is not known; {suggest(key, _KEYS)}")
    free = value.get("anti_stokes", False)
    if not isinstance(free, bool):
        raise InputError(f"anti_stokes {shown(free)}; write true or false")
    if "matrix" in value:
        if wrong := value.keys() - {"matrix", "anti_stokes"}:
            raise InputError(f"a matrix has no {min(wrong)}; leave one of them out")
        return _read_matrix(value["matrix"], folder, free)
    curves = [_read_curve(value.get(key), key, folder) for key in ("excitation", "emission")]
    return Fluorescence(curves[0], curves[1], value.get("quantum_efficiency", 1.0), free)


def _read_text(text: str, folder: Path) -> Fluorophore:
    if Path(text).suffix.lower() in (".npz", *FILES):
        return DonaldsonMatrix.read(named_file(folder, text))
    name, factor = _split(text)
    if text.lower() in NAMED:
        name, factor = text, 1.0
    dye = named(name)
    with naming(shown(text)):
        return replace(dye, excitation=dye.excitation * factor)


def _split(text: str) -> tuple[str, float]:
    """Return a text without the number at its end, and that number; 1 without one."""
    head, _, last = text.rpartition(" ")
    try:
        return (head.strip(), float(last)) if head else (text, 1.0)
    except ValueError:
        return text, 1.0


def _read_matrix(value: Any, folder: Path, anti_stokes: bool) -> DonaldsonMatrix:
    if isinstance(value, str):
        return DonaldsonMatrix.read(named_file(folder, value), anti_stokes)
    try:
        excitation, emission, values = (value[k] for k in ("excitation", "emission", "values"))
    except (KeyError, TypeError):
        raise InputError(
            f"matrix {shown(value)} is no matrix; give a file, or a table of excitation, emission "
            "and values"
        ) from None
    return DonaldsonMatrix(excitation, emission, values, anti_stokes)


def _read_curve(value: Any, key: str, folder: Path) -> Spectrum:
    """Read a curve: a file and perhaps a factor, or two rows of numbers."""
    if isinstance(value, str):
        name, factor = _split(value.strip())
        path = named_file(folder, name)
        table = read_table(path, 0.0, kind=key)
        if len(table) > 1:
            raise InputError(
                f"has {len(table)} curves; keep one wavelength and one value per row", path
            )
        return table[0] * factor
    if not isinstance(value, list) or len(value) != 2:
        problem = "is missing" if value is None else f"{shown(value)} is no curve"
        raise InputError(f'{key} {problem}; write {key} = "FILE.csv", or two rows of numbers')
    return Spectrum(*value)
