"""Textures whose texels are spectra: hyperspectral images, and images of indices into a palette.

`FILE.npz` holds `wavelengths` (L,), nm, and one array (H, W, L) of any name. `FILE.hdr` is the
header of an ENVI image beside its values, with the field `wavelength`, as L3Harris defines it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.runtime.wording import listed, shown
from photonmap.scene.images import Image
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import (
    LARGEST_REFLECTANCE,
    VISIBLE,
    Color,
    Floats,
    Spectrum,
    check_covers,
    check_reflectance,
    check_wavelengths,
    merge_grids,
    resample,
)
from photonmap.spectra.observer import reflectance_to_rgb, upsample_reflectance

_BLOCK = 1 << 16  # Spectra that are converted at a time
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


@dataclass(frozen=True, kw_only=True, eq=False)
class SpectralTexture(Texture):
    """A reflectance that varies over a surface as a spectrum, interpolated band by band.

    `read`, `from_cube` and `from_palette` make one. What knows RGB alone, such as the writers of
    MTL and glTF, sees `image`: its colours under D65.

    Parameters
    ----------
    wavelengths : (L,) float64, nm, of the spectra
    spectra : (K, L) float32, reflectances in [0, 1]; the outer values hold beyond
    index : (H, W) int32, which of them a texel has
    """

    wavelengths: Floats
    spectra: NDArray[np.float32]
    index: NDArray[np.int32]

    @classmethod
    def read(cls, path: str | PathLike[str], linear: bool = True, **mapping: Any) -> Texture:
        """Read a hyperspectral image: FILE.npz, or the header FILE.hdr of an ENVI image.

        Parameters
        ----------
        path : see `photonmap.scene.surfaces.spectral_texture`
        linear : spectra always are
        mapping : scale, offset, clamp; extrapolate and gain as for `from_cube`

        Raises
        ------
        InputError : the file cannot be read, or holds no reflectances
        """
        image = read_spectral_image(Path(path))
        with naming(str(path)):
            return cls.from_cube(image.wavelengths, image.values, **mapping)

    @classmethod
    def from_cube(
        cls,
        wavelengths: ArrayLike,
        values: ArrayLike,
        extrapolate: bool = False,
        gain: float = 1.0,
        **mapping: Any,
    ) -> SpectralTexture:
        """Make a texture from an array with one spectrum a texel.

        Parameters
        ----------
        wavelengths : (L,) nm, increasing
        values : (H, W, L) reflectances in [0, 1] after multiplication with `gain`, top row first
        extrapolate : hold the outer values where 400 to 700 nm is not covered
        mapping : scale, offset, clamp

        Raises
        ------
        InputError : they do not fit together, or are no reflectances
        """
        at, cube = np.asarray(wavelengths, np.float64), np.asarray(values)
        if cube.ndim != 3 or at.shape != cube.shape[2:] or len(at) < 2 or not cube.size:
            raise InputError(
                "a spectral texture needs values of shape (H, W, L) and L wavelengths, 2 or more; "
                f"got {cube.shape} and {at.shape}"
            )
        check_wavelengths(at)
        if not extrapolate:
            check_covers(at, *VISIBLE)
        spectra = np.ascontiguousarray(cube, np.float32).reshape(-1, len(at))
        if gain != 1.0:
            spectra = spectra * np.float32(gain)
        for start in range(0, len(spectra), _BLOCK):
            part = spectra[start : start + _BLOCK]
            if not (part.min() >= 0.0 and part.max() <= LARGEST_REFLECTANCE):
                inside = (part >= 0.0) & (part <= LARGEST_REFLECTANCE)
                check_reflectance(at, part[int(np.argmin(inside.all(axis=1)))])
        index = np.arange(len(spectra), dtype=np.int32).reshape(cube.shape[:2])
        return cls._painted(at, spectra, index, **mapping)

    @classmethod
    def from_palette(
        cls, index: ArrayLike | Path, palette: Sequence[Color], **mapping: Any
    ) -> SpectralTexture:
        """Make a texture from an image of indices into a list of reflectances.

        Parameters
        ----------
        index : (H, W) whole numbers, top row first, or a file that OpenImageIO reads: 0 is the
            first colour of the palette
        palette : reflectances
        mapping : scale, offset, clamp

        Raises
        ------
        InputError : an index is not in the palette, or a colour no reflectance
        """
        at, spectra = _on_one_grid(palette)
        chosen = read_indices(Path(index)) if isinstance(index, str | Path) else np.asarray(index)
        if chosen.ndim != 2 or not chosen.size or chosen.dtype.kind not in "iu":
            raise InputError(f"indices must be whole numbers of shape (H, W), not {chosen.shape}")
        bad = (chosen < 0) | (chosen >= len(spectra))
        if bad.any():
            row, column = np.argwhere(bad)[0].tolist()
            raise InputError(
                f"index {chosen[row, column]} in row {row}, column {column} is not in the palette "
                f"of {len(spectra)}; indices count from 0"
            )
        return cls._painted(at, spectra, np.ascontiguousarray(chosen, np.int32), **mapping)

    @classmethod
    def _painted(
        cls, wavelengths: Floats, spectra: Any, index: NDArray[np.int32], **mapping: Any
    ) -> SpectralTexture:
        """Add the colours under D65."""
        rgb = _averages(Bands.rgb(), wavelengths, spectra)
        parts = {"wavelengths": wavelengths, "spectra": spectra, "index": index}
        return cls(image=Image(rgb[index], False), **mapping, **parts)

    @cached_property
    def color(self) -> Spectrum:
        """The mean of its spectra over the image."""
        counts = np.bincount(self.index.ravel(), minlength=len(self.spectra))
        mean = counts @ self.spectra.astype(np.float64) / self.index.size
        return Spectrum(self.wavelengths, mean, extrapolate=True)

    @cached_property
    def largest(self) -> float:
        """The largest reflectance at any wavelength."""
        return float(self.spectra.max())

    def averages(self, bands: Bands) -> NDArray[np.float32]:
        """Return the band values of its spectra, (K, N)."""
        return _averages(bands, self.wavelengths, self.spectra)


def _on_one_grid(palette: Sequence[Color]) -> tuple[Floats, NDArray[np.float32]]:
    """Return all samples' wavelengths, and the colours there."""
    if not len(palette):
        raise InputError("the palette is empty; give one reflectance for each index")
    curves = []
    for number, color in enumerate(palette):
        with naming(f"palette, color {number}"):
            curve = _as_curve(color)
            curve.check_covers(*VISIBLE)
            check_reflectance(curve.wavelengths, curve.values)
            curves.append(curve)
    grid = reduce(merge_grids, (curve.wavelengths for curve in curves))
    rows = [resample(grid, curve.wavelengths, curve.values[None])[0] for curve in curves]
    return grid, np.array(rows, np.float32)


