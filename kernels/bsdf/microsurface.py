"""Rough metal and glass: light that wanders between the facets of a GGX microsurface.

A walk from facet to facet, on one side of the surface or the other, until it gets away (E. Heitz,
J. Hanika, E. d'Eon and C. Dachsbacher, "Multiple-scattering microfacet BSDFs with the Smith model",
2016): no light is lost, however often it is scattered. The facets are Trowbridge and Reitz', chosen
among those that the light sees; metal reflects there by Schlick's formula less a dip (see
`core.fresnel`), glass by Fresnel's equations.

All directions are unit vectors in the frame whose third axis is the normal: wi to where the light
comes from, above the surface, and wo to where it goes, above or below. `eta` is the index of the
side of wi over that of the other, or `METAL`, or minus the index of a thin pane: each facet of one
reflects as both sides of a smooth pane do together, and sends the rest to the other side as the
mirror image of that. `alpha` is GGX's α along the first axis and along the second, after what is
None in a scene whose facets are alike in all directions: then the second stands for both. A height
is given as the fraction of the surface below it, on which alone the walk depends: 1 at the top.
Inside, everything is turned upside down.
"""

import math

from photonmap.kernels.bsdf.facets import visible_normal
from photonmap.kernels.core import vec
from photonmap.kernels.core.fresnel import dip_of, dip_terms, fresnel, mirrored, refracted
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.rng import draw, draw_three
from photonmap.kernels.core.warp import INV_PI, power_heuristic
from photonmap.kernels.geometry.pane import pane_reflectance

METAL = 0.0  # In place of an index: nothing is transmitted
LONGEST_WALK = 256  # Facets after which light leaves as it goes
SPREAD = 0.3  # About what is scattered more than once, over α²
TINY = 1e-30
STRAIGHT = 1e60  # In place of a density that is not a function; its square is a number


@jit
def _spread(uneven, along, across, w):
    """Return the square of what w has along the surface, times that of α in its azimuth."""
    if uneven is None:
        return across * across * (w[0] * w[0] + w[1] * w[1])
    x, y = along * w[0], across * w[1]
    return x * x + y * y


@jit
def _smith(alpha, w):
    """Return Smith's Λ; below the horizon it is -1 at most."""
    z = w[2]
    root = math.sqrt(1.0 + _spread(alpha[0], alpha[1], alpha[2], w) / max(z * z, TINY))
    return 0.5 * (math.copysign(root, z) - 1.0)


@jit
def _projected_area(alpha, w):
    """Return the area of the facets that w sees, projected along w, over that of the surface."""
    z = w[2]
    return 0.5 * (z + math.sqrt(z * z + _spread(alpha[0], alpha[1], alpha[2], w)))


@jit
def _distribution(uneven, along, across, h):
    """Return the density of facet normals (per steradian)."""
    if uneven is None:
        spread = h[0] * h[0] + h[1] * h[1] + across * across * h[2] * h[2]
        return across * across * INV_PI / (spread * spread)
    x, y, z = h[0] / along, h[1] / across, h[2]
    spread = x * x + y * y + z * z
    return INV_PI / (along * across * spread * spread)


@jit
def _density_of(alpha, h):
    return _distribution(alpha[0], alpha[1], alpha[2], h)


@jit
def _next_height(alpha, w, height, u):
    """Return the height at which light along w meets the next facet, more than 1 if it meets none.

    The free path of Heitz et al., 4.2.
    """
    shadowing = _smith(alpha, w)
    left = 1.0 - u
    if w[2] <= 0.0:
        return height * left ** (-1.0 / shadowing)
    if shadowing == 0.0 or left <= height**shadowing:
        return 2.0
    return min(height / left ** (1.0 / shadowing), 1.0)


@jit
def _upside_down(w):
    return w[0], w[1], -w[2]


@jit
def _upwards(eta, w):
    """Return a direction, or where it goes through a pane, that of which it is the mirror image."""
    return (w[0], w[1], abs(w[2])) if eta < 0.0 else w


@jit
def _reflectance(eta, cosine):
    """Return what a facet of glass reflects, or of a pane."""
    return pane_reflectance(-eta, cosine) if eta < 0.0 else fresnel(cosine, eta)


@jit
def radiance_factor(eta):
    """Return by what radiance is multiplied that is transmitted (Veach 1997, 5.2)."""
    return eta * eta if eta > 0.0 else 1.0


