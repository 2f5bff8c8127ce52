"""White surfaces of the models that covers may lie over: where they send light, and what passes.

A row of a base has where light from one of NODES angles goes, by the angle of leaving; it adds up
to 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from photonmap.compile.surfaces import glossy
from photonmap.compile.table_cache import kept_on_disk
from photonmap.kernels.bsdf.rough_diffuse import DARKENING
from photonmap.scene.surfaces.fresnel import mean_rise, rise
from photonmap.spectra.curves import Floats

ROUNDS = 60  # of the iteration, which gains a digit in about six


def through(passed: Floats, base: Floats) -> Floats:
    """Return T(θ) of a cover over a white base, (NODES + 1,), the last column unused.

    It solves T · ∫ f T cos dω = 1 - E for the BSDF f of the base, (NODES, NODES), and the cover's
    albedo E(θ), of which `passed` is 1 - E, by the symmetric scaling of Sinkhorn and Knopp.
    """
    result = np.sqrt(passed)
    for _ in range(ROUNDS):
        result = np.sqrt(result * passed / (base @ result))
    return np.append(result, 0.0)


def evenly(missing: Floats) -> Floats:
    """Return where light goes that leaves by missing(i) · missing(o), of which so much goes."""
    nodes = np.linspace(0.0, 1.0, glossy.NODES)
    spread = missing * nodes**3  # of 2 μ dμ = 4 t³ dt, for μ = t²
    spread[-1] *= 0.5
    return np.asarray(missing[:, None] * (spread / max(spread.sum(), 1e-300)))


def whole_albedos(alpha: float, f0: float, index: float) -> Floats:
    """Return what a lobe reflects of light from each node's angle, (NODES,)."""
    single, grazing = glossy.lobe_albedos(alpha, index)[:2]
    several = glossy.multiple_fresnel(f0, single[-1], mean_rise(index))
    whole = glossy.lobe_albedo(single, grazing, f0, several)
    return np.asarray(whole[:-1])


def _white_clay(roughness: float) -> Floats:
    """Return where rough diffuse white sends light.

    Over azimuths, the mean of what `kernels.bsdf.rough_diffuse` adds to Lambert's law is
    sin(i) sin(o) / π · (1 / max(cos(i), cos(o)) - 1); what is missing leaves evenly.
    """
    cosines = glossy.node_cosines()
    sines = np.sqrt(1.0 - cosines**2)
    more = np.outer(sines, sines) / np.pi * (1.0 / np.maximum.outer(cosines, cosines) - 1.0)
    level = 1.0 / (1.0 + DARKENING * roughness)
    once = evenly(np.ones(glossy.NODES)) * level * (1.0 + roughness * more)
    return np.asarray(once + evenly(np.maximum(1.0 - once.sum(axis=1), 0.0)))


@kept_on_disk
def _white_gloss(alpha: float, f0: float, index: float) -> Floats:
    """Return where a glossy lobe of F₀ over diffuse white sends light."""
    single, grazing = glossy.lobe_albedos(alpha, index)[:2]
    once = np.array(
        [_once((alpha, index), f0, cosine) for cosine in glossy.node_cosines().tolist()]
    )
    once *= ((f0 * (single - grazing) + grazing)[:-1] / once.sum(axis=1))[:, None]
    several = glossy.multiple_fresnel(f0, single[-1], mean_rise(index)) * evenly(1.0 - single[:-1])
    diffuse = 0.0 if f0 == 1.0 else evenly(1.0 - whole_albedos(alpha, f0, index))
    return np.asarray(once + several + diffuse)


def _once(lobe: tuple[float, float], f0: float, cosine: float) -> Floats:
    """Return what a lobe reflects once of light of this cosine, by that of leaving, (NODES,)."""
    alpha, index = lobe
    weight, beside, out = glossy.reflections(alpha, alpha, 0.0, cosine, glossy.GRID)
    weight = weight * (f0 + (1.0 - f0) * rise(beside, index))
    places = np.sqrt(np.clip(out, 0.0, 1.0)).ravel() * (glossy.NODES - 1)
    lower = np.minimum(places.astype(int), glossy.NODES - 2)
    share = places - lower
    low = np.bincount(lower, weight.ravel() * (1.0 - share), glossy.NODES)
    return (
        np.asarray(low + np.bincount(lower + 1, weight.ravel() * share, glossy.NODES)) / weight.size
    )


WHITE_BASES: dict[str, Callable[..., Floats]] = {
    "Lambertian": lambda: evenly(np.ones(glossy.NODES)),
    "rough diffuse": _white_clay,
    "glossy": _white_gloss,
}
"""By the names of models, of what describes their white surface; covers are refused over others"""
