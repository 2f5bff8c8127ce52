"""How much light rough and coated surfaces reflect, in Mitsuba and here.

Mitsuba loses the light that the facets of a rough surface scatter twice, and the base of its
principled surface gets all light, also what the coat reflects. Here no light is lost, a coat takes
what it reflects from its base, and light that the base reflects meets the coat again. Surfaces are
given the reflectance with which they reflect as much light from all around as in Mitsuba.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from photonmap.kernels.core.metals import DIP_MEANS, DIP_POWERS
from photonmap.scene.surfaces.conductors import fit_dip
from photonmap.scene.surfaces.fresnel import (
    SCHLICK_MEAN,
    lobe_index,
    mean_rise,
    normal_reflectance,
    rise,
)
from photonmap.spectra.curves import Floats

_TERMS: tuple[Callable[[Floats], Floats], ...] = (
    np.ones_like,
    lambda cosines: (1.0 - cosines) ** 5,
    *(partial(lambda power, cosines: cosines * (1.0 - cosines) ** power, p) for p in DIP_POWERS),
)
"""Fresnel terms of metals: see `kernels.core.fresnel`."""
_STEPS = 16  # Towards a reflectance
_NODES = 48  # Directions, and facets in each of two dimensions, over which means are taken


def mean_reflectance(normal: Any) -> Any:
    """Return what a coat reflects of light from all around; by Schlick's formula if coloured."""
    index = lobe_index(float(normal)) if np.ndim(normal) == 0 else 0.0
    return normal + (1.0 - normal) * mean_rise(index)


def coat_albedo(normal: float, alpha: float) -> float:
    """Return what a rough coat reflects of light from all around, here.

    alpha : its roughness, 0 for a smooth one
    """
    if alpha == 0.0:
        return float(mean_reflectance(normal))
    index = lobe_index(normal)
    single = _mean_reflected(alpha, np.ones_like, True)
    grazing = _mean_reflected(alpha, lambda cosines: rise(cosines, index), True)
    fresnel = mean_reflectance(normal)
    several = fresnel**2 * single / (1.0 - fresnel * (1.0 - single))
    return float(normal * (single - grazing) + grazing + (1.0 - single) * several)


def base_albedo(reflected: Any, outside: float, weight: float = 1.0) -> Any:
    """Return the albedo of a base that reflects a part of the light from all around by a coat.

    reflected : what the base returns of the light that meets the surface
    outside : `coat_albedo`
    weight : the fraction of the base that the coat covers
    """
    # With a coat, R = w (1 - E)² b / (1 - E b) + (1 - w) b: of two solutions the one below 1.
    bare = 1.0 - weight
    linear = weight * (1.0 - outside) ** 2 + bare + outside * reflected
    root = np.sqrt(np.maximum(linear**2 - 4.0 * bare * outside * reflected, 0.0))
    return np.minimum(2.0 * reflected / (linear + root), 1.0)


def plastic_albedo(
    index: float, alpha: float, nonlinear: bool, normal: float, weight: float = 1.0
) -> Callable[[Any], Any]:
    """Return the function from an albedo in Mitsuba's plastics to that of a base here.

    index : of refraction, of the coat
    nonlinear : whether Mitsuba adds the colours of what is reflected inwards
    normal, weight : of the simulated coat, reflectance at normal incidence, and what it covers
    """
    if alpha == 0.0:
        through = 1.0 - mean_reflectance(normal_reflectance(index))
        inside = 1.0 - through / index**2
    else:
        through = _mean_transmitted(alpha, index)
        inside = _mean_reflected(alpha, lambda cosines: _fresnel(cosines, 1.0 / index)[0])

    outside = coat_albedo(normal, alpha)

    def base(albedo: Any) -> Any:
        inwards = inside * albedo if nonlinear else inside
        return base_albedo(albedo / (1.0 - inwards) * (through / index) ** 2, outside, weight)

    return base


