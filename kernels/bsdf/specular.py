"""Specular surfaces: mirrors, diffuse surfaces with a mirror coat, glass, and nearly smooth metal.

Smooth thin glass reflects as a mirror what it does not let pass: see `geometry.pane`.

Glass may be rough. `Specular.alpha` has no rows in a scene where all is smooth.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import microsurface
from photonmap.kernels.bsdf.dispersion import choose_index, index_ratio, keep_index, reflects
from photonmap.kernels.bsdf.facets import from_local, to_local
from photonmap.kernels.bsdf.glass import (
    absorb,
    multiply_remainder,
    multiply_tint,
    roughness_at,
    take_glass_fraction,
)
from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import divide, largest
from photonmap.kernels.core.fresnel import (
    dip_of,
    dip_terms,
    fresnel,
    mirrored,
    refracted,
    schlick_term,
)
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.records import GLASS, MIRROR
from photonmap.kernels.core.rng import draw, draw_three, russian_roulette, stream
from photonmap.kernels.geometry.interaction import offset, point_at, shading_normal, side_of
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.geometry.pane import clear_at, is_reflected

LONGEST_CHAIN = 256  # Specular scatterings in a row, after which a path is truncated
CERTAIN_STEPS = 4  # Specular scatterings of a chain before Russian roulette begins
BITS = float(1 << 53)  # Of a uniform number


class Arrival(NamedTuple):
    """How light meets a specular surface."""

    triangle: int
    direction: tuple  # unit vector along which it arrives
    side: int  # 0 at the front of the triangle, 1 at its back
    ng: tuple  # geometric normal on that side
    n: tuple  # shading normal, or ng where light arrives from below it


@jit
def specular_probability(scene, triangle):
    """Return the probability of the specular lobe; 1 for a surface that has no other."""
    if scene.specular is None:
        return 0.0
    return scene.specular.probability[scene.geometry.material[triangle]]


@jit
def choose_lobe(probability, state, throughput):
    """Choose the specular lobe or not, and divide throughput by its probability: (which, state)."""
    if probability >= 1.0:
        return True, state
    xi, state = draw(state)
    is_specular = xi < probability
    divide(throughput, probability if is_specular else 1.0 - probability)
    return is_specular, state


@jit
def _multiply_by_mirror(specular, material, cosine, throughput):
    """Multiply throughput, (N,), by what a mirror reflects of light of this cosine."""
    if len(specular.grazing) == 0:
        for band in range(len(throughput)):
            throughput[band] *= specular.mirror[material, band]
        return
    rise, terms = np.float32(schlick_term(cosine)), dip_terms(cosine)
    dip = specular.dip, material
    for band in range(len(throughput)):
        reflected = specular.mirror[material, band] + rise * specular.grazing[material, band]
        throughput[band] *= reflected - np.float32(dip_of(dip, terms, band))


@jit
def arrive_at(geometry, hit, direction):
    """Return the `Arrival` of a ray."""
    direction = vec.normalize(direction)
    side = side_of(geometry, hit.triangle, direction)
    ng = vec.scale(vec.row(geometry.normals, hit.triangle), 1.0 - 2.0 * side)
    n = shading_normal(geometry, hit, ng, side)
    if vec.dot(n, direction) >= 0.0:
        n = ng
    return Arrival(hit.triangle, direction, side, ng, n)


@jit
def reflected_share(scene, hit, direction):
    """Return what smooth glass reflects of a ray, in one band; 1 of any other surface."""
    material = scene.geometry.material[hit.triangle]
    if scene.specular.kind[material] != GLASS:
        return 1.0
    arrival = arrive_at(scene.geometry, hit, direction)
    cosine = -vec.dot(arrival.n, arrival.direction)
    return fresnel(cosine, index_ratio(scene.specular, material, arrival, 0))


@jit
def draw_scattering(alpha, state):
    """Draw the uniform numbers of `scatter_specular`: the first alone where all is smooth."""
    if len(alpha) == 0:
        xi, state = draw(state)
        return (xi, 0.0, 0.0), state
    return draw_three(state)


@outlined
def scatter_specular(scene, hit, direction, numbers, carries_flux, throughput):
    """Scatter light that arrives along `direction` at a specular surface: a BSDF's `sample`.

    Glass reflects where the first of three uniform `numbers` is below Fresnel's reflectance, and
    transmits elsewhere; the others choose the facet of a rough surface at which light begins a walk
    among facets. `throughput`, (N,), is multiplied by the mirror's reflectance or the glass's tint,
    and by the square of the ratio of indices unless it is flux (Veach 1997, 5.2). Returns (origin,
    unit direction).
    """
    geometry, specular = scene.geometry, scene.specular
    material = geometry.material[hit.triangle]
    arrival = arrive_at(geometry, hit, direction)
    direction, ng, n = arrival.direction, arrival.ng, arrival.n
    xi = numbers[0]
    point, size = point_at(geometry, hit.triangle, hit.u, hit.v)
    take_glass_fraction(geometry, specular.glass, hit, throughput)
    if _crosses_pane(scene, hit, arrival, xi, throughput):
        return offset(point, size, vec.scale(ng, -1.0)), direction
    if specular.kind[material] == MIRROR:
        cosine = -vec.dot(n, direction)
        _multiply_by_mirror(specular, material, cosine, throughput)
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    rough, crossed, out = _scatter_rough(scene, hit, arrival, numbers, carries_flux, throughput)
    if rough:
        return offset(point, size, vec.scale(ng, -1.0) if crossed else ng), out
    cosine = -vec.dot(n, direction)
    is_reflected, eta = reflects(specular, material, arrival, cosine, xi, throughput)
    if is_reflected:
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    factor = 1.0 if carries_flux else eta * eta
    multiply_tint(scene, hit, factor, throughput)
    transmitted = refracted(direction, n, eta)
    if vec.dot(transmitted, ng) >= 0.0:
        transmitted = refracted(direction, ng, eta)
    return offset(point, size, vec.scale(ng, -1.0)), transmitted


@jit
def _crosses_pane(scene, hit, arrival, xi, throughput):
    """Return whether light that a pane stopped goes straight on, in the colour of the glass."""
    if scene.geometry.alpha is None:
        return False
    panes, material = scene.geometry.alpha.panes, scene.geometry.material[hit.triangle]
    if panes is None or panes.ior[material] == 0.0:
        return False
    clear = clear_at(scene.geometry, panes, hit)
    if is_reflected(panes, material, clear, vec.dot(arrival.ng, arrival.direction), xi):
        return False
    multiply_remainder(scene, hit, clear, throughput)
    return True


@jit
def _on_side(out, direction, ng):
    """Return a reflected direction, about the geometric normal if it would enter the surface."""
    return out if vec.dot(out, ng) > 0.0 else mirrored(direction, ng)


@jit
def metal_of(specular, material):
    """Return what a METAL reflects, as `microsurface.scatter` takes it."""
    return specular.mirror[material], (specular.dip, material)


@jit
def _scatter_rough(scene, hit, arrival, numbers, carries_flux, throughput):
    """Scatter at a rough surface, as `scatter_specular`: (whether it is one, crossed, wo)."""
    specular = scene.specular
    direction, ng, n = arrival.direction, arrival.ng, arrival.n
    material = scene.geometry.material[hit.triangle]
    if len(specular.alpha) == 0 or specular.alpha[material] == 0.0:
        return False, False, direction
    xi, u, v = numbers
    column, probability, own = choose_index(specular.media, arrival, throughput, xi)
    keep_index(specular.media, arrival, (column, probability), throughput)
    eta = index_ratio(specular, material, arrival, column)
    rough = roughness_at(scene, hit)
    wi = to_local(rough, vec.scale(direction, -1.0), n)
    state = stream(np.uint64(xi * BITS), np.uint64(u * BITS), np.uint64(v * BITS))
    metal = metal_of(specular, material)
    wo, crossed, state = microsurface.scatter(
        (specular.anisotropy, rough.along, rough.alpha),
        eta,
        metal,
        wi,
        (own, u, v),
        state,
        throughput,
    )
    if crossed:
        factor = 1.0 if carries_flux else microsurface.radiance_factor(eta)
        multiply_tint(scene, hit, factor, throughput)
    out = vec.normalize(from_local(rough, wo, n))
    if (vec.dot(out, ng) < 0.0) != crossed:
        out = mirrored(out, ng)
    return True, crossed, out


@jit
def is_folded(out, arrival, crossed):
    """Return whether rough surfaces send light along `out` also by mirroring it.

    That is where shading normals lean so far that it would leave on the wrong side.
    """
    toward = vec.dot(mirrored(out, arrival.ng), arrival.n)
    return toward < 0.0 if crossed else toward > 0.0


@outlined
def specular_step(scene, met, numbers, step, before, state, carries_flux, throughput):
    """Scatter at a specular surface, and go on to the next hit: the one step of every chain.

    `met` is (hit, direction) there, `numbers` and `carries_flux` are those of `scatter_specular`.
    From `CERTAIN_STEPS` on, Russian roulette is played against the throughput `before` the chain.
    Returns (whether the path goes on, hit, direction, state).
    """
    hit, direction = met
    origin, direction = scatter_specular(scene, hit, direction, numbers, carries_flux, throughput)
    if step >= CERTAIN_STEPS:
        alive, state = russian_roulette(before, largest(throughput), state, throughput)
        if not alive:
            return False, hit, direction, state
    hit = intersect(scene.geometry, origin, direction)
    absorb(scene, hit, direction, True, throughput)
    return True, hit, direction, state
