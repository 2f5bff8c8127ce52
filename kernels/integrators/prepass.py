"""The sampling pre-pass: where an image is smooth, where it is not, and how near surfaces are."""

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
LIGHTS = 2  # Light samples of a corner
AROUND, MOST_AROUND = 4, 32  # Rays of a corner that look for what is near: at first, and in all
NEAREST = 1e-12  # Distance at least, in sizes of the scene
EVEN_COSINE = 0.999  # Cosine between normals above which a surface hardly curves within a pixel

MATERIAL, LIT, OCCLUDED, SPECULAR, POINT, NORMAL, NEARNESS = 0, 1, 2, 3, 4, 7, 10
"""Columns of what is seen through a corner: material, -1 for none; light samples that arrived, and
that were occluded; whether it is specular; point; normal; the sum of `_look_around`"""
COLUMNS = 11


@jit
def _corner_hit(scene, view, x, y, key):
    """Return what the camera ray through corner x of line y hits, and the ray's direction.

    Neighbours share corners. Where all samples pass through a pixel's centre, its four corners are
    its own, and lie there.
    """
    at_x, at_y = float(x), float(y)
    if not view.film.jitter:
        at_x, at_y = (x >> 1) + 0.5, (y >> 1) + 0.5
    ray = generate_lens_ray(view.camera, at_x, at_y, morton(x, y), key)
    return first_hit(scene.geometry, ray), ray.direction


@jit
def _nearness(geometry, surface, direction):
    """Return 1 / distance² to what a ray meets, 0 where it meets nothing."""
    hit = intersect(geometry, surface.point, direction)
    if hit.triangle < 0:
        return 0.0
    step = vec.sub(point_at(geometry, hit.triangle, hit.u, hit.v)[0], surface.point)
    return 1.0 / max(vec.dot(step, step), NEAREST * NEAREST)


@jit
def _look_around(scene, surface, place, key, first, last):
    """Return the sum of 1 / distance² to what a span of cosine-distributed rays of a corner meets.

    `place` is the corner's `morton` number.
    """
    total = 0.0
    for number in range(first, last):
        index = place * np.uint64(MOST_AROUND) + np.uint64(number)
        u, v = sobol_2d(index, split(key, GATHER))
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), surface.ns)
        total += _nearness(scene.geometry, surface, direction)
    return total


@jit
def _look_at(scene, view, x, y, key, cdf, corner):
    """Fill the columns of corner x of line y."""
    hit, direction = _corner_hit(scene, view, x, y, key)
    corner[MATERIAL] = -1.0
    if hit.triangle < 0:
        return
    surface = surface_interaction(scene.geometry, hit, direction)
    corner[MATERIAL] = scene.geometry.material[hit.triangle]
    corner[SPECULAR] = specular_probability(scene, hit.triangle) > 0.0
    for axis in range(3):
        corner[POINT + axis] = surface.point[axis]
        corner[NORMAL + axis] = surface.ns[axis]
    corner[NEARNESS] = _look_around(scene, surface, morton(x, y), key, 0, AROUND)
    corner[LIT] = corner[OCCLUDED] = 0.0
    prepare_direct(scene, surface, cdf)
    for number in range(LIGHTS):
        index = morton(x, y) * np.uint64(LIGHTS) + np.uint64(number)
        u, v = sobol_2d(index, split(key, LIGHT))
        sample = sample_direct(scene, surface, cdf, u, v)
        corner[LIT] += sample.weight > 0.0
        corner[OCCLUDED] += sample.emitter >= 0 and sample.weight == 0.0


@jit
def _vector(corner, column):
    return corner[column], corner[column + 1], corner[column + 2]


@jit
def _join(textured, corners, x, y, spreads, pixel, shown, prepass):
    """Say of a pixel what its corners, x and x + 1 of lines y and y + 1, have shown."""
    hits, even, one_material, first = 0, True, True, corners[y & 1, x]
    lit = occluded = specular = near = 0.0
    plane, nearness = shown
    for number in range(CORNERS):
        corner = corners[(y + (number >> 1)) & 1, x + (number & 1)]
        if corner[MATERIAL] < 0.0:
            continue
        if hits == 0:
            first = corner
        normal = _vector(corner, NORMAL)
        update_plane(plane, pixel, hits == 0 or not spreads, _vector(corner, POINT), normal)
        hits += 1
        one_material = one_material and corner[MATERIAL] == first[MATERIAL]
        even = even and textured[np.int64(corner[MATERIAL])] == 0
        even = even and vec.dot(normal, _vector(first, NORMAL)) > EVEN_COSINE
        lit += corner[LIT]
        occluded += corner[OCCLUDED]
        specular += corner[SPECULAR]
        near += corner[NEARNESS]
    flat = one_material and hits == CORNERS and plane[pixel, FLAT] != 0.0
    prepass.flat[pixel] = flat
    prepass.even[pixel] = even and flat
    prepass.penumbra[pixel] = lit > 0.0 and occluded > 0.0
    prepass.specular[pixel] = specular > 0.0
    nearness[pixel] += near / max(hits, 1)


@jit
def _first_line(film, span, row):
    """Return the first of the two lines of corners of a row of pixels that is not known yet."""
    return row + (row > span.first) if film.jitter else 2 * row


@jit
def _last_line(film, row):
    return row + 1 if film.jitter else 2 * row + 1


@kernel
def run_prepass(scene, textured, view, key, span, scratch, shown, prepass):
    """Fill `prepass` and `shown` of a span of lines; `textured` is (M,).

    What is shown are planes, (P, 7), and nearness, (P,), to which `AROUND` rays are added, as by
    `look_around`. `scratch` is a cdf, and (2, 2 W + 1, COLUMNS) float64 for two lines of corners.
    """
    film, (cdf, corners) = view.film, scratch
    spreads = film.jitter or has_open_lens(view.camera.optics)
    step = 1 if film.jitter else 2
    for row in range(span.first, span.last):
        for y in range(_first_line(film, span, row), _last_line(film, row) + 1):
            for x in range(step * (film.width - 1) + 2):
                _look_at(scene, view, x, y, key, cdf, corners[y & 1, x])
        for column in range(film.width):
            pixel = row * film.width + column
            x, y = step * column, step * row
            _join(textured, corners, x, y, spreads, pixel, shown, prepass)


@kernel
def look_around(scene, view, key, rays, span, sums, nearness):
    """Add to nearness, (P,), of a span of lines the sums over a span of `MOST_AROUND` rays.

    They are means over corners of 1 / distance² to the surfaces around. `sums` is (2, 2 W + 1)
    scratch for two lines of corners.
    """
    film, step = view.film, 1 if view.film.jitter else 2
    for row in range(span.first, span.last):
        for y in range(_first_line(film, span, row), _last_line(film, row) + 1):
            for x in range(step * (film.width - 1) + 2):
                hit, direction = _corner_hit(scene, view, x, y, key)
                sums[y & 1, x] = -1.0
                if hit.triangle >= 0:
                    surface = surface_interaction(scene.geometry, hit, direction)
                    place = morton(x, y)
                    sums[y & 1, x] = _look_around(scene, surface, place, key, rays.first, rays.last)
        for column in range(film.width):
            total, hits = 0.0, 0
            for number in range(CORNERS):
                line, x = step * row + (number >> 1), step * column + (number & 1)
                total += max(sums[line & 1, x], 0.0)
                hits += sums[line & 1, x] >= 0.0
            nearness[row * film.width + column] += total / max(hits, 1)
