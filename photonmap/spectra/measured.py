"""Read measured spectra: Munsell chips (Joensuu) and illuminants (Simon Fraser University)."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming, naming_file
from photonmap.runtime.bounds import read_npz
from photonmap.runtime.wording import listed, shown
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Floats, SpectrumSet, check_reflectance
from photonmap.spectra.tables import read_arrays, read_numbers, read_table

_MUNSELL_GRIDS = ((380, 800, 1), (400, 700, 5), (400, 700, 10), (380, 780, 1))
_GRID_NAME = re.compile(r"(\d{3,4})_(\d{3,4})_([1-9]\d?)(?!\d)")
_MUNSELL_LABEL = re.compile(
    r"([\d.]+)\s*(R|YR|Y|GY|G|BG|B|PB|P|RP)\s*([\d.]+)\s*/\s*([\d.]+)", re.ASCII
)
_ILLUMINANT_GRID = np.linspace(380.0, 780.0, 101)
_ILLUMINANT_SUFFIXES = (".illum", ".illums", ".txt", ".dat")
_NOISE = 1e-6

Samples = tuple[Floats, Floats, Any]  # Wavelengths (K,), values (C, K) and C labels


def read_munsell(path: str | PathLike[str]) -> SpectrumSet:
    """Read the reflectances of Munsell chips, within [0, 1].

    Names such as "2.5R9/2" become "2.5R 9/2", others stay as they are; chips without names are
    called "1", "2" and so on. The path is a `.mat` or `.asc` of the University of Joensuu, whose
    name gives the wavelengths as in munsell380_800_1.mat; `.npz` with `R` (C, K), `wavelength`
    (K,), nm, and `label` (C,); any other suffix is a table; or a folder with one munsell*.mat, .asc
    or .npz. Arrays that do not match are an `InputError`.
    """
    path = Path(path)
    if path.is_dir():
        path = _find_munsell(path)
    if path.suffix.lower() not in _MUNSELL_READERS:
        table = read_table(path, 0.0, LARGEST_REFLECTANCE, "reflectance")
        return replace(table, names=tuple(map(_tidy, table.names)))
    wavelengths, values, labels = _MUNSELL_READERS[path.suffix.lower()](path)
    names = [_tidy(str(np.squeeze(label))) for label in np.ravel(labels)]
    if len(names) != len(values):
        raise InputError(f"has {len(names)} labels for {len(values)} chips; correct the file", path)
    for name, row in zip(names, values, strict=True):
        with naming(shown(name), path):
            check_reflectance(wavelengths, row)
    with naming_file(path):
        return SpectrumSet(wavelengths, values, tuple(names))


def read_illuminants(path: str | PathLike[str]) -> SpectrumSet:
    """Read illuminant spectra as Simon Fraser University gives them: 380 to 780 nm by 4 nm.

    Values below zero by up to a millionth of the spectrum's largest are noise of the sensor and
    become 0. The comments before the spectra name them if each has exactly one, else they are
    called "1", "2" and so on. The path is a text file (101 numbers per spectrum, on one line or one
    per line); `.npz` with `wavelength` (K,), nm, and arrays (n, K), whose spectra are called
    "array/1" and so on; a `.csv` table; or a folder of text files, whose spectra are called
    "stem/name". Numbers that do not match, are negative or not finite are an `InputError`.
    """
    path = Path(path)
    if path.is_dir():
        return _read_folder(path)
    lines = None
    if path.suffix.lower() == ".csv":
        table = read_table(path, kind="light")
        wavelengths, values, names = table.wavelengths, table.values, list(table.names)
    elif path.suffix.lower() == ".npz":
        wavelengths, values, names = _read_groups(path)
    else:
        wavelengths = _ILLUMINANT_GRID
        values, names, lines = _read_text(path)
    noise = _NOISE * values.max(axis=1, keepdims=True, initial=0.0)
    bad = np.argwhere(~np.isfinite(values) | (values < -noise))
    if bad.size:
        row, column = bad[0]
        message = f"light is {values[row, column]:.6g} at {wavelengths[column]:g} nm"
        remedy = "give finite values of 0 or more"
        line = None if lines is None else int(lines[row, column])
        raise InputError(f"{shown(names[row])}: {message}; {remedy}", path, line)
    with naming_file(path):
        return SpectrumSet(wavelengths, np.maximum(values, 0.0), tuple(names))


def _find_munsell(folder: Path) -> Path:
    """Find the one file of Munsell chips in a folder."""
    found = [
        path
        for path in sorted(folder.glob("[mM]unsell*"))
        if path.suffix.lower() in _MUNSELL_READERS
    ]
    if len(found) != 1:
        held = listed(path.name for path in found) or "no munsell*.mat, .asc or .npz"
        raise InputError(f"holds {held}; name one file", folder)
    return found[0]


def _tidy(label: str) -> str:
    """Write a Munsell notation as "2.5R 9/2"."""
    match = _MUNSELL_LABEL.fullmatch(label.strip())
    return "{}{} {}/{}".format(*match.groups()) if match else label.strip()


def _read_munsell_npz(path: Path) -> Samples:
    """Read the arrays `R`, `wavelength` and `label`."""
    data = read_arrays(path, lambda data: read_npz(path))
    wavelengths, values = _pick(path, data, 1, "wavelength"), _pick(path, data, 2, "R")
    _check_width(path, "R", values, wavelengths)
    return wavelengths, values, data.get("label", _count(values))


def _read_munsell_mat(path: Path) -> Samples:
    """Read `munsell`, or `X` in the glossy set, and the labels `S`."""
    from scipy.io import loadmat

    data = read_arrays(path, loadmat)
    wavelengths, values = _arrange(path, _pick(path, data, 2, "munsell", "X"))
    return wavelengths, values, data.get("S", _count(values))


def _read_munsell_asc(path: Path) -> Samples:
    """Read numbers in rows of one chip, in columns of one chip, or one chip after another."""
    numbers, lines, _ = read_numbers(path)
    _, widths = np.unique(lines, return_counts=True)
    if widths[0] > 1 and (widths == widths[0]).all():
        numbers = numbers.reshape(-1, widths[0])
    wavelengths, values = _arrange(path, numbers)
    return wavelengths, values, _count(values)


_MUNSELL_READERS: dict[str, Callable[[Path], Samples]] = {
    ".mat": _read_munsell_mat,
    ".asc": _read_munsell_asc,
    ".npz": _read_munsell_npz,
}


def _arrange(path: Path, numbers: Floats) -> tuple[Floats, Floats]:
    """Find the wavelengths (K,) by the file's name, or by the array's shape, and give (C, K).

    Where the shape is ambiguous, the smoother direction is that of the spectra.
    """
    match = _GRID_NAME.search(path.stem)
    known = [tuple(map(int, match.groups()))] if match else _MUNSELL_GRIDS
    grids = [np.arange(low, high + 1.0, step) for low, high, step in known if low + step <= high]
    shape = numbers.shape
    fits = [grid for grid in grids if len(grid) in shape]
    if not fits and path.suffix.lower() == ".asc":
        numbers = numbers.ravel()
        fits = [grid for grid in grids if numbers.size % len(grid) == 0]
    if len(fits) != 1:
        problem = (
            f"do not fit {match[0]} in its name" if match else "do not determine their wavelengths"
        )
        remedy = f"name it by first, last and step in nm, as in munsell380_800_1{path.suffix}"
        raise InputError(f"its {_size(shape)} numbers {problem}; {remedy}", path)
    count = len(fits[0])
    layouts = []
    if numbers.ndim == 1 or numbers.shape[1] == count:
        layouts.append(numbers.reshape(-1, count))
    if numbers.ndim == 1 or numbers.shape[0] == count:
        layouts.append(numbers.reshape(count, -1).T)
    with np.errstate(invalid="ignore"):
        values = min(layouts, key=lambda layout: float(np.abs(np.diff(layout)).sum()))
    in_percent = 2.0 < values.max() <= 110.0  # as munsell400_700_10.mat of the glossy chips is
    return fits[0], values / 100.0 if in_percent else values


def _read_text(path: Path) -> tuple[Floats, list[str], NDArray[np.int64]]:
    """Read spectra one after another: values (C, 101), names, and the line of each value."""
    numbers, lines, comments = read_numbers(path)
    count = len(_ILLUMINANT_GRID)
    layout = f"a spectrum has {count}, on one line or one per line; name a table .csv"
    if numbers.size % count:
        raise InputError(f"holds {numbers.size} numbers; {layout}", path)
    found, widths = np.unique(lines, return_counts=True)
    wrong = np.flatnonzero((widths != 1) & (widths != count))
    if wrong.size:
        message = f"has {widths[wrong[0]]} numbers; {layout}"
        raise InputError(message, path, int(found[wrong[0]]))
    values = numbers.reshape(-1, count)
    # "#! t=i n=101 o=380.0 s=4.0" in the originals describes the layout.
    named = [
        (at, text.lstrip("# ")) for at, text in comments if text.strip("# ") and text[:2] != "#!"
    ]
    if [at for at, _ in named] == list(range(0, numbers.size, count)):
        return values, [name for _, name in named], lines.reshape(-1, count)
    return values, _count(values), lines.reshape(-1, count)


def _read_groups(path: Path) -> tuple[Floats, Floats, list[str]]:
    """Read all arrays (n, K) of an .npz beside `wavelength` (K,)."""
    data = read_arrays(path, lambda data: read_npz(path))
    wavelengths = _pick(path, data, 1, "wavelength")
    groups = {
        name: array.astype(np.float64)
        for name, array in data.items()
        if array.ndim == 2 and array.dtype.kind == "f"
    }
    if not groups:
        raise InputError(f"holds no spectra, only {listed(data)}; save arrays (n, K)", path)
    for name, array in groups.items():
        _check_width(path, name, array, wavelengths)
    names = [f"{name}/{label}" for name, array in groups.items() for label in _count(array)]
    return wavelengths, np.concatenate(list(groups.values())), names


def _read_folder(folder: Path) -> SpectrumSet:
    """Read all text files of a folder."""
    paths = [
        path for path in sorted(folder.iterdir()) if path.suffix.lower() in _ILLUMINANT_SUFFIXES
    ]
    if not paths:
        raise InputError(
            f"holds no file with {', '.join(_ILLUMINANT_SUFFIXES)}; name another", folder
        )
    sets = [read_illuminants(path) for path in paths]
    names = [
        f"{path.stem}/{name}"
        for path, curves in zip(paths, sets, strict=True)
        for name in curves.names
    ]
    values = np.concatenate([curves.values for curves in sets])
    return SpectrumSet(_ILLUMINANT_GRID, values, tuple(names))


def _pick(path: Path, data: dict[str, Any], dimensions: int, *names: str) -> Floats:
    """Take the first of these arrays that is there."""
    name = next((name for name in names if name in data), None)
    if name is None:
        held = listed(key for key in data if not key.startswith("__"))
        raise InputError(f"holds no array {listed(names)}, only {held}; rename it", path)
    array = data[name]
    if array.dtype.kind not in "iuf" or array.ndim != dimensions:
        message = f"{shown(name)} is not a {dimensions}-dimensional array of numbers"
        raise InputError(f"{message}; save it as one", path)
    return np.asarray(array, np.float64)


def _check_width(path: Path, name: str, array: Floats, wavelengths: Floats) -> None:
    """Raise `InputError` unless an array has a column for each wavelength."""
    if array.shape[1] != len(wavelengths):
        message = f"{shown(name)} is {_size(array.shape)}, not one row of {len(wavelengths)} values"
        raise InputError(f"{message} for each spectrum; correct it, or the wavelengths", path)


def _size(shape: tuple[int, ...]) -> str:
    """Write the size of an array as "1269 x 421"."""
    return " x ".join(map(str, shape))


def _count(values: Floats) -> list[str]:
    """Return the names of rows: "1", "2" and so on."""
    return [str(number + 1) for number in range(len(values))]
