"""Pixels of a pass: their order, the plane that each shows, what it sees and adds up."""

import numpy as np

from photonmap.kernels.bsdf.fluorescence import add_reradiated, fluoresces, fluorophore_at
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.camera.cameras import first_hit, generate_lens_ray, is_dark
from photonmap.kernels.core import passes, vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.lights.emission import add_emission, emission_of, visible_emitter

MIN_COSINE = 0.9  # Cosine between normals above which two points may lie on one smooth surface
MAX_SLOPE = 0.1  # Height over the other's tangent plane, per distance, up to which they do
FLAT = 6  # Column of a pixel's plane: its flatness, after point and shading normal


@jit
def morton(x, y):
    """Interleave the bits of two 16-bit integers: neighbours in the plane get near numbers."""
    code = np.uint64(0)
    for bit in range(16):
        code |= np.uint64((x >> bit) & 1) << np.uint64(2 * bit)
        code |= np.uint64((y >> bit) & 1) << np.uint64(2 * bit + 1)
    return code


@jit
def is_same_surface(step, normal, other):
    """Return whether a point a `step` away, with normal `other`, lies on one smooth surface."""
    height = vec.dot(step, normal)
    return vec.dot(
        normal, other
    ) > MIN_COSINE and height * height <= MAX_SLOPE * MAX_SLOPE * vec.dot(step, step)


@jit
def plane_point(plane, pixel):
    """Return the point kept in row `pixel` of (P, 7)."""
    return float(plane[pixel, 0]), float(plane[pixel, 1]), float(plane[pixel, 2])


@jit
def plane_normal(plane, pixel):
    """Return the normal kept in row `pixel` of (P, 7)."""
    return float(plane[pixel, 3]), float(plane[pixel, 4]), float(plane[pixel, 5])


@jit
def update_plane(plane, pixel, first, point, normal):
    """Keep the plane of a pixel's first hit; it is not flat if a later one departs from it."""
    if first:
        for axis in range(3):
            plane[pixel, axis] = point[axis]
            plane[pixel, 3 + axis] = normal[axis]
        plane[pixel, FLAT] = 1.0
    elif not is_same_surface(
        vec.sub(point, plane_point(plane, pixel)), plane_normal(plane, pixel), normal
    ):
        plane[pixel, FLAT] = 0.0


@jit
def clear_pixel(pixels, pixel):
    """Set all of a pixel's sums to 0."""
    pixels.coverage[pixel] = 0.0
    pixels.lookups[pixel] = 0
    for band in range(pixels.direct.shape[1]):
        pixels.emission[pixel, band] = 0.0
        pixels.direct[pixel, band] = 0.0
        pixels.indirect[pixel, band] = 0.0
        pixels.reflectance[pixel, band] = 0.0
        pixels.irradiance_direct[pixel, band] = 0.0
        pixels.irradiance_indirect[pixel, band] = 0.0


@jit
def clear_sums(sums, pixel):
    """Set all of a pixel's sums, (rows, P, N), to 0, unless there are none (None)."""
    if sums is None:
        return
    for row in range(sums.shape[0]):
        for band in range(sums.shape[2]):
            sums[row, pixel, band] = 0.0


@jit
def trace_camera_ray(job, pixel, position, index, weight, pixels, rays):
    """Cast the camera ray of a position in a pixel, and add the emission that it sees.

    `index` numbers the point of the lens that it leaves, if there is a lens. Returns its hit, whose
    triangle is -1 where it meets nothing, and the ray. `rays` counts it.
    """
    geometry, lights, width = job.scene.geometry, job.scene.lights, job.eye.film.width
    x, y = pixel % width + position[0], pixel // width + position[1]
    ray = generate_lens_ray(job.eye.camera, x, y, index, job.key)
    hit = first_hit(geometry, ray)
    if is_dark(ray):
        return hit, ray
    rays[passes.CAMERA] += 1
    emitter, position = visible_emitter(geometry, lights, hit, ray.direction)
    if emitter >= 0:
        emission = emission_of(lights, emitter, position)
        add_emission(pixels.emission, pixel, lights, emission, weight)
    if hit.triangle >= 0:
        pixels.coverage[pixel] += weight
    return hit, ray


