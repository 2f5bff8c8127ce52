"""Mirror directions, refraction and Fresnel's equations at a smooth surface.

Lobes reflect by F(μ) = F₀ + (1 - F₀) r(μ), in which r rises from 0 at normal incidence: `rise`. For
dielectrics it is what Fresnel's equations say, else Schlick's r = (1 - μ)⁵, for metals less a dip
before grazing angles,

    F(μ) = F₀ + (1 - F₀) (1 - μ)⁵ - μ (a₁ (1 - μ)² + a₂ (1 - μ)⁴ + a₃ (1 - μ)¹⁰ + a₄ (1 - μ)¹²),

whose weights are fitted to Fresnel's equations: `photonmap.scene.surfaces.conductors.fit_dip`. With
one power it would be the form of C. Kutz, M. Hašan and M. Edmondson, "Novel aspects of the Adobe
Standard Material", 2023.
"""

import math

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit


@jit
def mirrored(direction, normal):
    """Return the mirror image of a unit direction that arrives against `normal`."""
    return vec.sub(direction, vec.scale(normal, 2.0 * vec.dot(direction, normal)))


@jit
def refracted(direction, normal, eta):
    """Return the refraction of a unit direction that arrives against `normal` (Snell's law).

    `eta` is the index of the side it comes from over that of the other. Under total internal
    reflection, where there is none, the result lies in the surface.
    """
    cosine = -vec.dot(direction, normal)
    squared = max(0.0, 1.0 - eta * eta * (1.0 - cosine * cosine))
    along = vec.scale(direction, eta)
    return vec.add(along, vec.scale(normal, eta * cosine - math.sqrt(squared)))


@jit
def schlick_term(cosine):
    """Return what Schlick's formula multiplies 1 - F₀ by."""
    return (1.0 - min(cosine, 1.0)) ** 5


@jit
def dip_terms(cosine):
    """Return what the weights of the dip of metals are multiplied by: μ (1 - μ)ᵖ."""
    mu = min(cosine, 1.0)
    squared = (1.0 - mu) * (1.0 - mu)
    fourth = squared * squared
    tenth = fourth * fourth * squared
    return mu * squared, mu * fourth, mu * tenth, mu * tenth * squared


@jit
def dip_of(dip, terms, band):
    """Return how much less a metal reflects in a band than Schlick's formula says.

    `dip` is (table of weights, (M, 4, N), or (M, 0, 0) where no metal has a dip; its row), and
    `terms` are the four `dip_terms` or their means.
    """
    weights, material = dip
    if weights.shape[1] == 0:
        return 0.0
    return (
        weights[material, 0, band] * terms[0]
        + weights[material, 1, band] * terms[1]
        + weights[material, 2, band] * terms[2]
        + weights[material, 3, band] * terms[3]
    )


@jit
def fresnel(cosine, eta):
    """Return the reflectance of a dielectric for unpolarised light; 1 under total reflection.

    `cosine` is that of the angle of arrival, `eta` as in `refracted`.
    """
    squared = 1.0 - eta * eta * (1.0 - cosine * cosine)
    if squared <= 0.0:
        return 1.0
    inside = math.sqrt(squared)
    parallel = (cosine - eta * inside) / (cosine + eta * inside)
    perpendicular = (eta * cosine - inside) / (eta * cosine + inside)
    return 0.5 * (parallel * parallel + perpendicular * perpendicular)


@jit
def rise(cosine, index):
    """Return what 1 - F₀ is multiplied by, of a dielectric of this index; Schlick's term for 0."""
    if index == 0.0:
        return schlick_term(cosine)
    normal = (index - 1.0) * (index - 1.0) / ((index + 1.0) * (index + 1.0))
    return (fresnel(min(cosine, 1.0), 1.0 / index) - normal) / (1.0 - normal)
