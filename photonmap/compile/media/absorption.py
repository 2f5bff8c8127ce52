"""What glass absorbs inside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.scene.material import Material
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum

LEAST_TRANSMITTANCE = 1e-30
"""What is darker counts as this, which no image can tell from black."""

Floats = NDArray[np.float64]


def absorption_table(materials: Sequence[Material], bands: Bands) -> Floats:
    """Return the absorption coefficients of M materials, (M, N), in the inverse of scene units.

    Raises
    ------
    InputError : what absorbs is no solid glass, or has no distance
    """
    return np.stack([_absorption(material, bands) for material in materials])


def _absorption(material: Material, bands: Bands) -> Floats:
    """Return the absorption coefficient of each band, (N,), in the inverse of scene units."""
    color, distance = material.attenuation_color, material.attenuation_distance
    if not isinstance(color, Spectrum) and np.all(np.equal(color, 1.0)):
        return np.zeros(bands.count)
    with naming(f"material {material.name!r}: attenuation_color"):
        transmitted = bands.reflectance(color)
        if not ((transmitted >= 0.0) & (transmitted <= 1.001)).all():
            raise InputError("lies outside of [0, 1]; correct it")
        if material.ior is None or material.thin:
            raise InputError("only solid glass absorbs; give it an ior, and no thin")
        if distance is None:
            raise InputError("needs an attenuation_distance, after which this colour is left")
    return -np.log(np.clip(transmitted, LEAST_TRANSMITTANCE, 1.0)) / distance
