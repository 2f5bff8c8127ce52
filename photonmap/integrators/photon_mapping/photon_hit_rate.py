"""How often photons hit a scene's surfaces, and warnings where they do not."""

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import warn
from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.cache_layout import one_cell
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.integrators.photon import trace_photons

PILOT = 4096
"""Photons of the pilot, at most."""
LOWEST_HIT_RATE = 1 / 64
"""Hits per photon below which the radiosity cache would be empty where light is looked up."""
MANY = 0.9
"""Fraction of the pixels that may be unresolved before a warning is due."""


def do_photons_hit(setup: PassSetup) -> bool:
    """Return whether photons hit surfaces often enough to estimate light.

    They do not where a sky shines into a pit, or a light past a few small objects.
    """
    return stores_per_photon(setup, 1) > LOWEST_HIT_RATE


def stores_per_photon(setup: PassSetup, bounces: int) -> float:
    """Return how many times a photon is stored on average, by a pilot with its own random numbers.

    Parameters
    ----------
    bounces : after which photons are truncated
    """
    total = min(setup.photons, PILOT)
    cells = one_cell(len(setup.compiled.geometry.triangles))
    cache = RadiosityCache(cells, np.empty((1, setup.bands), np.float32))
    key, scratch = setup.key(0, Domain.PHOTON_HITS), np.empty((2, setup.bands), np.float32)
    stores, _, _ = trace_photons(
        setup.scene(0), cache, key, Span(0, total), total, bounces, scratch
    )
    return float(stores / total)


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
