"""Whether light goes on after so many bounces that what follows is missing."""

import numpy as np

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.integrators.photon_mapping.radiosity_cache import one_cell
from photonmap.kernels.bsdf.models import NARROW
from photonmap.kernels.core.passes import RadiosityCache, Span
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.integrators.photon import trace_photons

PILOT = 4096
"""Photons of the pilot."""
SMALLEST_FRACTION = 1e-4
"""Of light that may be truncated before a warning is due: less than errors can show.

Total reflection in a room full of glass bottles holds about 3e-5 of the photons for that long."""


def truncated_fraction(compiled: CompiledScene, bands: int, bounces: int, key: np.uint64) -> float:
    """Return which fraction of light paths goes on after so many bounces.

    By photons of a pilot: paths from the camera meet the same surfaces. None is traced where no
    reflectance is high enough.
    """
    scattering = compiled.scattering
    largest = float(compiled.materials.reflectance.max())
    is_glossy = scattering is not None and np.isin(scattering.model, NARROW).any()
    if compiled.textures is not None or is_glossy:
        largest = 1.0
    if largest**bounces < SMALLEST_FRACTION:
        return 0.0
    return fraction_going_on(compiled.arrays, bands, PILOT, bounces, key)


def fraction_going_on(
    scene: SceneArrays, bands: int, photons: int, bounces: int, key: np.uint64
) -> float:
    """Return which fraction of photons goes on after so many bounces."""
    cache = RadiosityCache(
        one_cell(len(scene.geometry.triangles)), np.empty((1, bands), np.float32)
    )
    scratch = np.empty((2, bands), np.float32)
    _, _, truncated = trace_photons(scene, cache, key, Span(0, photons), photons, bounces, scratch)
    return truncated / photons
