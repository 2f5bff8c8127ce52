"""Emitters: what they send, samples towards a point for direct light, and photons."""

import math

import numpy as np

from photonmap.kernels import surface, vec, warp
from photonmap.kernels.bands import add_mix, add_mix_product, add_product, add_row, mix
from photonmap.kernels.choice import chance_of, choose
from photonmap.kernels.environment import environment_pdf, radiance_at, sample_environment
from photonmap.kernels.jit import jit
from photonmap.kernels.lamp import look_at, sample_lamp
from photonmap.kernels.opaque import blocked, opacity_at
from photonmap.kernels.records import DIRECTIONAL, DOME, POINT, SPOT, TRIANGLE
from photonmap.kernels.texels import coordinates, look_up

# Numba leaves out a branch on None only where it is an argument of the function itself.

NOWHERE = (0.0, 0.0)
"""Place on an emitter that is no triangle."""


@jit
def emitted(geometry, lights, triangle, side):
    """Return the emitter that a ray's end shows, -1 if it shows none."""
    return lights.dome if triangle < 0 else geometry.emitter[triangle] if side == 0 else -1


@jit
def _textured(lights, glow, emitter):
    """Return which textured lamp an emitter belongs to, -1 for none."""
    return -1 if glow is None else glow.slot[lights.spectrum[emitter]]


@jit
def _glow_at(lights, glow, emitter, slot, place):
    """Return the linear RGB, and the basis (3, N), of a textured lamp at barycentrics `place`."""
    triangle = lights.triangle[emitter]
    s, t = coordinates(glow.uv, glow.triangles, triangle, place[0], place[1])
    return look_up(glow.maps, glow.image[slot], s, t), glow.basis[3 * slot : 3 * slot + 3]


@jit
def add_emitted(target, i, lights, emitter, place, direction, factor):
    """Add factor · what an emitter sends to row i of target; `direction` looks towards it.

    `place` are the barycentrics on a triangle that emits.
    """
    _add_emitted(
        target, i, lights, lights.environment, lights.glow, emitter, place, direction, factor
    )


@jit
def _add_emitted(target, i, lights, environment, glow, emitter, place, direction, factor):
    if environment is not None and emitter == lights.dome:
        add_mix(target, i, radiance_at(environment, direction), environment.basis, factor)
    else:
        _add_lamp(target, i, lights, glow, emitter, place, factor)


@jit
def _add_lamp(target, i, lights, glow, emitter, place, factor):
    if glow is None:
        add_row(target, i, lights.spectra, lights.spectrum[emitter], factor)
        return
    slot = _textured(lights, glow, emitter)
    if slot < 0:
        add_row(target, i, lights.spectra, lights.spectrum[emitter], factor)
        return
    rgb, basis = _glow_at(lights, glow, emitter, slot, place)
    add_mix(target, i, rgb, basis, factor)


@jit
def add_emitted_product(target, i, lights, emitter, place, direction, throughput, factor):
    """Add throughput times what `add_emitted` adds."""
    _add_product(
        target, i, lights, lights.environment, lights.glow, emitter, place, direction, throughput,
        factor,
    )  # fmt: skip


@jit
def _add_product(
    target, i, lights, environment, glow, emitter, place, direction, throughput, factor
):
    if environment is not None and emitter == lights.dome:
        rgb = radiance_at(environment, direction)
        add_mix_product(target, i, rgb, environment.basis, throughput, factor)
    else:
        _add_lamp_product(target, i, lights, glow, emitter, place, throughput, factor)


@jit
def _add_lamp_product(target, i, lights, glow, emitter, place, throughput, factor):
    if glow is None:
        row = lights.spectrum[emitter]
        add_product(target, i, lights.spectra, row, throughput, factor)
        return
    slot = _textured(lights, glow, emitter)
    if slot < 0:
        row = lights.spectrum[emitter]
        add_product(target, i, lights.spectra, row, throughput, factor)
        return
    rgb, basis = _glow_at(lights, glow, emitter, slot, place)
    add_mix_product(target, i, rgb, basis, throughput, factor)


@jit
def start_flux(flux, lights, emitter, place, direction, factor):
    """Fill flux, (N,), with factor · what an emitter sends in a direction from a place of it."""
    _start_flux(flux, lights, lights.environment, lights.glow, emitter, place, direction, factor)


@jit
def _start_flux(flux, lights, environment, glow, emitter, place, direction, factor):
    if environment is not None and emitter == lights.dome:
        rgb = radiance_at(environment, vec.scale(direction, -1.0))
        for band in range(len(flux)):
            flux[band] = np.float32(factor * mix(rgb, environment.basis, band))
    else:
        _start_lamp(flux, lights, glow, emitter, place, factor)


@jit
def _start_lamp(flux, lights, glow, emitter, place, factor):
    if glow is None:
        _start_row(flux, lights, emitter, factor)
        return
    slot = _textured(lights, glow, emitter)
    if slot < 0:
        _start_row(flux, lights, emitter, factor)
        return
    rgb, basis = _glow_at(lights, glow, emitter, slot, place)
    for band in range(len(flux)):
        flux[band] = np.float32(factor * mix(rgb, basis, band))


