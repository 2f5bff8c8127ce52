"""Textures whose texels are spectra: hyperspectral images, and images of indices into a palette."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.scene.images import Image
from photonmap.scene.surfaces.spectral_images import read_indices, read_spectral_image
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import (
    LARGEST_REFLECTANCE,
    VISIBLE,
    Color,
    Spectrum,
    check_covers,
    check_reflectance,
    check_wavelengths,
    merge_grids,
    resample,
)
from photonmap.spectra.observer import reflectance_to_rgb, upsample_reflectance

Floats = NDArray[np.float64]
_BLOCK = 1 << 16
"""Spectra that are converted at a time."""


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
        path : see `photonmap.scene.surfaces.spectral_images`
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
    """Return a colour as a spectrum, as `Bands.reflectance` understands it.

    Raises
    ------
    InputError : it is none
    """
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
