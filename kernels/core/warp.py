"""Uniform numbers turned into points and directions, each sampler beside its density."""

import math

from photonmap.kernels.core.jit import jit

INV_PI = 1.0 / math.pi
TINY = 1e-300
BELOW_ONE = 1.0 - 2.0**-53  # The largest uniform number
SINE = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
COSINE = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)


@jit
def cos_sin_2pi(v):
    """Return (cos 2πv, sin 2πv) for v in [0, 1), to 1e-15.

    By the polynomials of fdlibm's k_sin and k_cos, for an eighth of a turn to either side: the
    library's functions are called, not inlined, and take several times as long.
    """
    quarter = int(4.0 * v + 0.5)
    x = 2.0 * math.pi * (v - 0.25 * quarter)
    z = x * x
    sine = SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5]))
    sine = x + x * z * (SINE[0] + z * (SINE[1] + z * sine))
    cosine = COSINE[2] + z * (COSINE[3] + z * (COSINE[4] + z * COSINE[5]))
    cosine = 1.0 - 0.5 * z + z * z * (COSINE[0] + z * (COSINE[1] + z * cosine))
    turned, sign = float(quarter & 1), float(1 - (quarter & 2))
    kept = 1.0 - turned
    return sign * (kept * cosine - turned * sine), sign * (kept * sine + turned * cosine)


@jit
def cosine_hemisphere(u, v):
    """Return a direction around +z with density cos θ / π (per steradian)."""
    r, (x, y) = math.sqrt(u), cos_sin_2pi(v)
    return r * x, r * y, math.sqrt(1.0 - u)


@jit
def cosine_hemisphere_pdf(cosine):
    """Return the density of `cosine_hemisphere` where cos θ = cosine."""
    return max(cosine, 0.0) * INV_PI


@jit
def uniform_sphere(u, v):
    """Return a direction with density 1 / 4π (per steradian)."""
    z, (x, y) = 1.0 - 2.0 * u, cos_sin_2pi(v)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return r * x, r * y, z


@jit
def uniform_sphere_pdf():
    """Return the density of `uniform_sphere`."""
    return 0.25 * INV_PI


@jit
def uniform_cone(u, v, cosine):
    """Return a direction around +z with cos θ >= cosine, uniform by solid angle."""
    z, (x, y) = 1.0 - u * (1.0 - cosine), cos_sin_2pi(v)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return r * x, r * y, z


@jit
def uniform_cone_pdf(cosine):
    """Return the density of `uniform_cone` (per steradian)."""
    return 0.5 * INV_PI / (1.0 - cosine)


@jit
def uniform_disk(u, v):
    """Return a point of the unit disk with density 1 / π (per area)."""
    r, (x, y) = math.sqrt(u), cos_sin_2pi(v)
    return r * x, r * y


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
def discrete(cdf, u):
    """Return an index with density (cumulative[i] - cumulative[i - 1]), and u renewed in [0, 1).

    `cdf` rises to 1, or to any number below which u is; entries of density 0 are never returned.
    The search has no branch for the processor to guess.
    """
    i, count = 0, len(cdf)
    while count > 1:
        half = count // 2
        i += half * (cdf[i + half - 1] <= u)
        count -= half
    below = cdf[i - 1] if i > 0 else 0.0
    return i, min((u - below) / (cdf[i] - below), BELOW_ONE)


@jit
def discrete_pdf(cdf, i):
    """Return the probability of `discrete` to return i."""
    return cdf[i] - (cdf[i - 1] if i > 0 else 0.0)


@jit
def power_heuristic(a, b):
    """Weigh a strategy of density a against one of b (Veach 1997, 9.2.4)."""
    return a * a / (a * a + b * b) if a > 0.0 else 0.0
