"""Light tracing: caustic photons connected to the camera, where it sees the surface they reach.

A photon adds its flux to the one pixel that sees it, so there is no disk, and no bias (Dutré,
Lafortune and Willems 1993, "Monte Carlo light tracing with direct computation of pixel
intensities"). Where pixels are small against the disks, disks remain: they average more photons.
The choice depends on the place, the camera and the number of the pass, never on photons.
"""

import math

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.fluorescence import fluoresces
from photonmap.kernels.camera.cameras import film_point, generate_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import clear
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import CAUSTIC, Hit
from photonmap.kernels.film.pixels import add_beyond_diffuse
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import occluded, opacity_along


@jit
def _way_to_eye(camera, point):
    """Return the `FilmPoint` of a point, and the way from there to the eye."""
    seen = film_point(camera, point)
    return seen, vec.sub(generate_ray(camera, seen.x, seen.y).origin, point)


@jit
def _film_density(seen, way, ng):
    """Return the pixels per unit of area of a surface; 0 or less where its other side is seen."""
    return seen.density * vec.dot(way, ng) / math.sqrt(vec.dot(way, way))


@jit
def are_caustics_connected(job, surface, pixel):
    """Return whether light tracing brings the caustics of a first hit: then disks must not."""
    caustics = job.photon_maps.caustics
    if caustics is None:
        return False
    if caustics.connected == 0.0:
        return False
    seen, way = _way_to_eye(job.eye.camera, surface.point)
    return _is_connected(job, caustics, _film_density(seen, way, surface.ng), pixel)


@jit
def _is_connected(job, caustics, density, pixel):
    """Return whether photons are connected at a film density: disks of several samples add up."""
    return 0.0 < density * math.sqrt(job.plan.samples[pixel]) <= caustics.connected


@jit
def _hit_of(caustics, photon):
    """Return the hit of a photon."""
    u, v = float(caustics.barycentrics[photon, 0]), float(caustics.barycentrics[photon, 1])
    return Hit(np.int64(caustics.triangles[photon]), u, v, 0.0)


@jit
def _connect(job, caustics, photon):
    """Return the pixel that sees a photon, or -1, its weight there, and the rays cast."""
    geometry, film, position = job.scene.geometry, job.eye.film, caustics.positions[photon]
    point, ng = vec.row(caustics.positions, photon), (position[3], position[4], position[5])
    seen, way = _way_to_eye(job.eye.camera, point)
    if not (0.0 <= seen.x < film.width and 0.0 <= seen.y < film.height):
        return -1, 0.0, 0
    pixel, density = int(seen.y) * film.width + int(seen.x), _film_density(seen, way, ng)
    if not _is_connected(job, caustics, density, pixel):
        return -1, 0.0, 0
    if occluded(geometry, point, way, 1.0):
        return -1, 0.0, 1
    opacity = opacity_along(geometry, _hit_of(caustics, photon), way)
    return pixel, density * opacity, 1


@kernel
def connect_photons(job, caustics, span, pixels, weights):
    """Connect the photons of a span with the camera; return the number of rays cast.

    Fills pixels, (n,) int32, with those that see them, or -1, and weights, (n,) float32, with what
    turns flux into the mean irradiance of a pixel.
    """
    rays = 0
    for photon in range(span.first, span.last):
        pixel, weight, cast = _connect(job, caustics, photon)
        pixels[photon], weights[photon] = pixel, weight
        rays += cast
    return rays


@jit
def _scatter(scene, caustics, surface, photon, scratches):
    """Fill row CAUSTIC of what is scattered with what a surface makes of a photon."""
    if scene.scattering is None:
        return
    if models.model_at(scene, surface.hit.triangle) == models.LAMBERTIAN:
        return
    wi = vec.scale(vec.row(caustics.arrivals, photon), -1.0)
    models.evaluate(scene, surface, wi, scratches.own.response)
    for band in range(len(scratches.own.response)):
        light = scratches.own.irradiance[CAUSTIC, band]
        scratches.scattered.irradiance[CAUSTIC, band] = scratches.own.response[band] * light
    if scene.fluorescence is not None and fluoresces(scene, surface.hit.triangle):
        exciting = scratches.own.walk
        models.fill_excitation(scene, surface, wi, scratches.own.response, exciting)
        for band in range(len(exciting)):
            light = scratches.own.irradiance[CAUSTIC, band]
            scratches.excited.irradiance[CAUSTIC, band] = exciting[band] * light


@kernel
def add_connected(job, caustics, connections, span, scratches, estimate):
    """Add the photons that the pixels of a span see to an `Estimate`, by the order of photons."""
    clear(scratches.own.irradiance)
    clear(scratches.scattered.irradiance)
    clear(scratches.excited.irradiance)
    scene, camera = job.scene, job.eye.camera
    for pixel in range(span.first, span.last):
        for slot in range(connections.starts[pixel], connections.starts[pixel + 1]):
            photon = connections.order[slot]
            weight = connections.weights[photon]
            for band in range(caustics.flux.shape[1]):
                scratches.own.irradiance[CAUSTIC, band] = weight * caustics.flux[photon, band]
            way = _way_to_eye(camera, vec.row(caustics.positions, photon))[1]
            hit = _hit_of(caustics, photon)
            surface = surface_interaction(scene.geometry, hit, vec.scale(way, -1.0))
            _scatter(scene, caustics, surface, photon, scratches)
            add_beyond_diffuse(scene, surface, np.float32(1.0), pixel, scratches, estimate)
