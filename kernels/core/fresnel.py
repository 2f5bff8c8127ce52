"""Mirror directions, refraction and Fresnel's equations at a smooth surface.

Lobes reflect by F(μ) = F₀ + (1 - F₀) r(μ), in which r rises from 0 at normal incidence: `rise`. For
dielectrics it is what Fresnel's equations say, else Schlick's r = (1 - μ)⁵, for metals less a dip
before grazing angles,

    F(μ) = F₀ + (1 - F₀) (1 - μ)⁵ - a μ (1 - μ)⁶,

in which `a` makes F what it is for the metal's complex index at μ = 1/7, an angle of 82° (C. Kutz,
M. Hašan and M. Edmondson, "Novel aspects of the Adobe Standard Material", 2023).
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
def dip_term(cosine):
    """Return what the dip of metals is multiplied by."""
    return min(cosine, 1.0) * (1.0 - min(cosine, 1.0)) ** 6


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
