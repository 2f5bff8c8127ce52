"""Textures whose texels are spectra: hyperspectral images, and images of indices into a palette.

`FILE.npz` holds `wavelengths` (L,), nm, and one array (H, W, L) of any name. `FILE.hdr` is the
header of an ENVI image beside its values, with the field `wavelength`, as L3Harris defines it;
bands that its `bbl` calls bad are left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.runtime.bounds import Shapes, check_unpacked, read_npz
from photonmap.runtime.terminal import quiet_libraries
from photonmap.runtime.wording import listed, shown
from photonmap.scene.image_headers import turned
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
_UNITS = {
    "nanometer": 1.0, "nm": 1.0, "micrometer": 1e3, "micron": 1e3, "um": 1e3, "µm": 1e3, "μm": 1e3,
    "millimeter": 1e6, "centimeter": 1e7, "meter": 1e9, "angstrom": 0.1, "å": 0.1,
}  # fmt: skip
"""Nanometres in units of wavelength, in lower case and in the singular"""
_RECIPROCAL = {"wavenumber": 1e7, "cm-1": 1e7, "ghz": 299792458.0, "mhz": 299792458e3}
"""What divided by a wavenumber or a frequency is nanometres"""
_GAINS = ("data reflectance gain values", 1.0), ("data reflectance offset values", 0.0)
_RADIANCE_GAINS = ("data gain values", 1.0), ("data offset values", 0.0)
_FEWEST = 2  # Bands of a spectrum
_FIELD = re.compile(r"^[ \t]*([^=\n{}]+?)[ \t]*=[ \t]*(\{[^}]*\}|[^\n]*)", re.MULTILINE)
_DATA_SUFFIXES = (".img", ".dat", ".raw", ".bsq", ".bil", ".bip")


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
        mapping : scale, offset, clamp, nearest; extrapolate and gain as for `from_cube`

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
        mapping : scale, offset, clamp, nearest

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
            held = "extrapolate = true beside the file in TOML, extrapolate=True in code"
            check_covers(at, *VISIBLE, held)
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
        mapping : scale, offset, clamp, nearest

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
    except (OSError, ValueError, KeyError) as error:
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
    check_unpacked(path, spec.width * spec.height * spec.nchannels * 4)
    with quiet_libraries():
        pixels = file.read_image(0, 0, 0, spec.nchannels, kind)
    file.close()
    if pixels is None:
        raise InputError(f"is damaged ({OpenImageIO.geterror() or 'unknown reason'})", path)
    names = [name.lower() for name in spec.channelnames]
    colors = pixels[..., [i for i, name in enumerate(names) if name not in ("a", "alpha")]]
    if (colors != colors[..., :1]).any():
        raise InputError("is coloured; an image of indices is grey", path)
    upright = turned(colors, spec.get_int_attribute("Orientation", 1))
    return np.ascontiguousarray(upright[..., 0], np.int32)


def _read_npz(path: Path) -> SpectralImage:
    def choose(shapes: Shapes) -> list[str]:
        cubes = [name for name, shape in shapes.items() if len(shape) == 3]
        if "wavelengths" not in shapes or len(cubes) != 1:
            raise InputError(
                f"holds {listed(shapes) or 'nothing'}; it needs 'wavelengths' (L,) in nm "
                "and one array (H, W, L)",
                path,
            )
        return ["wavelengths", *cubes]

    wavelengths, cube = read_npz(path, choose).values()
    return SpectralImage(wavelengths.astype(np.float64), cube)


def _read_envi(path: Path) -> SpectralImage:
    text = path.read_text(encoding="utf-8", errors="replace")
    if not text.startswith("ENVI"):
        raise InputError("is no ENVI header, which begins with ENVI", path)
    if text.count("{") != text.count("}"):
        raise InputError("has braces that are not closed; write { and } around each list", path)
    fields = {
        " ".join(key.lower().split()): value.strip("{} \t\r\n")
        for key, value in _FIELD.findall(text)
    }
    header = _EnviHeader(path, fields)
    missing = [
        key for key in ("samples", "lines", "bands", "data type", "wavelength") if key not in fields
    ]
    if missing:
        raise header.error(f"the header lacks {listed(missing)}; add it")
    is_good = header.numbers("bbl", 1.0) != 0.0
    if (count := np.count_nonzero(is_good)) < _FEWEST:
        raise header.error(f"bbl leaves {count} good bands; a spectrum needs {_FEWEST} or more")
    wavelengths, values = header.wavelengths()[is_good], header.values()
    values = values if is_good.all() else values[..., is_good]
    header.check_data(values)
    return SpectralImage(wavelengths, header.reflectances(values, is_good))


@dataclass(frozen=True)
class _EnviHeader:
    path: Path
    fields: dict[str, str]  # keys in lower case

    def error(self, message: str) -> InputError:
        return InputError(message, self.path)

    def whole(self, key: str, least: int = 0, default: str = "0") -> int:
        """Return a whole number, so small that sizes computed from it are exact."""
        text = self.fields.get(key, default)
        if not re.fullmatch(r"[0-9]{1,12}", text) or int(text) < least:
            raise self.error(f"{key} {shown(text)} is not a whole number from {least}; correct it")
        return int(text)

    def numbers(self, key: str, default: float) -> Floats:
        """Return a finite number for each band."""
        bands = self.whole("bands", 1)
        if key not in self.fields:
            return np.full(bands, default)
        values = [self._number(key, word) for word in re.split(r"[,\s]+", self.fields[key]) if word]
        if len(values) != bands:
            problem = f"{key} has {len(values)} numbers for {bands} bands"
            raise self.error(f"{problem}; write one for each band")
        return np.array(values)

    def _number(self, key: str, text: str, finite: bool = True) -> float:
        try:
            value = float(text)
        except ValueError:
            value = None
        if value is None or "_" in text or (finite and not np.isfinite(value)):
            raise self.error(f"{key} {shown(text)} is not a number; correct it")
        return value

    def wavelengths(self) -> Floats:
        """Return the wavelengths of all bands, nm; without a unit, that in which they are light."""
        text = self.fields.get("wavelength units", "")
        unit = text.lower().replace("metre", "meter").removesuffix("s")
        at = self.numbers("wavelength", 0.0)
        if unit in _RECIPROCAL and at.all():
            at = _RECIPROCAL[unit] / at
        elif unit in _UNITS:
            at = at * _UNITS[unit]
        elif unit not in ("", "unknown"):
            remedy = "write the unit of its wavelengths, such as Nanometers or Micrometers"
            raise self.error(f"wavelength units {shown(text)} are not known; {remedy}")
        elif not _is_light(at):
            at = at * _UNITS["micrometer"]
        if not _is_light(at):
            problem = f"no band is near light, {VISIBLE[0]:g} to {VISIBLE[1]:g} nm: they lie at"
            span = f"{at.min():g} to {at.max():g} nm by wavelength and wavelength units"
            raise self.error(f"{problem} {span}; correct these")
        return at

    def values(self) -> NDArray[Any]:
        """Return the values beside a header, (H, W, L)."""
        kind = self.whole("data type")
        interleave = self.fields.get("interleave", "bsq").lower()
        if kind not in _TYPES or interleave not in _LAYOUTS:
            raise self.error(
                f"data type {kind} with interleave {interleave} is not known; "
                f"write types {listed(map(str, _TYPES), 9)} as bsq, bil or bip"
            )
        if (order := self.whole("byte order")) > 1:
            raise self.error(f"byte order {order} is neither 0 nor 1; correct it")
        for key in ("file compression", "major frame offsets", "minor frame offsets"):
            if self.fields.get(key, "0").strip("0, \t\r\n"):
                raise self.error(f"{key} {self.fields[key]} is not read; write plain values")
        axes, dtype = _LAYOUTS[interleave], np.dtype("<>"[order] + _TYPES[kind])
        shape = [self.whole(axis, 1) for axis in axes]
        count, start = math.prod(shape), self.whole("header offset")
        stem = self.path.with_suffix("")
        files = [stem, *(stem.with_suffix(suffix) for suffix in _DATA_SUFFIXES)]
        data = next((file for file in files if file.is_file()), None)
        if data is None:
            raise self.error(f"there is no {self.path.stem}.img beside the header")
        if (held := max(data.stat().st_size - start, 0) // dtype.itemsize) < count:
            raise self.error(f"{data.name} holds {held} of {count} values; copy it again")
        values = np.fromfile(data, dtype, count, offset=start)
        return np.moveaxis(values.reshape(shape), axes.index("bands"), 2)

    def check_data(self, values: NDArray[Any]) -> None:
        """Refuse texels without data, which have no reflectance."""
        if "data ignore value" not in self.fields:
            return
        text = self.fields["data ignore value"]
        ignored = self._number("data ignore value", text, finite=False)
        with np.errstate(over="ignore"):
            wanted = values.dtype.type(ignored) if values.dtype.kind == "f" else ignored
        is_bare = np.isnan(values) if np.isnan(ignored) else values == wanted
        if (bare := np.argwhere(is_bare.any(axis=2))).size:
            row, column = bare[0].tolist()
            raise self.error(
                f"{len(bare)} of {values[..., 0].size} texels have no data (data ignore value "
                f"{text}), the first in row {row}, column {column}; crop or fill them, or mark "
                "bands without data in bbl"
            )

    def reflectances(self, values: NDArray[Any], good: NDArray[np.bool_]) -> NDArray[Any]:
        """Return values by the gains or the scale of reflectances; those of radiances are none."""
        gains, offsets = (self.numbers(*field)[good] for field in _GAINS)
        if "reflectance scale factor" in self.fields:
            key = "reflectance scale factor"
            scale = self._number(key, self.fields[key])
            if scale <= 0.0 or (gains != 1.0).any() or offsets.any():
                problem = f"{key} {scale:g} is not above 0, or stands beside gains or offsets"
                raise self.error(f"{problem} of reflectance; keep one of them")
            return values.astype(np.float32) / np.float32(scale)
        if not {key for key, _ in _GAINS} & {*self.fields}:
            gain, offset = (self.numbers(*field)[good] for field in _RADIANCE_GAINS)
            if (gain != 1.0).any() or offset.any():
                problem = "data gain values and data offset values make radiances of its values"
                remedy = "convert them to reflectances, or remove the fields if they are some"
                raise self.error(f"{problem}; {remedy}")
            return values
        return (values * gains + offsets).astype(np.float32)


def _is_light(wavelengths: Floats) -> bool:
    return bool(wavelengths.min() <= VISIBLE[1] and wavelengths.max() >= VISIBLE[0])
