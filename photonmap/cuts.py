"""Whether light goes on after so many bounces that what follows is missing."""

import numpy as np

from photonmap.cells import one_cell
from photonmap.kernels.photon import trace_photons
from photonmap.kernels.records import SceneArrays
from photonmap.prepare import Prepared

PILOT = 4096
SMALLEST_SHARE = 1e-5
"""Of light that may be cut before a warning is due: less than errors can show."""


def share_cut(prepared: Prepared, bands: int, bounces: int, key: np.uint64) -> float:
    """Return which share of light paths goes on after so many bounces.

    By photons of a pilot: paths from the camera meet the same surfaces. None is traced where no
    reflectance is high enough.
    """
    reflectance = prepared.materials.reflectance
    largest = float(reflectance.max()) if prepared.textures is None else 1.0
    if largest**bounces < SMALLEST_SHARE:
        return 0.0
    return share_going_on(prepared.arrays, bands, PILOT, bounces, key)


def share_going_on(
    scene: SceneArrays, bands: int, photons: int, bounces: int, key: np.uint64
) -> float:
    """Return which share of photons goes on after so many bounces."""
    _, cut = trace_photons(
        *scene,
        one_cell(len(scene[0].triangles)),
        key,
        0,
        photons,
        photons,
        bounces,
        np.empty(bands, np.float32),
        np.empty((1, bands), np.float32),
    )
    return cut / photons