@jit
def add_reflected(scene, surface, weight, pixel, scratches, estimate):
    """Add what a first hit's material makes of its irradiance, (2, N) or (3, N), to a pixel."""
    color = look_up_material(scene, surface.hit)
    _add_diffuse(scene, color, weight, pixel, scratches.own.irradiance, estimate.pixels)
    add_beyond_diffuse(scene, surface, weight, pixel, scratches, estimate)


@jit
def add_beyond_diffuse(scene, surface, weight, pixel, scratches, estimate):
    """Add caustics that a first hit reflects, what it scatters beyond Lambert's, or re-emits."""
    color = look_up_material(scene, surface.hit)
    _add_caustics(scene, color, weight, pixel, scratches.own.irradiance, estimate.via_specular)
    _add_scattered(scene, surface, weight, pixel, scratches, estimate.via_specular)
    _add_fluorescence(scene, surface, weight, pixel, scratches, estimate.via_specular)


@jit
def _add_diffuse(scene, color, weight, pixel, irradiance, pixels):
    for band in range(irradiance.shape[1]):
        rho = albedo(scene, color, band) * weight
        direct, indirect = irradiance[passes.DIRECT, band], irradiance[passes.INDIRECT, band]
        pixels.reflectance[pixel, band] += rho
        pixels.direct[pixel, band] += rho * direct * np.float32(warp.INV_PI)
        pixels.indirect[pixel, band] += rho * indirect * np.float32(warp.INV_PI)
        pixels.irradiance_direct[pixel, band] += weight * direct
        pixels.irradiance_indirect[pixel, band] += weight * indirect


@jit
def _add_caustics(scene, color, weight, pixel, irradiance, via_specular):
    if via_specular is None or irradiance.shape[0] <= passes.CAUSTIC:
        return
    for band in range(irradiance.shape[1]):
        light = weight * irradiance[passes.CAUSTIC, band]
        rho = albedo(scene, color, band)
        via_specular[passes.CAUSTIC_IRRADIANCE, pixel, band] += light
        via_specular[passes.FIRST_CAUSTIC, pixel, band] += rho * light * np.float32(warp.INV_PI)


@jit
def _add_scattered(scene, surface, weight, pixel, scratches, via_specular):
    """Add what a BSDF other than Lambert's scatters beyond albedo · irradiance / π."""
    if scene.scattering is None or via_specular is None:
        return
    color = look_up_material(scene, surface.hit)
    if scene.scattering.model[color[0]] == 0:
        return
    for band in range(scratches.own.irradiance.shape[1]):
        rho = albedo(scene, color, band) * np.float32(warp.INV_PI)
        for row in range(scratches.own.irradiance.shape[0]):
            light = (
                scratches.scattered.irradiance[row, band]
                - rho * scratches.own.irradiance[row, band]
            )
            via_specular[passes.VIA_DIRECT + row, pixel, band] += weight * light


@jit
def _add_fluorescence(scene, surface, weight, pixel, scratches, via_specular):
    if scene.fluorescence is None or via_specular is None:
        return
    if not fluoresces(scene, surface.hit.triangle):
        return
    exciting, sent = scratches.own.walk, scratches.own.response
    for row in range(scratches.own.irradiance.shape[0]):
        indirect = 0 if row == passes.DIRECT else 1
        fill_reradiated(scene, surface, scratches, row, exciting, sent)
        for band in range(len(sent)):
            via_specular[passes.FLUORESCENT_DIRECT + indirect, pixel, band] += weight * sent[band]
            via_specular[passes.EXCITATION_DIRECT + indirect, pixel, band] += (
                weight * exciting[band]
            )


@outlined
def fill_reradiated(scene, surface, scratches, row, exciting, sent):
    """Fill sent, (N,), with the radiance that a surface re-emits for a row of its irradiance.

    And exciting, (N,), with the part of that, over π, by which it does.
    """
    own, excited = scratches.own.irradiance, scratches.excited.irradiance
    fluorescence, material = scene.fluorescence, scene.geometry.material[surface.hit.triangle]
    is_lambertian = scene.scattering is None or scene.scattering.model[material] == 0
    for band in range(len(sent)):
        sent[band] = 0.0
        exciting[band] = own[row, band] * np.float32(warp.INV_PI)
        if not is_lambertian:
            exciting[band] = excited[row, band]
    number, concentration = fluorophore_at(scene.geometry, fluorescence, surface.hit)
    add_reradiated(fluorescence, number, concentration, exciting, sent)
    for band in range(len(sent)):
        exciting[band] *= np.float32(concentration) * fluorescence.taken[number, band]