def _as_curve(color: Any) -> Spectrum:
    """Return a colour as a spectrum, as `Bands.reflectance` understands it."""
    if isinstance(color, Spectrum):
        return color
    Bands.rgb().reflectance(color)  # which refuses what is no colour
    if np.ndim(color):
        return upsample_reflectance(color)
    return Spectrum(np.array(VISIBLE), np.full(2, float(color)), extrapolate=True)


def _averages(bands: Bands, wavelengths: Floats, spectra: Any) -> NDArray[np.float32]:
    """Return the band values of many spectra, (K, N); linear RGB under D65 for the bands of RGB."""
    hats = np.eye(len(wavelengths))
    if bands.is_rgb:
        weights = np.array(
            [reflectance_to_rgb(Spectrum(wavelengths, hat, extrapolate=True)) for hat in hats]
        )
    else:
        weights = bands.average_all(wavelengths, hats)
    result = np.empty((len(spectra), weights.shape[1]), np.float32)
    for start in range(0, len(spectra), _BLOCK):
        part = spectra[start : start + _BLOCK].astype(np.float64) @ weights
        result[start : start + _BLOCK] = np.clip(part, 0.0, 1.0)
    return result


class SpectralImage(NamedTuple):
    """Spectra in rows and columns: wavelengths (L,), nm, and values (H, W, L), top row first."""

    wavelengths: Floats
    values: NDArray[Any]


def is_spectral(path: Path) -> bool:
    """Return whether a file holds spectra by its name; FILE.hdr may be a Radiance image as well."""
    if path.suffix.lower() != ".hdr" or not path.is_file():
        return path.suffix.lower() in SUFFIXES
    with path.open("rb") as file:
        return file.read(4) == b"ENVI"


def read_spectral_image(path: Path) -> SpectralImage:
    """Read FILE.npz or FILE.hdr, or raise `InputError`."""
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

    One that cannot be read, holds floats, or is coloured is an `InputError`.
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
    stem = path.with_suffix("")
    files = [stem, *(stem.with_suffix(suffix) for suffix in _DATA_SUFFIXES)]
    data = next((file for file in files if file.is_file()), None)
    if data is None:
        raise InputError(f"there is no {path.stem}.img beside the header", path)
    count = int(np.prod(shape))
    start = int(fields.get("header offset", 0))
    values = np.fromfile(data, f"{order}{_TYPES[kind]}", count, offset=start)
    if len(values) < count:
        raise InputError(f"{data.name} holds {len(values)} of {count} values; copy it again", path)
    return np.moveaxis(values.reshape(shape), axes.index("bands"), 2)