@jit
def _start_row(flux, lights, emitter, factor):
    spectrum = lights.spectra[lights.spectrum[emitter]]
    for band in range(len(flux)):
        flux[band] = spectrum[band] * np.float32(factor)


@jit
def falloff(cosines, emitter, cosine):
    """Return which part of a spot's intensity goes where the angle to its axis has a cosine.

    All of it inside, nothing outside; between, 3t² - 2t³ of the cosine's way t from one to the
    other.
    """
    inner, outer = cosines[emitter, 0], cosines[emitter, 1]
    if cosine >= inner:
        return 1.0
    if cosine <= outer:
        return 0.0
    t = (cosine - outer) / (inner - outer)
    return t * t * (3.0 - 2.0 * t)


@jit
def _point_of_emitter(geometry, triangle, place):
    """Return (point, ng, opacity) on the front of an emitting triangle, offset off it."""
    point, size = surface.point_at(geometry, triangle, place[0], place[1])
    normal = vec.row(geometry.normals, triangle)
    opacity = opacity_at(geometry, geometry.alpha, triangle, place[0], place[1])
    return surface.offset(point, size, normal), normal, opacity


@jit
def _lit(ng, ns, direction):
    """Return cos θ to the shading normal, 0 where the normals disagree about the side."""
    return max(vec.dot(ns, direction), 0.0) if vec.dot(ng, direction) > 0.0 else 0.0


@jit
def _sky_sample(environment, ns, u, v):
    """Return (direction, density) towards the sky."""
    if environment is None:
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        return direction, warp.cosine_hemisphere_pdf(vec.dot(ns, direction))
    return sample_environment(environment, u, v)


@jit
def _sky_pdf(environment, direction, cosine):
    """Return the density of `_sky_sample`."""
    if environment is None:
        return warp.cosine_hemisphere_pdf(cosine)
    return environment_pdf(environment, direction)


@jit
def _far_sample(lights, emitter, ns, u, v):
    """Return (direction, density) towards an emitter that is infinitely far, density 0 for a sun.

    A sun lies in one direction only.
    """
    if lights.kind[emitter] == DIRECTIONAL:
        return vec.scale(vec.row(lights.axis, emitter), -1.0), 0.0
    return _sky_sample(lights.environment, ns, u, v)


@jit
def _favour(a, b):
    """Weigh a strategy of density a against one of b by the power heuristic (Veach 1997, 9.2.4)."""
    if a >= b:
        return 1.0 / (1.0 + (b / a) * (b / a))
    return (a / b) * (a / b) / (1.0 + (a / b) * (a / b))


@jit
def _evenly(lights, emitter, chance, squared, facing):
    """Return the density per steradian of points spread evenly over an emitting triangle."""
    return chance * warp.uniform_triangle_pdf(lights.area[emitter]) * squared / facing


@jit
def sample_direct(geometry, lights, point, ng, ns, u, v, samples, gathers):
    """Sample one emitter for the irradiance at a point.

    Returns (emitter, weight, place, direction): the sum of weight · what the emitter sends, as
    `add_emitted`, over `samples` such samples and `gathers` cosine-distributed rays, weighed
    against each other, estimates irradiance. A weight of 0 with emitter >= 0 is a light that is
    blocked; emitter -1 is one that is not in front.
    """
    emitter, chance, u = choose(geometry, lights, lights.tree, point, ns, u)
    if emitter < 0:
        return -1, 0.0, NOWHERE, ns
    kind = lights.kind[emitter]
    if kind in (DOME, DIRECTIONAL):
        direction, pdf = _far_sample(lights, emitter, ns, u, v)
        cosine = _lit(ng, ns, direction)
        if cosine == 0.0:
            return -1, 0.0, NOWHERE, direction
        if blocked(geometry, point, direction, math.inf):
            return emitter, 0.0, NOWHERE, direction
        if kind == DIRECTIONAL:
            return emitter, cosine / (samples * chance), NOWHERE, direction
        density = samples * chance * pdf + gathers * warp.cosine_hemisphere_pdf(cosine)
        return emitter, cosine / density, NOWHERE, direction
    if kind == TRIANGLE:
        return _sample_triangle(
            geometry, lights, emitter, chance, point, ng, ns, u, v, samples, gathers
        )
    segment = vec.sub(vec.row(lights.position, emitter), point)
    squared = vec.dot(segment, segment)
    if squared == 0.0:
        return -1, 0.0, NOWHERE, ns
    direction = vec.scale(segment, 1.0 / math.sqrt(squared))
    weight = _lit(ng, ns, direction) / (samples * squared * chance)
    if kind == SPOT:
        axis = vec.row(lights.axis, emitter)
        weight *= falloff(lights.cosines, emitter, -vec.dot(axis, direction))
    if weight == 0.0:
        return -1, 0.0, NOWHERE, direction
    if blocked(geometry, point, segment, 1.0):
        return emitter, 0.0, NOWHERE, direction
    return emitter, weight, NOWHERE, direction


