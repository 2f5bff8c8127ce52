"""A look at the scene before the passes: where an image is smooth, and where it is not."""

import math

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.beyond import smoothness
from photonmap.kernels.film import FLAT, camera_ray, morton, note_hit
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.light import sample_direct
from photonmap.kernels.opaque import hit
from photonmap.kernels.rng import sobol_2d, stream
from photonmap.kernels.surface import meet, point_at

LIGHT, GATHER = 0, 1
CORNERS = 4
NEAREST = 1e-12
EVEN_COSINE = 0.999


@jit
def _nearness(geometry, point, ns, u, v):
    """Return 1 / distance to what a cosine-distributed ray meets, 0 where it meets nothing."""
    direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
    triangle, u, v, _ = hit(geometry, point, direction)
    if triangle < 0:
        return 0.0
    step = vec.sub(point_at(geometry, triangle, u, v)[0], point)
    return 1.0 / max(math.sqrt(vec.dot(step, step)), NEAREST)


@kernel
def survey_pixels(
    geometry, lights, optics, textured, camera, film, key, first, last, plane, survey
):
    """Fill `survey` and `plane`, (P, 7), of pixels first..last by looks at their corners.

    A straight edge through a pixel always parts its corners. `textured`, (M,) uint8, tells which
    materials are.
    """
    keys = (stream(key, LIGHT, 0), stream(key, GATHER, 0))
    for pixel in range(first, last):
        column, row = pixel % film.width, pixel // film.width
        base = morton(column, row) * CORNERS
        hits = lit = blocked = 0
        nearness = 0.0
        one, even, paint, normal = True, True, np.int32(-1), camera.origin
        for corner in range(CORNERS):
            x, y = (corner & 1, corner >> 1) if film.jitter else (0.5, 0.5)
            direction = camera_ray(camera, column + x, row + y)
            triangle, u, v, _ = hit(geometry, camera.origin, direction)
            if triangle < 0:
                continue
            point, ng, ns, _ = meet(geometry, triangle, u, v, direction)
            material = geometry.material[triangle]
            if hits == 0:
                paint, normal = material, ns
            one &= material == paint
            even &= textured[material] == 0
            even &= vec.dot(ns, normal) > EVEN_COSINE
            note_hit(plane, pixel, hits == 0 or not film.jitter, point, ns)
            hits += 1
            if smoothness(geometry, optics, triangle) > 0.0:
                survey.smooth[pixel] = 1
            at = sobol_2d(base + corner, keys[LIGHT])
            emitter, weight, _, _ = sample_direct(
                geometry, lights, point, ng, ns, at[0], at[1], 1, 0
            )
            lit += weight > 0.0
            blocked += emitter >= 0 and weight == 0.0
            at = sobol_2d(base + corner, keys[GATHER])
            nearness += _nearness(geometry, point, ns, at[0], at[1])
        survey.flat[pixel] = one and hits == CORNERS and plane[pixel, FLAT] != 0.0
        survey.even[pixel] = even and survey.flat[pixel] != 0
        survey.nearness[pixel] = nearness / max(hits, 1)
        survey.penumbra[pixel] = lit > 0 and blocked > 0
