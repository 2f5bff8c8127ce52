"""Irradiance sharing: indirect light filtered over neighbouring pixels of one smooth surface.

Every pixel's estimate is averaged with those of neighbours on opposite sides, taken in pairs: a
linear change across the footprint cancels, so the bias is of second order, and it vanishes as the
footprint shrinks from pass to pass. Which pixels share depends on geometry and on the sampling
pre-pass, never on the estimates themselves.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.fluorescence import add_band, fluoresces, fluorophore_at
from photonmap.kernels.camera.cameras import first_hit, generate_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, kernel, vectorized
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


RADIUS = 7  # Row of the planes of a strip: the sharing radius


@by_reference
class Strip(NamedTuple):
    """Lines of an image, and all that share with them, columns of arrays: see `Footprint`."""

    planes: np.ndarray  # (8, L) float32, of pixels: planes, and sharing radii
    light: np.ndarray  # (N, L) float32
    first: int  # line of the image
    width: int
    height: int  # lines
    scale: float
    radius: float
    turn: float


def cut_strip(film, footprint, lines, light):
    """Return the strip that a span of lines shares, of light, (P, N), and scratch to do so."""
    reach = int(footprint.radius)
    first, last = max(lines.first - reach, 0), min(lines.last + reach, film.height)
    rows = slice(first * film.width, last * film.width)
    planes = np.column_stack([footprint.plane[rows], footprint.sharing_radius[rows]])
    strip = Strip(
        np.ascontiguousarray(planes.T),
        np.ascontiguousarray(light[rows].T),
        first,
        film.width,
        last - first,
        footprint.scale,
        footprint.radius,
        footprint.turn,
    )
    sums = np.empty((light.shape[1] + 1, film.width), np.float32)
    return strip, (np.empty(film.width, np.uint8), sums)


@jit
def _agree(step, normal, other_normal, limit, turn):
    """Return whether points a `step` within a limit apart, that turn little, lie on one surface."""
    return (
        vec.dot(step, step) <= limit * limit
        and 1.0 - vec.dot(normal, other_normal) <= 0.5 * turn * turn
        and is_same_surface(step, normal, other_normal)
    )


@jit
def may_share(footprint, pixel, other):
    """Return whether two pixels show one surface, within the sharing radius of both."""
    plane, radius = footprint.plane, footprint.sharing_radius
    if plane[other, FLAT] == 0.0:
        return False
    step = vec.sub(plane_point(plane, other), plane_point(plane, pixel))
    limit = footprint.scale * min(radius[pixel], radius[other])
    normal, other_normal = plane_normal(plane, pixel), plane_normal(plane, other)
    return _agree(step, normal, other_normal, limit, footprint.turn)


@jit
def _triple(planes, row, i):
    return float(planes[row, i]), float(planes[row + 1, i]), float(planes[row + 2, i])


@jit
def _shares(strip, i, j):
    """Return `may_share` of pixels `i` and `j` of a strip, without branches."""
    planes, turn = strip.planes, strip.turn
    step = vec.sub(_triple(planes, 0, j), _triple(planes, 0, i))
    limit = strip.scale * min(planes[RADIUS, i], planes[RADIUS, j])
    agree = _agree(step, _triple(planes, 3, i), _triple(planes, 3, j), limit, turn)
    return agree & (planes[FLAT, j] != 0.0)


@vectorized
def find_pairs(strip, first, step, found, counts):
    """Fill found, (n,) uint8, with whether pixels share with both of a pair; count these."""
    # Unsigned, as Numba takes negative numbers from the end, which keeps loops from vectors.
    here, ahead, behind = np.uint64(first), np.uint64(first + step), np.uint64(first - step)
    for i in range(len(found)):
        j = np.uint64(i)
        both = _shares(strip, here + j, ahead + j) & _shares(strip, here + j, behind + j)
        found[i] = both & (strip.planes[FLAT, here + j] != 0.0)
        counts[i] += np.float32(2.0) * np.float32(found[i])


@vectorized
def _add_pairs(found, ahead, behind, sums):
    """Add to sums, (n,), the values of the pairs that were found."""
    for i in range(len(found)):
        sums[i] += ahead[i] + behind[i] if found[i] else np.float32(0.0)


@jit
def _are_enough(strip, first, counts, enough):
    """Return whether all flat pixels of a line have as many partners."""
    for column in range(strip.width):
        if strip.planes[FLAT, first + column] != 0.0 and counts[column] < enough:
            return False
    return True


@jit
def _add_partners(strip, row, found, sums, enough):
    """Add to sums, (N + 1, W), the partners of a line's pixels, until all have enough.

    The last row has their number.
    """
    width, bands, radius = strip.width, strip.light.shape[0], strip.radius
    for y in range(min(min(row, strip.height - 1 - row), int(radius)) + 1):
        for x in range(-int(radius) if y > 0 else 1, int(radius) + 1):
            left, right = abs(x), width - abs(x)
            if x * x + y * y > radius * radius or left >= right:
                continue
            first, last, step = row * width + left, row * width + right, y * width + x
            find_pairs(strip, first, step, found[left:right], sums[bands, left:right])
            for band in range(bands):
                _add_pairs(
                    found[left:right],
                    strip.light[band, first + step : last + step],
                    strip.light[band, first - step : last - step],
                    sums[band, left:right],
                )
        if _are_enough(strip, row * width, sums[bands], enough):
            return


@kernel
def share_irradiance(strip, lines, scratch, pixels, shared):
    """Share indirect irradiance among the pixels of a span of lines and their neighbours.

    Averages go to `shared`, (P, N), and the `indirect` of flat pixels is computed again. `scratch`
    is (W,) uint8, and (N + 1, W) float32.
    """
    (found, sums), bands = scratch, shared.shape[1]
    for line in range(lines.first, lines.last):
        first, pixel = (line - strip.first) * strip.width, line * strip.width
        for column in range(strip.width):
            sums[bands, column] = 1.0
            for band in range(bands):
                sums[band, column] = strip.light[band, first + column]
        _add_partners(strip, line - strip.first, found, sums, math.inf)
        for column in range(strip.width):
            factor = np.float32(1.0 / sums[bands, column])
            for band in range(bands):
                light = sums[band, column] * factor
                shared[pixel + column, band] = light
                if strip.planes[FLAT, first + column] != 0.0:
                    pixels.indirect[pixel + column, band] = (
                        pixels.reflectance[pixel + column, band] * light * np.float32(INV_PI)
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
def count_footprints(strip, lines, scratch, enough, counts):
    """Count the pixels of the footprints of a span of lines, (P,); or say that they are enough.

    `scratch` is that of `share_irradiance`, without bands.
    """
    found, sums = scratch
    for line in range(lines.first, lines.last):
        sums[:] = 1.0
        _add_partners(strip, line - strip.first, found, sums, enough)
        for column in range(strip.width):
            counts[line * strip.width + column] = min(sums[0, column], enough)