@jit
def _sample_triangle(geometry, lights, emitter, chance, point, ng, ns, u, v, samples, gathers):
    """Sample an emitting triangle roughly in proportion to what it sends to a point.

    Heuristics may take any density for the sampler's; the one of even points is simple.
    """
    triangle = lights.triangle[emitter]
    b1, b2, density = sample_lamp(look_at(geometry, triangle, point, ns), u, v)
    if density == 0.0:
        return -1, 0.0, NOWHERE, ns
    target, normal, opacity = _point_of_emitter(geometry, triangle, (b1, b2))
    segment = vec.sub(target, point)
    squared = vec.dot(segment, segment)
    if squared == 0.0:
        return -1, 0.0, NOWHERE, ns
    direction = vec.scale(segment, 1.0 / math.sqrt(squared))
    cosine, facing = _lit(ng, ns, direction), -vec.dot(normal, direction)
    if cosine == 0.0 or facing <= 0.0:
        return -1, 0.0, NOWHERE, direction
    if blocked(geometry, point, segment, 1.0):
        return emitter, 0.0, NOWHERE, direction
    even = _evenly(lights, emitter, chance, squared, facing)
    weight = _favour(samples * even, gathers * warp.cosine_hemisphere_pdf(cosine))
    return emitter, weight * opacity * cosine / (samples * even * density), (b1, b2), direction


@jit
def weigh_hit(geometry, lights, emitter, point, ns, hit, direction, samples, gathers):
    """Weight of an emitting triangle hit by a cosine-distributed ray, as in `sample_direct`."""
    segment = vec.sub(hit, point)
    facing = -vec.dot(vec.row(geometry.normals, lights.triangle[emitter]), direction)
    chance = chance_of(geometry, lights, lights.tree, emitter, point, ns)
    even = _evenly(lights, emitter, chance, vec.dot(segment, segment), facing)
    own = gathers * warp.cosine_hemisphere_pdf(vec.dot(ns, direction))
    return math.pi / gathers * _favour(own, samples * even)


@jit
def weigh_miss(geometry, lights, point, ns, direction, samples, gathers):
    """Weight of the sky seen by a cosine-distributed ray, as in `sample_direct`."""
    cosine = vec.dot(ns, direction)
    chance = chance_of(geometry, lights, lights.tree, lights.dome, point, ns)
    pdf = chance * _sky_pdf(lights.environment, direction, cosine)
    return cosine / (samples * pdf + gathers * warp.cosine_hemisphere_pdf(cosine))


@jit
def _sky_shine(environment, u, v):
    """Return (direction, density) in which a photon comes from the sky."""
    if environment is None:
        return warp.uniform_sphere(u, v), warp.uniform_sphere_pdf()
    direction, pdf = sample_environment(environment, u, v)
    return vec.scale(direction, -1.0), pdf


@jit
def emit(geometry, lights, place, aim):
    """Send a photon from an emitter: place and aim are points of the unit square.

    Returns (emitter, weight, spot, origin, direction): its flux is weight · what the emitter
    sends from barycentrics `spot`, as `start_flux`.
    """
    emitter, u = warp.discrete(lights.cumulative, place[0])
    v = place[1]
    chance = warp.discrete_pdf(lights.cumulative, emitter)
    kind = lights.kind[emitter]
    if kind == POINT:
        weight = 1.0 / (warp.uniform_sphere_pdf() * chance)
        origin = vec.row(lights.position, emitter)
        return emitter, weight, NOWHERE, origin, warp.uniform_sphere(aim[0], aim[1])
    if kind == SPOT:
        cosine = lights.cosines[emitter, 1]
        local = warp.uniform_cone(aim[0], aim[1], cosine)
        weight = falloff(lights.cosines, emitter, local[2])
        weight /= warp.uniform_cone_pdf(cosine) * chance
        direction = vec.from_frame(local, vec.row(lights.axis, emitter))
        return emitter, weight, NOWHERE, vec.row(lights.position, emitter), direction
    if kind in (DOME, DIRECTIONAL):
        direction, density = vec.row(lights.axis, emitter), 1.0
        if kind == DOME:
            direction, density = _sky_shine(lights.environment, aim[0], aim[1])
        x, y = warp.uniform_disk(u, v)
        local = (lights.radius * x, lights.radius * y, -2.0 * lights.radius)
        weight = lights.radius * lights.radius / (density * warp.uniform_disk_pdf() * chance)
        return emitter, weight, NOWHERE, vec.from_frame(local, direction), direction
    spot = warp.uniform_triangle(u, v)
    origin, normal, opacity = _point_of_emitter(geometry, lights.triangle[emitter], spot)
    direction = vec.from_frame(warp.cosine_hemisphere(aim[0], aim[1]), normal)
    weight = math.pi * lights.area[emitter] / chance * opacity
    return emitter, weight, spot, origin, direction
