"""Warn where truncated paths lose light."""

import numpy as np

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.errors import warn
from photonmap.film.budget import LEAST_PASSES
from photonmap.film.moments import Accumulator
from photonmap.integrators.base import Integrator
from photonmap.integrators.photon_mapping.cache_layout import one_cell
from photonmap.kernels.bsdf.models import NARROW
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN
from photonmap.kernels.core.passes import MAX_BOUNCES, RadiosityCache, Span
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.integrators.photon import trace_photons

PILOT = 4096
"""Photons of the pilot."""
SMALLEST_FRACTION = 1e-4
"""Of light that may be truncated before a warning is due: less than errors can show.

Total reflection in a room full of glass bottles holds about 3e-5 of the photons for that long."""
TOLERATED_CHAINS = 1e-3
"""Fraction of pixels that may show a truncated specular chain every `LEAST_PASSES` passes without a
warning: from balls of glass whose normals are interpolated, a few rays never leave."""


def warn_of_truncated_paths(integrator: Integrator, moments: Accumulator) -> None:
    """Warn where light is missing from the passes so far, because paths were truncated."""
    missing = "surfaces reflect nearly everything, and light is missing from indirect"
    truncated, photons = integrator.counters.truncated, integrator.counters.photons
    if truncated > SMALLEST_FRACTION * photons:
        warn(
            f"{truncated} of {photons} photons were truncated after {MAX_BOUNCES} bounces: "
            f"{missing}"
        )
    share = integrator.truncated_fraction()
    if share > SMALLEST_FRACTION:
        warn(
            f"about {100 * share:.2g}% of paths are truncated after {MAX_BOUNCES} bounces: "
            f"{missing}"
        )
    chains = moments.truncated()
    if chains > TOLERATED_CHAINS * len(moments.counts) * max(moments.count / LEAST_PASSES, 1.0):
        warn(
            f"{chains} pixel{'s show' if chains > 1 else ' shows'} more than {LONGEST_CHAIN} "
            "successive reflections, as between facing mirrors or in round glass of few triangles; "
            "the light at their ends is missing; give such glass vertex normals, or divide it "
            "more finely"
        )


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
