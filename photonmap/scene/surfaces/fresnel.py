"""How lobes reflect more at grazing angles: F(μ) = F₀ + (1 - F₀) r(μ), by the `rise` r.

The kernels' own is `kernels.core.fresnel.rise`.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from photonmap.spectra.curves import Floats, read_only
from photonmap.spectra.metals import conductor_reflectance

SCHLICK_MEAN = 1.0 / 21.0  # Cosine-weighted mean of (1 - cos)⁵
LARGEST_INDEX = 3.0
"""of refraction, of lobes that are taken for those of dielectrics: there are no such metals"""
_NODES = 64


def normal_reflectance(index: float) -> float:
    """Return what a surface of this index of refraction reflects at normal incidence."""
    return ((index - 1.0) / (index + 1.0)) ** 2


def lobe_index(normal: float) -> float:
    """Return the index of refraction of a colourless lobe by its reflectance at normal incidence.

    More than dielectrics reflect is 0, for Schlick's formula.
    """
    root = math.sqrt(normal)
    index = (1.0 + root) / max(1.0 - root, 1e-9)
    return round(index, 6) if index <= LARGEST_INDEX else 0.0


def rise(cosines: Floats, index: float) -> Floats:
    """Return r at cosines of any shape, of a dielectric of an index; Schlick's (1 - cos)⁵ for 0."""
    cosines = np.minimum(cosines, 1.0)
    if index == 0.0:
        return np.asarray((1.0 - cosines) ** 5)
    normal = normal_reflectance(index)
    return np.asarray((conductor_reflectance(index, 0.0, cosines) - normal) / (1.0 - normal))


@cache
def mean_rise(index: float) -> float:
    """Return the cosine-weighted mean of `rise`."""
    if index == 0.0:
        return SCHLICK_MEAN
    cosines, shares = even_light(_NODES)
    return float(rise(cosines, index) @ shares)


@cache
def even_light(count: int) -> tuple[Floats, Floats]:
    """Return cosines, (count,), and the share that each has of light from all around: quadrature.

    They are denser at grazing angles: Gauss and Legendre's for the cosine's square root.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    roots = 0.5 * (nodes + 1.0)  # mean over μ = t² of 2 μ dμ = 4 t³ dt
    return read_only(roots**2), read_only(2.0 * weights * roots**3)
