"""Read images of spectra: NumPy archives, ENVI images, and images of indices.

`FILE.npz` holds `wavelengths` (L,), nm, and one array (H, W, L) of any name. `FILE.hdr` is the
header of an ENVI image beside its values, with the field `wavelength`, as L3Harris defines it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, shown

SUFFIXES = (".npz", ".hdr")

_TYPES = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8"}
"""NumPy's types by ENVI's numbers of data types."""
_LAYOUTS = {
    "bsq": ("bands", "lines", "samples"),
    "bil": ("lines", "bands", "samples"),
    "bip": ("lines", "samples", "bands"),
}
"""The axes of a file by its interleave, outermost first."""
_UNITS = {"nanometers": 1.0, "nm": 1.0, "micrometers": 1e3, "um": 1e3, "angstroms": 0.1}
_FIELD = re.compile(r"^[ \t]*([^=\n{}]+?)[ \t]*=[ \t]*(\{[^}]*\}|[^\n]*)", re.MULTILINE)
_DATA_SUFFIXES = (".img", ".dat", ".raw", ".bsq", ".bil", ".bip")
_SCALE = "reflectance scale factor"


class SpectralImage(NamedTuple):
    """Spectra in rows and columns.

    Parameters
    ----------
    wavelengths : (L,) float64, nm
    values : (H, W, L), top row first
    """

    wavelengths: NDArray[np.float64]
    values: NDArray[Any]


def is_spectral(path: Path) -> bool:
    """Return whether a file holds spectra by its name; FILE.hdr may be a Radiance image as well."""
    if path.suffix.lower() != ".hdr" or not path.is_file():
        return path.suffix.lower() in SUFFIXES
    with path.open("rb") as file:
        return file.read(4) == b"ENVI"


def read_spectral_image(path: Path) -> SpectralImage:
    """Read FILE.npz or FILE.hdr.

    Raises
    ------
    InputError : the file is missing, damaged, or of another kind
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"spectral images end in {listed(SUFFIXES)}, not {shown(path.suffix)}")
    if not path.is_file():
        raise InputError("there is no such file; check its name", path)
    try:
        image = _read_npz(path) if path.suffix.lower() == ".npz" else _read_envi(path)
    except (OSError, ValueError, KeyError, BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot be read ({error}); write it again", path) from None
    wrong = np.flatnonzero(np.diff(image.wavelengths) <= 0.0)
    if len(wrong) == len(image.wavelengths) - 1:  # falling, as some spectrometers write
        return SpectralImage(image.wavelengths[::-1], image.values[..., ::-1])
    return image


def read_indices(path: Path) -> NDArray[np.int32]:
    """Read an image of indices, (H, W): whole numbers as they are in the file.

    Raises
    ------
    InputError : it cannot be read, holds floats, or is coloured
    """
    import OpenImageIO

    file = OpenImageIO.ImageInput.open(str(path)) if path.is_file() else None
    if file is None:
        raise InputError("is no image that can be read; check its name", path)
    spec = file.spec()
    kind = str(spec.format)
    if kind not in ("uint8", "uint16", "uint32"):
        raise InputError(f"holds {kind}; indices are whole numbers, as in a grey PNG", path)
    pixels = file.read_image(0, 0, 0, spec.nchannels, kind)
    file.close()
    if pixels is None:
        raise InputError(f"is damaged ({OpenImageIO.geterror() or 'unknown reason'})", path)
    names = [name.lower() for name in spec.channelnames]
    colors = pixels[..., [i for i, name in enumerate(names) if name not in ("a", "alpha")]]
    if (colors != colors[..., :1]).any():
        raise InputError("is coloured; an image of indices is grey", path)
    return np.ascontiguousarray(colors[..., 0], np.int32)


def _read_npz(path: Path) -> SpectralImage:
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
        cubes = [array for array in arrays.values() if array.ndim == 3]
        if "wavelengths" not in arrays or len(cubes) != 1:
            raise InputError(
                f"holds {listed(arrays) or 'nothing'}; it needs 'wavelengths' (L,) in nm "
                "and one array (H, W, L)",
                path,
            )
        return SpectralImage(arrays["wavelengths"].astype(np.float64), cubes[0])


def _read_envi(path: Path) -> SpectralImage:
    text = path.read_text(encoding="utf-8", errors="replace")
    if not text.startswith("ENVI"):
        raise InputError("is no ENVI header, which begins with ENVI", path)
    fields = {key.lower(): value.strip("{} \t\r\n") for key, value in _FIELD.findall(text)}
    missing = [
        key for key in ("samples", "lines", "bands", "data type", "wavelength") if key not in fields
    ]
    if missing:
        raise InputError(f"the header lacks {listed(missing)}; add it", path)
    unit = fields.get("wavelength units", "Nanometers").lower()
    if unit not in _UNITS:
        raise InputError(f"wavelength units {shown(unit)}; write Nanometers", path)
    wavelengths = np.array([float(each) for each in fields["wavelength"].split(",")]) * _UNITS[unit]
    values = _read_values(path, fields)
    if _SCALE in fields:
        values = values.astype(np.float32) / np.float32(fields[_SCALE])
    return SpectralImage(wavelengths, values)


def _read_values(path: Path, fields: dict[str, str]) -> NDArray[Any]:
    """Return the values beside a header, (H, W, L)."""
    kind, interleave = int(fields["data type"]), fields.get("interleave", "bsq").lower()
    if kind not in _TYPES or interleave not in _LAYOUTS:
        raise InputError(
            f"data type {kind} with interleave {interleave} is not known; "
            f"write types {listed(map(str, _TYPES), 9)} as bsq, bil or bip",
            path,
        )
    axes = _LAYOUTS[interleave]
    shape = [int(fields[axis]) for axis in axes]
    order = "<" if fields.get("byte order", "0") == "0" else ">"
    data = next((file for file in _data_files(path) if file.is_file()), None)
    if data is None:
        raise InputError(f"there is no {path.stem}.img beside the header", path)
    count = int(np.prod(shape))
    start = int(fields.get("header offset", 0))
    values = np.fromfile(data, f"{order}{_TYPES[kind]}", count, offset=start)
    if len(values) < count:
        raise InputError(f"{data.name} holds {len(values)} of {count} values; copy it again", path)
    return np.moveaxis(values.reshape(shape), axes.index("bands"), 2)


def _data_files(header: Path) -> list[Path]:
    """Return where the values of a header may be: FILE itself, or with a usual suffix."""
    stem = header.with_suffix("")
    return [stem, *(stem.with_suffix(suffix) for suffix in _DATA_SUFFIXES)]
