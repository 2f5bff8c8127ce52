"""Photons of a pilot, which are only counted: how often they hit surfaces, and how many go on."""

import numpy as np

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.cache_cells import one_cell
from photonmap.kernels.bsdf.models import NARROW
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.integrators.photon import trace_photons

PILOT = 4096
"""Photons of the pilot, at most."""
LOWEST_HIT_RATE = 1 / 64
"""Hits per photon below which the radiosity cache would be empty where light is looked up."""
SMALLEST_FRACTION = 1e-4
"""Of light that may be truncated before a warning is due: less than errors can show.

Total reflection in a room full of glass bottles holds about 3e-5 of the photons for that long."""


def do_photons_hit(setup: PassSetup) -> bool:
    """Return whether photons hit surfaces often enough to estimate light.

    They do not where a sky shines into a pit, or a light past a few small objects.
    """
    return stores_per_photon(setup, 1) > LOWEST_HIT_RATE


def stores_per_photon(setup: PassSetup, bounces: int) -> float:
    """Return how many times a photon is stored on average before it is truncated."""
    photons, key = min(setup.photons, PILOT), setup.key(0, Domain.PHOTON_HITS)
    return count_photons(setup.scene(0), setup.bands, photons, bounces, key)[0]


def truncated_fraction(compiled: CompiledScene, bands: int, bounces: int, key: np.uint64) -> float:
    """Return which fraction of light paths goes on after so many bounces.

    Paths from the camera meet the same surfaces as photons. None is traced where no reflectance is
    high enough.
    """
    scattering = compiled.scattering
    largest = float(compiled.materials.reflectance.max())
    is_glossy = scattering is not None and np.isin(scattering.model, NARROW).any()
    if compiled.textures is not None or compiled.fluorescence is not None or is_glossy:
        largest = 1.0
    if largest**bounces < SMALLEST_FRACTION:
        return 0.0
    return count_photons(compiled.arrays, bands, PILOT, bounces, key)[1]


def count_photons(
    scene: SceneArrays, bands: int, photons: int, bounces: int, key: np.uint64
) -> tuple[float, float]:
    """Return how often photons are stored on average, and which fraction goes on after bounces."""
    cells = one_cell(len(scene.geometry.triangles))
    cache = RadiosityCache(cells, np.empty((1, bands), np.float32))
    span, scratch = Span(0, photons), np.empty((3, bands), np.float32)
    stores, _, truncated, _ = trace_photons(scene, cache, key, span, photons, bounces, scratch)
    return float(stores / photons), truncated / photons
