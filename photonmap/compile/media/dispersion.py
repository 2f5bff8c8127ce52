"""Indices of refraction of each band, at wavelengths within it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.kernels.core.records import Dispersion
from photonmap.scene.material import Material
from photonmap.scene.surfaces.dispersion import LINES, abbe_index
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.observer import observer

STEPS = 64
"""Wavelengths of each band, of which every pass takes one."""
LIKE = 0.01
"""By how much an index may differ from that of its dispersion."""

Floats = NDArray[np.float64]


def index_steps(
    materials: Sequence[Material], indices: Sequence[float], bands: Bands
) -> Floats | None:
    """Return indices of refraction, (K, R, N): of R media, at K wavelengths of each band.

    The wavelengths divide each band's sensitivity into K parts of the same integral. The first
    media are the insides of materials; None where nothing disperses.

    Raises
    ------
    InputError : a material has two kinds of dispersion, or an index that does not fit
    """
    dispersing = [row for row, each in enumerate(materials) if disperses(each)]
    if not dispersing:
        return None
    wavelengths = _wavelengths(bands)
    steps = np.tile(np.array(indices)[:, None], (STEPS, 1, bands.count))
    for row in dispersing:
        steps[:, row] = _index(materials[row], wavelengths)
    return steps


def disperses(material: Material) -> bool:
    """Return whether the index of solid glass depends on wavelength."""
    has = material.dispersion is not None or material.abbe is not None
    return has and material.ior is not None and not material.thin


def _index(material: Material, wavelengths: Floats) -> Floats:
    """Return the index of a material at wavelengths."""
    curve, index, abbe = material.dispersion, material.ior, material.abbe
    assert index is not None
    with naming(f"material {material.name!r}"):
        if curve is None:
            assert abbe is not None
            return abbe_index(wavelengths, index, abbe)
        if abbe is not None:
            raise InputError("has an abbe number and a dispersion; remove one of them")
        wanted = float(curve.index(LINES[0]))
        if abs(wanted - index) > LIKE:
            raise InputError(
                f"ior {index:g} is not that of its dispersion, {wanted:.5g} at {LINES[0]:.1f} nm; "
                "leave it out"
            )
        return curve.index(wavelengths)


def _wavelengths(bands: Bands) -> Floats:
    """Return wavelengths that divide the sensitivity of each band evenly, (K, N)."""
    curves = bands.sensitivities or [
        Spectrum(observer().wavelengths, np.maximum(row, 0.0)) for row in observer().matching
    ]
    parts = (np.arange(STEPS) + 0.5) / STEPS
    columns = []
    for curve in curves:
        grid = np.linspace(curve.wavelengths[0], curve.wavelengths[-1], 4096)
        density = np.maximum(np.interp(grid, curve.wavelengths, curve.values), 0.0)
        rising = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
        columns.append(np.interp(parts * rising[-1], rising, grid))
    return np.stack(columns, axis=1)


def make_dispersion(steps: Floats) -> Dispersion:
    """Return what kernels take, with the wavelengths in the middle of the bands."""
    flat = steps.reshape(-1, steps.shape[2])
    wave = np.unique(flat, axis=1, return_inverse=True)[1].ravel().astype(np.int32)
    spread = np.ptp(steps, axis=2).max(axis=0)
    return Dispersion(steps[len(steps) // 2].copy(), steps, wave, (spread > 0.0).astype(np.uint8))
