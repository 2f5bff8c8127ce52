"""Whether photons hit a scene's surfaces, and warnings where they do not."""

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import warn
from photonmap.integrators.photon_mapping.radiosity_cache import one_cell
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.integrators.photon import trace_photons

PILOT = 4096
"""Photons of the pilot, at most."""
LOWEST_HIT_RATE = 1 / 64
"""Hits per photon below which the radiosity cache would be empty where light is looked up."""
MANY = 0.9
"""Fraction of the pixels that may be unresolved before a warning is due."""


def do_photons_hit(compiled: CompiledScene, bands: int, photons: int, key: np.uint64) -> bool:
    """Return whether photons hit surfaces often enough to estimate light.

    They do not where a sky shines into a pit, or a light past a few small objects; or where there
    are no photons.

    Parameters
    ----------
    photons : in a pass; as many are sent, `PILOT` at most
    key : of random numbers of their own
    """
    total = min(photons, PILOT)
    cache = RadiosityCache(
        one_cell(len(compiled.geometry.triangles)), np.empty((1, bands), np.float32)
    )
    scratch = np.empty((2, bands), np.float32)
    stores, _, _ = trace_photons(compiled.arrays, cache, key, Span(0, total), total, 1, scratch)
    return stores > LOWEST_HIT_RATE * total


def warn_of_few_photons(unresolved: NDArray[np.bool_]) -> None:
    """Warn where photons say nothing about indirect light.

    Parameters
    ----------
    unresolved : (P,) pixels in which gather rays found no photon, although some were stored
    """
    if unresolved.mean() > MANY:
        warn(
            f"no photon was found for the indirect light of {unresolved.sum()} pixels "
            f"(unresolved): the little light that arrives there is missing; use more photons"
        )