@jit
def _metallic(f0, dip, cosine, band):
    value = f0[band] + (1.0 - f0[band]) * (1.0 - min(cosine, 1.0)) ** 5
    return value - dip_of(dip, dip_terms(cosine), band)


@jit
def _scatter_at_facet(alpha, eta, metal, w, numbers, throughput):
    """Scatter light along w at a facet; return (direction, whether it is transmitted)."""
    # `throughput`, (N,), is multiplied by what metal reflects. Of the uniform `numbers`, the first
    # chooses between reflection and transmission, the others the facet.
    xi, u, v = numbers
    h = visible_normal(alpha[1], alpha[2], vec.scale(w, -1.0), u, v)
    cosine = -vec.dot(w, h)
    if eta == METAL:
        for band in range(len(throughput)):
            throughput[band] *= _metallic(metal[0], metal[1], cosine, band)
        return vec.normalize(mirrored(w, h)), False
    reflects = xi < _reflectance(eta, cosine)
    if reflects or eta < 0.0:
        return vec.normalize(mirrored(w, h)), not reflects
    return vec.normalize(refracted(w, h, eta)), True


@outlined
def scatter(alpha, eta, metal, wi, numbers, state, throughput):
    """Scatter light that comes from wi; return (wo, whether it is transmitted, state).

    `throughput`, (N,), is multiplied by what `metal` reflects: (reflectance at normal incidence,
    (N,), dip as `dip_of` takes it). The three uniform `numbers` are those of
    the first facet, `state` gives the rest.
    """
    w, height, crossed = vec.scale(wi, -1.0), 1.0, False
    for _ in range(LONGEST_WALK):
        u, state = draw(state)
        height = _next_height(alpha, w, height, u)
        if height > 1.0:
            break
        w, through = _scatter_at_facet(alpha, eta, metal, w, numbers, throughput)
        numbers, state = draw_three(state)
        if through:
            crossed = not crossed
            if eta > 0.0:
                w, height, eta = _upside_down(w), 1.0 - height, 1.0 / eta
    w = (w[0], w[1], abs(w[2]))
    return (_upside_down(w) if crossed else w), crossed, state


@jit
def _half_vector(eta, wi, wo):
    """Return the normal of the facet that scatters wi into wo, and whether there is one."""
    wo = _upwards(eta, wo)
    h = vec.add(wi, wo) if wo[2] > 0.0 else vec.add(vec.scale(wi, eta), wo)
    squared = vec.dot(h, h)
    if squared < TINY:
        return h, False
    h = vec.scale(h, math.copysign(1.0 / math.sqrt(squared), h[2]))
    exists = vec.dot(wi, h) > 0.0 and vec.dot(wo, h) * wo[2] > 0.0
    return h, exists and (wo[2] > 0.0 or eta != METAL)


@jit
def _facet_density(alpha, eta, wi, wo, h):
    """Return the density of wo (per steradian) after one facet; of metal without its reflectance.

    B. Walter et al., "Microfacet models for refraction through rough surfaces", 2007.
    """
    along, beyond = vec.dot(wi, h), vec.dot(wo, h)
    density = _density_of(alpha, h) / max(_projected_area(alpha, wi), TINY)
    reflectance = 1.0 if eta == METAL else _reflectance(eta, along)
    if wo[2] > 0.0:
        return 0.25 * reflectance * density
    if eta < 0.0:
        return 0.25 * (1.0 - reflectance) * density
    return (1.0 - reflectance) * density * along * -beyond / (eta * along + beyond) ** 2


@jit
def single(alpha, eta, wi, wo):
    """Return the density of wo (per steradian) after one facet alone, and the cosine there.

    It is BSDF · cosine for light that carries flux from wi; of metal without its reflectance.
    """
    if wi[2] <= 0.0 or wo[2] == 0.0:
        return 0.0, 1.0
    h, exists = _half_vector(eta, wi, wo)
    if not exists:
        return 0.0, 1.0
    from_there = _smith(alpha, wi)
    if wo[2] > 0.0 or eta < 0.0:
        seen = (1.0 + from_there) / (1.0 + from_there + _smith(alpha, _upwards(eta, wo)))
    else:
        to_there = _smith(alpha, _upside_down(wo))
        seen = math.lgamma(2.0 + from_there) + math.lgamma(1.0 + to_there)
        seen = math.exp(seen - math.lgamma(2.0 + from_there + to_there))
    return seen * _facet_density(alpha, eta, wi, wo, h), vec.dot(wi, h)


