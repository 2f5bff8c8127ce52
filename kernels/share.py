"""Indirect irradiance shared between neighbouring pixels of one smooth piece of surface.

Every pixel's estimate is averaged with those of neighbours at opposite places, taken in pairs: a
linear change across the window cancels, so the bias is of second order, and it vanishes as the
window shrinks from pass to pass. Which pixels share depends on geometry and on a survey made
beforehand, never on the estimates themselves.
"""

import numpy as np

from photonmap.kernels import vec
from photonmap.kernels.film import FLAT, continues, plane_normal, plane_point
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.warp import INV_PI


@jit
def _alike(plane, reach, scale, pixel, other):
    """Tell whether two pixels lie on one surface, within reach of each other."""
    if plane[other, FLAT] == 0.0:
        return False
    step = vec.sub(plane_point(plane, other), plane_point(plane, pixel))
    limit = scale * min(reach[pixel], reach[other])
    return vec.dot(step, step) <= limit * limit and continues(
        step, plane_normal(plane, pixel), plane_normal(plane, other)
    )


@jit
def _add_window(film, plane, reach, radius, scale, pixel, source, target):
    """Add the partners of a pixel to row `pixel` of target; return how many they are."""
    column, row = pixel % film.width, pixel // film.width
    margin = min(min(column, film.width - 1 - column), int(radius))
    count = 0
    for y in range(min(min(row, film.height - 1 - row), int(radius)) + 1):
        for x in range(-margin if y > 0 else 1, margin + 1):
            step = y * film.width + x
            if (
                x * x + y * y <= radius * radius
                and _alike(plane, reach, scale, pixel, pixel + step)
                and _alike(plane, reach, scale, pixel, pixel - step)
            ):
                count += 2
                for band in range(source.shape[1]):
                    target[pixel, band] += source[pixel + step, band] + source[pixel - step, band]
    return count


@kernel
def share(film, plan, radius, scale, first, last, pixels, shared):
    """Share indirect light among pixels first..last and their neighbours.

    `radius` bounds windows in pixels, `scale` times the plan's reach in space. Averages of
    `pixels.irradiance_indirect` go to `shared`, (P, N), and flat pixels' `indirect` is made anew.
    """
    for pixel in range(first, last):
        for band in range(shared.shape[1]):
            shared[pixel, band] = pixels.irradiance_indirect[pixel, band]
        if pixels.plane[pixel, FLAT] != 0.0:
            count = 1 + _add_window(
                film, pixels.plane, plan.reach, radius, scale, pixel,
                pixels.irradiance_indirect, shared,
            )  # fmt: skip
            factor = np.float32(1.0 / count)
            for band in range(shared.shape[1]):
                shared[pixel, band] *= factor
                pixels.indirect[pixel, band] = (
                    pixels.reflectance[pixel, band] * shared[pixel, band] * np.float32(INV_PI)
                )


@kernel
def count_windows(film, plane, reach, radius, scale, first, last, nothing, counts):
    """Count the pixels that would share with each of first..last; `nothing` is (P, 0)."""
    for pixel in range(first, last):
        counts[pixel] = 1
        if plane[pixel, FLAT] != 0.0:
            counts[pixel] += _add_window(film, plane, reach, radius, scale, pixel, nothing, nothing)
