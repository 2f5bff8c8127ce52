"""Munsell chips: measured ones where the user has them, otherwise recovered from the renotation."""

from __future__ import annotations

import os
import re
from functools import cache
from pathlib import Path

import numpy as np

from photonmap.errors import InputError, warn
from photonmap.spectra.curves import Spectrum, SpectrumSet
from photonmap.spectra.names import colour_science

VARIABLE = "PHOTONMAP_MUNSELL"  # The environment variable that names the measured set

SHIPPED = Path(__file__).parents[1] / "data" / "munsell.npz"

_HUES = "R|YR|Y|GY|G|BG|B|PB|P|RP"
_CHIP = re.compile(rf"(\d+(?:\.\d+)?) *({_HUES}) *(\d+(?:\.\d+)?) */ *(\d+(?:\.\d+)?)", re.I)
_GREY = re.compile(r"N *(\d+(?:\.\d+)?) */? *", re.I)
_TOLERANCE = 0.005  # of XYZ with Y = 1 for white: the most that clipping to [0, 1] may change


def munsell(notation: str, path: str | None = None) -> Spectrum:
    """Return the reflectance of a chip, "5R 5/10" or "N 5".

    A measured curve if the measured set (that of a path, or that `VARIABLE` names) has the chip;
    otherwise one recovered from the colour that the Munsell renotation gives it under illuminant C,
    see `recover`. What is not a notation, or not in the renotation data, is an `InputError`.
    """
    name, measured = canonical(notation), measured_set(path)
    if measured is not None:
        if name in measured.names:
            return measured[name]
        warn(f"munsell:{name} is not a measured chip; its curve is recovered from the renotation")
    shipped = shipped_set()
    return shipped[name] if name in shipped.names else recover(name)


def munsell_set(path: str | None = None) -> SpectrumSet:
    """Return the measured chips, or those recovered from the renotation that are shipped."""
    return measured_set(path) or shipped_set()


def measured_set(path: str | None = None) -> SpectrumSet | None:
    """Return the measured chips of a file; None if neither `path` nor `VARIABLE` names one."""
    path = path or os.environ.get(VARIABLE)
    return _read(path) if path else None


@cache
def shipped_set() -> SpectrumSet:
    """Return the chips of `data/munsell.npz`, which tools/make_munsell.py recovered."""
    with np.load(SHIPPED) as file:
        return SpectrumSet(file["wavelength"], file["R"], tuple(file["label"].tolist()))


@cache
def _read(path: str) -> SpectrumSet:
    from photonmap.spectra.measured import read_munsell

    return read_munsell(path)


def canonical(notation: str) -> str:
    """Return "5R 5/10" or "N5" for any way of writing it, or raise `InputError`."""
    if chip := _CHIP.fullmatch(notation.strip()):
        hue, letters, value, chroma = chip.groups()
        if float(chroma) == 0.0:
            return f"N{float(value):g}"
        return f"{float(hue):g}{letters.upper()} {float(value):g}/{float(chroma):g}"
    if grey := _GREY.fullmatch(notation.strip()):
        return f"N{float(grey[1]):g}"
    raise InputError(f"{notation!r} is not a Munsell notation; write it as '5R 5/10' or 'N 5'")


@cache
def recover(name: str) -> Spectrum:
    """Return a smooth reflectance, 380 to 730 nm, of the renotation's colour under illuminant C.

    By the clusters of H. Otsu, M. Yamamoto and T. Hachisuka, "Reproducing Spectral Reflectances
    From Tristimulus Colours", Computer Graphics Forum 37(6), 2018; greys are flat. The name is as
    `canonical` returns it; one outside of the renotation data is an `InputError`.
    """
    if name.startswith("N"):
        return _grey(name)
    with colour_science() as colour:
        try:
            xyz = colour.xyY_to_XYZ(colour.munsell_colour_to_xyY(name))
        except (AssertionError, ValueError, RuntimeError):
            raise _outside(name, "the renotation data") from None
        shape = colour.recovery.SPECTRAL_SHAPE_OTSU2018
        observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
        white = colour.SDS_ILLUMINANTS["C"].copy().align(shape)
        curve = colour.recovery.XYZ_to_sd_Otsu2018(xyz, observer, white)
        recovered = colour.sd_to_XYZ(curve, observer, white) / 100.0
    if np.abs(recovered - xyz).max() > _TOLERANCE:
        raise _outside(name, "the gamut of reflectances between 0 and 1")
    return Spectrum(curve.wavelengths, curve.values)


def _grey(name: str) -> Spectrum:
    """Return the flat reflectance of a Munsell value, ASTM D1535."""
    if not 0.0 <= (value := float(name[1:])) <= 10.0:
        raise InputError(f"munsell:{name}: values lie between 0 and 10; correct the notation")
    with colour_science() as colour:
        grey = float(colour.colorimetry.luminance_ASTMD1535(value)) / 100.0
        wavelengths = colour.recovery.SPECTRAL_SHAPE_OTSU2018.wavelengths
    return Spectrum(wavelengths, np.full(len(wavelengths), min(grey, 1.0)))


def _outside(name: str, what: str) -> InputError:
    return InputError(f"munsell:{name} is outside {what}; lower its chroma")
