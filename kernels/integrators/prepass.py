"""The sampling pre-pass: where an image is smooth, and where it is not."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.camera.cameras import first_hit, generate_lens_ray, has_open_lens
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.rng import sobol_2d
from photonmap.kernels.core.streams import GATHER, LIGHT, split
from photonmap.kernels.film.pixels import FLAT, morton, update_plane
from photonmap.kernels.geometry.interaction import point_at, surface_interaction
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.lights.direct import prepare_direct, sample_direct

CORNERS = 4  # Camera rays of a pixel, through its corners: a straight edge always parts them
AROUND = 8  # Rays of a corner that look for what is near
NEAREST = 1e-12  # Distance at least, in sizes of the scene
EVEN_COSINE = 0.999  # Cosine between normals above which a surface hardly curves within a pixel


class Corners(NamedTuple):
    """What the corners of a pixel have shown so far."""

    hits: int
    lit: int  # light samples that arrived
    occluded: int
    nearness: float  # sum of 1 / distance to the surfaces around
    one_material: bool
    even: bool
    specular: bool
    material: int  # of the first hit
    normal: tuple  # its shading normal


@jit
def _nearness_along(geometry, surface, direction):
    """Return 1 / distance to what a ray meets, 0 where it meets nothing."""
    hit = intersect(geometry, surface.point, direction)
    if hit.triangle < 0:
        return 0.0
    step = vec.sub(point_at(geometry, hit.triangle, hit.u, hit.v)[0], surface.point)
    return 1.0 / max(math.sqrt(vec.dot(step, step)), NEAREST)


@jit
def _nearness(geometry, surface, index, key):
    """Return the mean of 1 / distance to what cosine-distributed rays meet."""
    total = 0.0
    for number in range(AROUND):
        u, v = sobol_2d(index * np.uint64(AROUND) + np.uint64(number), key)
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), surface.ns)
        total += _nearness_along(geometry, surface, direction)
    return total / AROUND


@jit
def _take(scene, textured, seen, surface, index, keys, cdf):
    """Return what is known of a pixel after another corner; `seen` is what was known before."""
    geometry, triangle = scene.geometry, surface.hit.triangle
    material = np.int64(geometry.material[triangle])
    first = seen.hits == 0
    of_first, normal = (material, surface.ns) if first else (seen.material, seen.normal)
    even = textured[material] == 0 and vec.dot(surface.ns, normal) > EVEN_COSINE
    u, v = sobol_2d(index, keys[0])
    prepare_direct(scene, surface, cdf)
    sample = sample_direct(scene, surface, cdf, u, v, 1)
    specular = specular_probability(scene, triangle) > 0.0
    return Corners(
        seen.hits + 1,
        seen.lit + (sample.weight > 0.0),
        seen.occluded + (sample.emitter >= 0 and sample.weight == 0.0),
        seen.nearness + _nearness(geometry, surface, index, keys[1]),
        seen.one_material and material == of_first,
        seen.even and even,
        seen.specular or specular,
        of_first,
        normal,
    )


@jit
def _corner(film, pixel, corner):
    """Return the film point of a pixel's corner; its centre where all samples pass through it."""
    column, row = pixel % film.width, pixel // film.width
    if film.jitter:
        return column + float(corner & 1), row + float(corner >> 1)
    return column + 0.5, row + 0.5


@kernel
def run_prepass(scene, textured, view, key, span, cdf, plane, prepass):
    """Fill `prepass`, `plane`, (P, 7), of a span; `textured`, (M,); `cdf` is scratch."""
    keys, film = (split(key, LIGHT), split(key, GATHER)), view.film
    spreads = film.jitter or has_open_lens(view.camera.optics)
    for pixel in range(span.first, span.last):
        base = morton(pixel % film.width, pixel // film.width) * CORNERS
        up = (0.0, 0.0, 0.0)
        seen = Corners(0, 0, 0, 0.0, True, True, False, np.int64(-1), up)
        for corner in range(CORNERS):
            x, y = _corner(film, pixel, corner)
            index = np.uint64(base + corner)
            ray = generate_lens_ray(view.camera, x, y, index, key)
            hit = first_hit(scene.geometry, ray)
            if hit.triangle < 0:
                continue
            surface = surface_interaction(scene.geometry, hit, ray.direction)
            first = seen.hits == 0 or not spreads
            update_plane(plane, pixel, first, surface.point, surface.ns)
            seen = _take(scene, textured, seen, surface, index, keys, cdf)
        flat = seen.one_material and seen.hits == CORNERS and plane[pixel, FLAT] != 0.0
        prepass.flat[pixel] = flat
        prepass.even[pixel] = seen.even and flat
        prepass.nearness[pixel] = seen.nearness / max(seen.hits, 1)
        prepass.penumbra[pixel] = seen.lit > 0 and seen.occluded > 0
        prepass.specular[pixel] = seen.specular
