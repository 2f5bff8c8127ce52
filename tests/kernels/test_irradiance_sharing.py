"""Sharing keeps means and linear changes, and stops at edges and beyond reach."""

import numpy as np
import pytest
from helpers.estimates import empty_pixels

from photonmap.kernels.core.passes import Film, Span
from photonmap.kernels.film.irradiance_sharing import Footprint, cut_strip, share_irradiance

WIDTH, HEIGHT = 16, 12
FILM = Film(WIDTH, HEIGHT, True)


def flat_wall():
    """A wall that fills the image, one unit a pixel."""
    pixels = empty_pixels(WIDTH * HEIGHT, 2)
    y, x = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    pixels.plane[:] = np.stack([x, -y, 0 * x, 0 * x, 0 * x, 0 * x + 1, 0 * x + 1], axis=1)
    pixels.reflectance[:] = 0.5
    pixels.irradiance_indirect[:] = np.stack([3.0 + x + 2.0 * y, np.ones(x.shape)], axis=1)
    return pixels


def shared(pixels, radius=3.0, sharing_radius=100.0, turn=0.2):
    size = WIDTH * HEIGHT
    reach = np.full(size, sharing_radius, np.float32)
    footprint = Footprint(pixels.plane, reach, 1.0, radius, turn)
    out = np.empty((size, 2), np.float32)
    for lines in (Span(0, 5), Span(5, HEIGHT)):
        strip, scratch = cut_strip(FILM, footprint, lines, pixels.irradiance_indirect)
        share_irradiance(strip, lines, scratch, pixels, out)
    return out


def test_a_linear_change_is_kept():
    pixels = flat_wall()
    out = shared(pixels)
    np.testing.assert_allclose(out, pixels.irradiance_indirect, rtol=1e-5)
    np.testing.assert_allclose(pixels.indirect, 0.5 / np.pi * out, rtol=1e-6)


def test_noise_falls_with_the_window():
    pixels = flat_wall()
    pixels.irradiance_indirect[:] = np.random.default_rng(2).random((WIDTH * HEIGHT, 2))
    inner = shared(pixels).reshape(HEIGHT, WIDTH, 2)[4:-4, 4:-4]
    # 29 pixels lie within 3 of one.
    assert inner.std() < 1.5 * np.sqrt(1 / 12 / 29)


@pytest.mark.parametrize(
    "obstacle", ["normal", "turn", "depth", "edge", "sharing_radius", "radius"]
)
def test_sharing_stops(obstacle):
    pixels = flat_wall()
    right = np.arange(WIDTH * HEIGHT) % WIDTH >= WIDTH // 2
    pixels.irradiance_indirect[:] = np.where(right, 1.0, 0.0)[:, None]
    options = {}
    if obstacle == "normal":
        pixels.plane[right, 3:6] = (1.0, 0.0, 0.0)
    elif obstacle == "turn":
        pixels.plane[right, 3:6] = (np.sin(0.25), 0.0, np.cos(0.25))
    elif obstacle == "depth":
        pixels.plane[right, 2] = 5.0
    elif obstacle == "edge":
        pixels.plane[np.arange(WIDTH * HEIGHT) % WIDTH == WIDTH // 2, 6] = 0.0
        pixels.plane[np.arange(WIDTH * HEIGHT) % WIDTH == WIDTH // 2 - 1, 6] = 0.0
        options["radius"] = 1.5
    elif obstacle == "sharing_radius":
        options["sharing_radius"] = 0.5
    else:
        options["radius"] = 0.9
    before = pixels.irradiance_indirect.copy()
    np.testing.assert_array_equal(shared(pixels, **options), before)