@jit
def _typical_multiple(uneven, alpha, eta, wi, wo):
    """Return about the density of wo (per steradian) after several facets."""
    # Where these are smooth along an axis, they leave what light carries along it, times the index,
    # as it is: it stays near a cone about the axis.
    along, across = alpha[1], alpha[2]
    if uneven is None:
        return SPREAD * across * across * INV_PI * abs(wo[2])
    index = eta if eta > 0.0 and wo[2] < 0.0 else 1.0
    off = wo[1] + index * wi[1] if across < along else wo[0] + index * wi[0]
    wide, narrow = max(along, across), min(along, across)
    return 0.5 * SPREAD * wide * wide * INV_PI * narrow**2 / (narrow**2 + off * off) ** 1.5


@outlined
def typical_pdf(alpha, eta, wi, wo):
    """Return about the density of `scatter` (per steradian), for MIS; `STRAIGHT` for one index."""
    if eta == 1.0:
        return STRAIGHT
    if wo[2] < 0.0 and eta == METAL:
        return 0.0
    return single(alpha, eta, wi, wo)[0] + _typical_multiple(alpha[0], alpha, eta, wi, wo)


@jit
def _add(values, weights, density, eta, metal, cosine):
    for band in range(len(values)):
        reflectance = _metallic(metal[0], metal[1], cosine, band) if eta == METAL else 1.0
        values[band] += density * reflectance * weights[band]


@jit
def _choose_end(eta, pair, state):
    """Choose the end where a walk begins; return (wi, wo, factor of what it finds, state)."""
    # On metal it may first at either: a facet that is rarely found is best the last one, which is
    # not sampled but evaluated. The factor is that of reciprocity, over the probability.
    wi, wo = pair
    if eta != METAL:
        return wi, wo, 1.0, state
    xi, state = draw(state)
    if xi < 0.5 or wo[2] <= 0.0:
        return wi, wo, 2.0, state
    return wo, wi, 2.0 * wo[2] / wi[2], state


@jit
def _weigh_ends(alpha, eta, first, last):
    """Return the weight of a walk on metal against its reverse, by MIS; 1 on glass."""
    # `first` and `last` are the normals of its facets.
    if eta != METAL:
        return 1.0
    return power_heuristic(_density_of(alpha, first), _density_of(alpha, last))


@outlined
def evaluate(alpha, eta, metal, pair, state, weights, values):
    """Fill values, (N,), with the density of wo (per steradian); `pair` is (wi, wo).

    Its mean is exact: after one facet by `single`, after more by a walk from one of the two, each
    facet of which might scatter into the other. `weights`, (N,), is scratch. Returns the random
    state.
    """
    values[:] = 0.0
    weights[:] = 1.0
    density, cosine = single(alpha, eta, pair[0], pair[1])
    _add(values, weights, density, eta, metal, cosine)
    wi, wo, factor, state = _choose_end(eta, pair, state)
    w, height, first = vec.scale(wi, -1.0), 1.0, wi
    for order in range(LONGEST_WALK):
        u, state = draw(state)
        height = _next_height(alpha, w, height, u)
        if height > 1.0:
            break
        h, exists = _half_vector(eta, vec.scale(w, -1.0), wo)
        if order > 0 and exists:
            back = vec.scale(w, -1.0)
            density = _facet_density(alpha, eta, back, wo, h)
            above = wo[2] > 0.0 or eta < 0.0
            away = wo if wo[2] > 0.0 else _upside_down(wo)
            # the probability to get away without meeting another facet
            density *= (height if above else 1.0 - height) ** _smith(alpha, away)
            density *= factor * _weigh_ends(alpha, eta, first, h)
            _add(values, weights, density, eta, metal, vec.dot(back, h))
        numbers, state = draw_three(state)
        w, through = _scatter_at_facet(alpha, eta, metal, w, numbers, weights)
        if order == 0:
            first = vec.normalize(vec.add(wi, w))
        if through:
            wo = _upside_down(wo)
            if eta > 0.0:
                w, height, eta = _upside_down(w), 1.0 - height, 1.0 / eta
    return state
