"""Uniform numbers turned into points and directions, each sampler beside its density."""

import math

from photonmap.kernels.jit import jit

INV_PI = 1.0 / math.pi
TINY = 1e-300


@jit
def cosine_hemisphere(u, v):
    """Return a direction around +z with density cos θ / π (per steradian)."""
    r, phi = math.sqrt(u), 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi), math.sqrt(1.0 - u)


@jit
def cosine_hemisphere_pdf(cosine):
    """Return the density of `cosine_hemisphere` where cos θ = cosine."""
    return max(cosine, 0.0) * INV_PI


@jit
def uniform_sphere(u, v):
    """Return a direction with density 1 / 4π (per steradian)."""
    z, phi = 1.0 - 2.0 * u, 2.0 * math.pi * v
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return r * math.cos(phi), r * math.sin(phi), z


@jit
def uniform_sphere_pdf():
    """Return the density of `uniform_sphere`."""
    return 0.25 * INV_PI


@jit
def uniform_cone(u, v, cosine):
    """Return a direction around +z with cos θ >= cosine, uniform by solid angle."""
    z, phi = 1.0 - u * (1.0 - cosine), 2.0 * math.pi * v
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return r * math.cos(phi), r * math.sin(phi), z


@jit
def uniform_cone_pdf(cosine):
    """Return the density of `uniform_cone` (per steradian)."""
    return 0.5 * INV_PI / (1.0 - cosine)


@jit
def uniform_disk(u, v):
    """Return a point of the unit disk with density 1 / π (per area)."""
    r, phi = math.sqrt(u), 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi)


@jit
def uniform_disk_pdf():
    """Return the density of `uniform_disk`."""
    return INV_PI


@jit
def uniform_triangle(u, v):
    """Return barycentrics (b1, b2), uniform by area (Heitz 2019, keeps strata compact)."""
    if v > u:
        u *= 0.5
        v -= u
    else:
        v *= 0.5
        u -= v
    return u, v


@jit
def uniform_triangle_pdf(area):
    """Return the density of `uniform_triangle` (per area)."""
    return 1.0 / area


@jit
def linear(u, a, b):
    """Return x in [0, 1) with density 2 (a + x (b - a)) / (a + b), a, b >= 0, not both 0."""
    return u * (a + b) / max(a + math.sqrt(a * a + u * (b * b - a * a)), TINY)


@jit
def linear_pdf(x, a, b):
    """Return the density of `linear`."""
    return 2.0 * (a + x * (b - a)) / (a + b)


@jit
def discrete(cumulative, u):
    """Return an index with density (cumulative[i] - cumulative[i - 1]), and u renewed in [0, 1).

    `cumulative` rises to 1; entries of density 0 are never returned.
    """
    i, end = 0, len(cumulative) - 1
    while i < end:
        middle = (i + end) // 2
        if cumulative[middle] > u:
            end = middle
        else:
            i = middle + 1
    below = cumulative[i - 1] if i > 0 else 0.0
    return i, min((u - below) / (cumulative[i] - below), 1.0 - 2.0**-53)


@jit
def discrete_pdf(cumulative, i):
    """Return the probability of `discrete` to return i."""
    return cumulative[i] - (cumulative[i - 1] if i > 0 else 0.0)