def metal_reflectance(alpha: float) -> Callable[..., Any]:
    """Return the function from what a metal reflects in Mitsuba to what it reflects here.

    It gives the reflectances of a metal that reflects as much light here, where light that is
    scattered several times between facets is not lost (`kernels.bsdf.glossy`): of a number, 0 at
    normal incidence or 1 at 82°, the factor, and both in Mitsuba, whose ratio stays.
    """
    lost, kept = (
        [_mean_reflected(alpha, term, correlated) for term in _TERMS]
        for correlated in (False, True)
    )

    def reflectance(which: int, factor: Any, normal: Any, edge: Any) -> Any:
        ratio = edge / np.maximum(normal, 1e-9)
        wanted = factor * _once(normal, fit_dip(normal, edge), lost)
        found = np.minimum(factor * normal, 1.0)
        for _ in range(_STEPS):
            dip = fit_dip(found, np.minimum(found * ratio, 1.0))
            mean = found + (1.0 - found) * SCHLICK_MEAN - np.tensordot(DIP_MEANS, dip, 1)
            several = (1.0 - kept[0]) * mean**2 * kept[0] / (1.0 - mean * (1.0 - kept[0]))
            found = np.minimum(found * wanted / (_once(found, dip, kept) + several), 1.0)
        return np.minimum(found * ratio, 1.0) if which else found

    return reflectance


def _once(normal: Floats, dip: Floats, terms: list[float]) -> Floats:
    """Return what metal reflects once, of what it reflects with each Fresnel term."""
    once = normal * (terms[0] - terms[1]) + terms[1]
    return np.asarray(once - np.tensordot(terms[2:], dip, 1))


class _Facets(NamedTuple):
    """Facets that are seen in light from all around."""

    share: Floats  # of all light that meets the surface
    cosine: Floats  # of the light's direction
    towards: Floats  # cosine between that and the facet's normal
    height: Floats  # cosine of the facet's normal


@lru_cache(maxsize=8)
def _facets(alpha: float) -> _Facets:
    """Return GGX's facets, as often as they are seen: Dupuy and Benyoub 2023."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    u, v = (np.mgrid[0:_NODES, 0:_NODES].reshape(2, 1, -1) + 0.5) / _NODES
    cosine = 0.5 * (nodes[:, None] + 1.0)
    sine = np.sqrt(1.0 - cosine**2)
    length = np.hypot(alpha * sine, cosine)
    x, z = alpha * sine / length, cosine / length
    up = (1.0 - v) * (1.0 + z) - z
    across = np.sqrt(np.maximum(1.0 - up**2, 0.0))
    azimuth = 2.0 * np.pi * u
    along, aside = alpha * (across * np.cos(azimuth) + x), alpha * across * np.sin(azimuth)
    length = np.sqrt(along**2 + aside**2 + (up + z) ** 2)
    height = (up + z) / length
    towards = sine * along / length + cosine * height
    share = np.broadcast_to(cosine * weights[:, None] / _NODES**2, height.shape)
    return _Facets(share, np.broadcast_to(cosine, height.shape), towards, height)


def _mean_reflected(
    alpha: float, fresnel: Callable[[Floats], Floats], correlated: bool = False
) -> float:
    """Return what facets of a reflectance reflect of light from all around, scattered once.

    In Mitsuba they mask each other in both directions independently, here in correlation.
    """
    share, cosine, towards, height = _facets(alpha)
    out = 2.0 * towards * height - cosine
    masking = _masking(alpha, out)
    if correlated:
        seen = _masking(alpha, cosine)
        masking = masking / np.maximum(seen + masking - seen * masking, 1e-12)
    return float((share * fresnel(towards) * masking).sum())


def _mean_transmitted(alpha: float, index: float) -> float:
    """Return what an interface transmits of light from all around, refracted once."""
    share, cosine, towards, height = _facets(alpha)
    fresnel, refracted = _fresnel(towards, index)
    out = cosine / index - (towards / index - refracted) * height
    return float((share * (1.0 - fresnel) * _masking(alpha, out)).sum())


def _fresnel(cosines: Floats, index: float) -> tuple[Floats, Floats]:
    """Return the reflectance and the cosine of what is refracted; 1 and 0 for total reflection."""
    squared = 1.0 - (1.0 - cosines**2) / index**2
    refracted = np.sqrt(np.maximum(squared, 0.0))
    across = (cosines - index * refracted) / (cosines + index * refracted)
    parallel = (index * cosines - refracted) / (index * cosines + refracted)
    return np.where(squared > 0.0, 0.5 * (across**2 + parallel**2), 1.0), refracted


def _masking(alpha: float, cosines: Floats) -> Floats:
    """Return Smith's masking, 0 below the surface."""
    above = np.maximum(cosines, 1e-6)
    tangents = alpha**2 * (1.0 / above**2 - 1.0)
    return np.where(cosines > 0.0, 2.0 / (1.0 + np.sqrt(1.0 + tangents)), 0.0)
