"""The RGB spaces in which image files state their colours, and their way to linear sRGB."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.spectra.curves import Floats
from photonmap.spectra.names import colour_science
from photonmap.spectra.observer import observer

Chromaticities = tuple[float, ...]
"""x and y of red, green, blue and white."""
Transfer = Callable[[NDArray[Any]], NDArray[Any]]
"""From encoded values, 0 to 1 in the range of integers, to linear ones."""

SRGB: Chromaticities = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
XYZ: Chromaticities = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1 / 3, 1 / 3)
_SRGB_UNDER_D50 = (0.6484, 0.3309, 0.3212, 0.5979, 0.1559, 0.0660, 0.3457, 0.3585)
"""What ICC profiles of sRGB state, whose colours are adapted to D50."""
PRIMARIES: dict[str, Chromaticities | str] = {
    "rec709": SRGB,
    "p3d65": "Display P3",
    "rec2020": "ITU-R BT.2020",
    "adobergb": "Adobe RGB (1998)",
    "prophoto": "ProPhoto RGB",
    "ap0": "ACES2065-1",
    "ap1": "ACEScg",
    "ciexyzd65": XYZ,
}
"""Chromaticities, or the name of a space in colour-science."""
_SAME = 2e-3  # of x and y: what remains is below the steps of 8 bits
_FLAT = 1e-6  # Twice the area of a triangle of primaries that are in one line
_ADAPTATION = "Bradford"  # as in ICC profiles and ACES


def decode_srgb(values: NDArray[Any]) -> NDArray[Any]:
    """Return the linear values of sRGB-encoded ones in [0, 1], IEC 61966-2-1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode_srgb(linear: Floats) -> Floats:
    """Return the sRGB encoding of linear values in [0, 1], IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def decode_linear(values: NDArray[Any]) -> NDArray[Any]:
    """Return linear values as they are."""
    return values


def decode_power(exponent: float) -> Transfer:
    """Return the transfer of a power."""
    return lambda values: values**exponent


def _decode_rec709(values: NDArray[Any]) -> NDArray[Any]:
    """Return the light that a camera of ITU-R BT.709 saw."""
    return np.where(values < 0.081, values / 4.5, ((values + 0.099) / 1.099) ** (1 / 0.45))


TRANSFERS: dict[str, Transfer] = {
    "lin": decode_linear,
    "srgb": decode_srgb,
    "rec709": _decode_rec709,
    **{f"g{10 * exponent:.0f}": decode_power(exponent) for exponent in (1.8, 2.2, 2.4, 2.6, 2.8)},
}
"""Transfers by the names of the Color Interop Forum."""


@cache
def to_srgb(primaries: Chromaticities | str) -> Floats | None:
    """Return the matrix (3, 3) from linear RGB of other primaries to linear sRGB; None for its own.

    White stays white: colours are adapted to D65 by Bradford's transform. Those of XYZ, which has
    no white of its own, are not adapted. An `InputError` says that the primaries span no colours.

    primaries : chromaticities, or the name of a space in colour-science
    """
    if isinstance(primaries, str):
        with colour_science() as colour:
            space = colour.RGB_COLOURSPACES[primaries]
        return to_srgb((*space.primaries.ravel().tolist(), *space.whitepoint.tolist()))
    if any(np.allclose(primaries, own, atol=_SAME) for own in (SRGB, _SRGB_UNDER_D50)):
        return None
    if np.allclose(primaries, XYZ, atol=_SAME):
        return np.asarray(np.linalg.inv(observer().rgb_to_xyz), np.float64)
    corners = np.reshape(primaries, (4, 2))
    edges = corners[1:3] - corners[0]
    if not (
        np.isfinite(corners).all() and abs(np.linalg.det(edges)) > _FLAT and corners[3, 1] > 0.0
    ):
        listed = ", ".join(f"{number:g}" for number in primaries)
        raise InputError(
            f"states primaries and a white that span no colours ({listed}); correct them"
        )
    with colour_science() as colour:
        given, own = (
            colour.RGB_Colourspace("", xy[:3], xy[3]) for xy in (corners, np.reshape(SRGB, (4, 2)))
        )
        matrix: Floats = colour.matrix_RGB_to_RGB(given, own, _ADAPTATION)
    return matrix
