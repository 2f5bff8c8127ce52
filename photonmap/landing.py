"""Whether photons come to a scene's surfaces, and warnings where they do not."""

import numpy as np
from numpy.typing import NDArray

from photonmap.cells import one_cell
from photonmap.errors import warn
from photonmap.kernels.photon import trace_photons
from photonmap.prepare import Prepared

PILOT = 4096
"""Photons at most."""
HARDLY = 1 / 64
"""Hits for each photon, below which a store would be empty where light is looked up."""

MANY = 0.9
"""Part of the pixels that may be unresolved before a warning is due."""


def do_photons_land(prepared: Prepared, bands: int, photons: int, key: np.uint64) -> bool:
    """Tell whether photons meet surfaces often enough to say what light there is.

    They do not where a sky shines into a pit, or a lamp past a few small things; or where there are
    no photons.

    Parameters
    ----------
    photons : in a pass; as many are sent, `PILOT` at most
    key : of random numbers of their own
    """
    total = min(photons, PILOT)
    stores, _ = trace_photons(
        *prepared.arrays,
        one_cell(len(prepared.geometry.triangles)),
        key,
        0,
        total,
        total,
        1,
        np.empty(bands, np.float32),
        np.empty((1, bands), np.float32),
    )
    return stores > HARDLY * total


def warn_of_few_photons(unresolved: NDArray[np.bool_]) -> None:
    """Warn where photons tell nothing of indirect light.

    Parameters
    ----------
    unresolved : (P,) pixels in which gather rays found no photon, although some were stored
    """
    if unresolved.mean() > MANY:
        warn(
            f"no photon tells of the indirect light of {unresolved.sum()} pixels (unresolved): "
            f"if any gets there, it is rare, and missing; take more photons"
        )
