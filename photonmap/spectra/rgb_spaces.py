"""RGB spaces and cameras that images in bands are projected onto, by name."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import suggest
from photonmap.spectra.bands import Bands
from photonmap.spectra.observer import observer
from photonmap.spectra.projection import Method, choose_projection

Floats = NDArray[np.float64]

SRGB, REC2020 = "srgb", "rec2020"
_D65, _ACES = None, (0.32168, 0.33767)
_PRIMARIES = {
    REC2020: (((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)), _D65),
    "aces-ap0": (((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.0770)), _ACES),
    "aces-ap1": (((0.713, 0.293), (0.165, 0.830), (0.128, 0.044)), _ACES),
}
"""Chromaticities of red, green, blue and white; None for the white of sRGB, D65.

Of ITU-R BT.2020-2, SMPTE ST 2065-1 and ACES S-2014-004.
"""
SPACES = (SRGB, *_PRIMARIES, "xyz")
"""Names of the spaces; instead of one, a camera or FILE.csv may be given."""


def check_space(name: str) -> str:
    """Return the name of a space, a camera or a file of three sensitivities.

    Raises
    ------
    InputError : there is none
    """
    if name not in SPACES:
        _camera(name)
    return name


def _camera(name: str) -> Bands:
    try:
        bands = Bands.parse(name)
    except InputError:
        bands = None
    if bands is None or bands.count != 3 or bands.is_rgb:
        nearest = suggest(name, SPACES)
        other = " " if nearest[-1] == "?" else ", or give "
        raise InputError(
            f"there is no RGB {name!r}; {nearest}{other}the name of a camera, or a FILE.csv of "
            "three sensitivities"
        )
    return bands


@cache
def from_srgb(name: str) -> Floats:
    """Return the matrix (3, 3) from linear sRGB to a space; light is not adapted to its white."""
    if name == SRGB:
        return np.eye(3)
    to_xyz = observer().rgb_to_xyz
    if name == "xyz":
        return to_xyz
    primaries, white = _PRIMARIES[name]
    columns = np.array([_xyz(each) for each in primaries]).T
    light = to_xyz.sum(axis=1) if white is None else _xyz(white)
    columns = columns * np.linalg.solve(columns, light)
    return np.linalg.solve(columns, to_xyz)


def _xyz(chromaticity: tuple[float, float]) -> Floats:
    """Return the XYZ of a chromaticity at Y = 1; of one at y = 0, those of x + z alone."""
    x, y = chromaticity
    return np.array([x, y, 1.0 - x - y]) / (y if abs(y) > 1e-9 else 1.0)


def projection_onto(bands: Bands, name: str, method: Method | None) -> Floats:
    """Return the matrix (3, N) from the radiances of bands to a space or a camera.

    Bands that are the camera's own are taken as they are.

    Parameters
    ----------
    method : as `photonmap.spectra.projection.choose_projection` takes it; None for bands of RGB

    Raises
    ------
    InputError : there is no such space
    """
    if name in SPACES:
        return from_srgb(name) @ choose_projection(bands, "rgb", method or "direct").matrix
    camera = _camera(name)
    if camera.describe() == bands.describe():
        return np.eye(3)
    return choose_projection(bands, camera, method or "direct").matrix
