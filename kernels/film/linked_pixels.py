"""Irradiance sharing without bias: neighbouring pixels correct for how their irradiance differs.

With D the estimated difference of indirect irradiance from a pixel to its neighbour, each pixel's
irradiance E is replaced, again and again, by a mean of what it and its neighbours k say of it:

    E_i ← E_i + Σ_k w_ik (E_k − D_ik − E_i).

As D is unbiased, every round keeps the mean of E in each pixel, while the noise spreads over ever
more of them (Rousselle et al. 2016, "Image-space control variates for rendering"). The weights
depend on the sampling pre-pass alone, never on estimates: 1/5 between pixels that show the same
flat surface, and less between others, whose differences are noisy themselves.
"""

import numpy as np

from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.camera.cameras import first_hit, generate_ray
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.film.irradiance_sharing import may_share

NEIGHBOURS = 4  # Right, lower, left, upper: the bits of links and the rows of differences
WEIGHT, WEAK_WEIGHT = np.float32(1.0 / 5.0), np.float32(1.0 / 20.0)
"""Of neighbours that show the same flat surface, and of others"""
UNSEEN = np.float32(-1.0)  # In place of a reflectance, where there is no surface


@jit
def step_to(number):
    """Return the step to a neighbour, (columns, rows)."""
    sign = 1 - (number & 2)
    return (sign, 0) if number & 1 == 0 else (0, sign)


@jit
def neighbour(film, pixel, number):
    """Return the pixel that is a neighbour, or -1 outside the image."""
    x, y = step_to(number)
    column, row = pixel % film.width + x, pixel // film.width + y
    if 0 <= column < film.width and 0 <= row < film.height:
        return row * film.width + column
    return -1


@kernel
def link_pixels(film, footprint, span, flat, links):
    """Fill links, (P,) uint8: bits of neighbours on the same `flat`, (P,), surface."""
    for pixel in range(span.first, span.last):
        links[pixel] = 0
        for number in range(NEIGHBOURS):
            other = neighbour(film, pixel, number)
            if other >= 0 and flat[pixel] and flat[other] and may_share(footprint, pixel, other):
                links[pixel] |= np.uint8(1 << number)


@kernel
def average_linked(film, links, span, differences, source, target):
    """Fill target, (P, N), of a span with the mean of what pixels and neighbours say of source."""
    for pixel in range(span.first, span.last):
        for band in range(target.shape[1]):
            target[pixel, band] = source[pixel, band]
        for number in range(NEIGHBOURS):
            other, back = neighbour(film, pixel, number), 1 + (number ^ 2)
            if other < 0:
                continue
            weight = WEIGHT if links[pixel] >> number & 1 else WEAK_WEIGHT
            for band in range(target.shape[1]):
                step = differences[1 + number, pixel, band] - differences[back, other, band]
                target[pixel, band] += weight * (source[other, band] - step - source[pixel, band])


@kernel
def replace_linked(span, reflectance, own, shared, pixels):
    """Replace a pixel's own irradiance by the shared one, in its sums: all (P, N).

    `reflectance`, that of `fill_centre_reflectance`, is independent of both, so the mean is kept. A
    pixel whose centre sees nothing keeps its own irradiance.
    """
    for pixel in range(span.first, span.last):
        if reflectance[pixel, 0] == UNSEEN:
            continue
        for band in range(shared.shape[1]):
            step = shared[pixel, band] - own[pixel, band]
            pixels.irradiance_indirect[pixel, band] += step
            pixels.indirect[pixel, band] += reflectance[pixel, band] * step * np.float32(INV_PI)


@kernel
def fill_centre_reflectance(scene, view, span, reflectance):
    """Fill reflectance, (P, N), with that at the pixels' centres, UNSEEN where there is nothing."""
    width = view.film.width
    for pixel in range(span.first, span.last):
        ray = generate_ray(view.camera, pixel % width + 0.5, pixel // width + 0.5)
        hit = first_hit(scene.geometry, ray)
        for band in range(reflectance.shape[1]):
            reflectance[pixel, band] = UNSEEN
        if hit.triangle >= 0:
            color = look_up_material(scene, hit)
            for band in range(reflectance.shape[1]):
                reflectance[pixel, band] = albedo(scene, color, band)
