"""Irradiance sharing: indirect light filtered over neighbouring pixels of one smooth surface.

Every pixel's estimate is averaged with those of neighbours on opposite sides, taken in pairs: a
linear change across the footprint cancels, so the bias is of second order, and it vanishes as the
footprint shrinks from pass to pass. Which pixels share depends on geometry and on the sampling
pre-pass, never on the estimates themselves.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.fluorescence import add_band, fluoresces, fluorophore_at
from photonmap.kernels.camera.cameras import first_hit, generate_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import EXCITATION_INDIRECT, FLUORESCENT_INDIRECT
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.film.pixels import FLAT, is_same_surface, plane_normal, plane_point


@by_reference
class Footprint(NamedTuple):
    """How far pixels share."""

    plane: np.ndarray  # (P, 7), of pixels
    sharing_radius: np.ndarray  # (P,) float32, in space
    scale: float  # of these radii
    radius: float  # at most, in pixels
    turn: float  # angle between the normals of two pixels up to which they share, radians


@jit
def may_share(footprint, pixel, other):
    """Return whether two pixels show one surface, within the sharing radius of both."""
    plane, radius = footprint.plane, footprint.sharing_radius
    if plane[other, FLAT] == 0.0:
        return False
    step = vec.sub(plane_point(plane, other), plane_point(plane, pixel))
    limit = footprint.scale * min(radius[pixel], radius[other])
    normal, other_normal = plane_normal(plane, pixel), plane_normal(plane, other)
    return (
        vec.dot(step, step) <= limit * limit
        and 1.0 - vec.dot(normal, other_normal) <= 0.5 * footprint.turn * footprint.turn
        and is_same_surface(step, normal, other_normal)
    )


@jit
def _add_footprint(film, footprint, pixel, source, target):
    """Add the partners of a pixel to row `pixel` of target; return how many there are."""
    column, row = pixel % film.width, pixel // film.width
    radius = footprint.radius
    margin = min(min(column, film.width - 1 - column), int(radius))
    count = 0
    for y in range(min(min(row, film.height - 1 - row), int(radius)) + 1):
        for x in range(-margin if y > 0 else 1, margin + 1):
            step = y * film.width + x
            if (
                x * x + y * y <= radius * radius
                and may_share(footprint, pixel, pixel + step)
                and may_share(footprint, pixel, pixel - step)
            ):
                count += 2
                for band in range(source.shape[1]):
                    target[pixel, band] += source[pixel + step, band] + source[pixel - step, band]
    return count


@kernel
def share_irradiance(film, footprint, span, pixels, shared):
    """Share indirect irradiance among the pixels of a span and their neighbours.

    Averages of `pixels.irradiance_indirect` go to `shared`, (P, N), and the `indirect` of flat
    pixels is computed again.
    """
    for pixel in range(span.first, span.last):
        for band in range(shared.shape[1]):
            shared[pixel, band] = pixels.irradiance_indirect[pixel, band]
        if pixels.plane[pixel, FLAT] != 0.0:
            count = 1 + _add_footprint(film, footprint, pixel, pixels.irradiance_indirect, shared)
            factor = np.float32(1.0 / count)
            for band in range(shared.shape[1]):
                shared[pixel, band] *= factor
                pixels.indirect[pixel, band] = (
                    pixels.reflectance[pixel, band] * shared[pixel, band] * np.float32(INV_PI)
                )


@kernel
def share_fluorescence(fluorescence, centre, span, own, shared, via_specular):
    """Add what sharing changes to what pixels re-emit: of indirect irradiance `own` to `shared`.

    Both are (P, N), and the centres' fluorophores, (2, P) float32, see `fill_centre_fluorophores`,
    are independent of them, so the mean is kept.
    """
    sent, exciting = via_specular[FLUORESCENT_INDIRECT], via_specular[EXCITATION_INDIRECT]
    for pixel in range(span.first, span.last):
        row = int(centre[0, pixel])
        if row < 0:
            continue
        factor = centre[1, pixel] * np.float32(INV_PI)
        for band in range(shared.shape[1]):
            step = factor * (shared[pixel, band] - own[pixel, band])
            exciting[pixel, band] += step * fluorescence.taken[row, band]
            add_band(fluorescence, row, band, step, sent[pixel])


@kernel
def fill_centre_fluorophores(scene, view, span, centre):
    """Fill centre, (2, P) float32, with row and concentration at pixels' centres; rows of -1."""
    width = view.film.width
    for pixel in range(span.first, span.last):
        centre[0, pixel] = -1.0
        ray = generate_ray(view.camera, pixel % width + 0.5, pixel // width + 0.5)
        hit = first_hit(scene.geometry, ray)
        if hit.triangle >= 0 and fluoresces(scene, hit.triangle):
            row, concentration = fluorophore_at(scene.geometry, scene.fluorescence, hit)
            centre[0, pixel], centre[1, pixel] = row, concentration


@kernel
def count_footprints(film, footprint, span, nothing, counts):
    """Count the pixels of each footprint of a span; `nothing` is (P, 0)."""
    for pixel in range(span.first, span.last):
        counts[pixel] = 1
        if footprint.plane[pixel, FLAT] != 0.0:
            counts[pixel] += _add_footprint(film, footprint, pixel, nothing, nothing)
