"""What a gather ray sees via specular surfaces."""

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.absorption import absorb
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN, choose_lobe, draw_scattering
from photonmap.kernels.cache.radiosity_cache import cell_at
from photonmap.kernels.core.bands import add_product, total
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import FOUND, INDIRECT, SPECULAR
from photonmap.kernels.geometry.interaction import side_of, surface_interaction
from photonmap.kernels.integrators.cached_base import has_base, look_up_base
from photonmap.kernels.integrators.path_walk import follow_path
from photonmap.kernels.integrators.specular_chain import specular_step

# Numba leaves out a branch on None only where it is an argument of the function itself.


@jit
def _add_cell(scene, cache, hit, direction, scratch):
    """Add what the cache holds of a surface, times throughput; return whether it holds light."""
    side = side_of(scene.geometry, hit.triangle, direction)
    cell = cell_at(cache.cells, hit.triangle, side, hit.u, hit.v)
    add_product(scratch.irradiance, INDIRECT, cache.radiosity, cell, scratch.throughput, 1.0)
    return total(cache.radiosity, cell) > 0.0


@jit
def _add_surface(scene, specular, scattering, maps, hit, direction, state, scratch):
    """Add the light of a surface on the chain; return (whether the chain goes on, found, state)."""
    if scattering is None:
        return True, _add_cell(scene, maps.cache, hit, direction, scratch), state
    surface = surface_interaction(scene.geometry, hit, direction)
    surface = models.with_model(scene.geometry, scattering, surface)
    if surface.model == models.LAMBERTIAN:
        return True, _add_cell(scene, maps.cache, hit, direction, scratch), state
    probability = specular.probability[scene.geometry.material[hit.triangle]]
    is_specular, state = choose_lobe(probability, state, scratch.throughput)
    if is_specular:
        return True, False, state
    if has_base(scene.geometry, scattering, hit.triangle):
        lit, goes_on, surface, state = look_up_base(
            scene, scattering, maps.cache, surface, state, scratch
        )
        if not goes_on:
            return False, lit == FOUND, state
    return False, follow_path(scene, maps, surface, state, scratch) == FOUND, state


@outlined
def gather_specular_chain(scene, specular, maps, hit, direction, weight, state, scratch):
    """Add the light that a gather ray sees via specular surfaces, times weight.

    The cache answers for Lambertian surfaces and the bases of glossy ones; from others, a path goes
    on. Emitters seen so make caustics, which photons bring. Returns whether light was found.
    """
    if specular is None:
        return False
    throughput = scratch.throughput
    throughput[:] = weight
    absorb(scene.geometry, specular, hit, direction, False, throughput)
    found = False
    for step in range(LONGEST_CHAIN):
        if specular.kind[scene.geometry.material[hit.triangle]] == 0:
            return found
        numbers, state = draw_scattering(specular.alpha, state)
        alive, hit, direction, state = specular_step(
            scene, specular, (hit, direction), numbers, step, weight, state, throughput
        )
        if not alive:
            return found
        scratch.rays[SPECULAR] += 1
        if hit.triangle < 0 or len(maps.cache.cells.divisions) == 0:
            return found
        alive, lit, state = _add_surface(
            scene, specular, scene.scattering, maps, hit, direction, state, scratch
        )
        found |= lit
        if not alive:
            return found
    return found
