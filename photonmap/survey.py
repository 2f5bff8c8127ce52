"""Decide how much sampling each pixel gets, from a look at the geometry before the passes."""

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import Camera, Film, Geometry, Lights, Optics, Plan, Survey
from photonmap.kernels.share import count_windows
from photonmap.kernels.survey import survey_pixels
from photonmap.workers import Workers

SAMPLES = 4
"""Camera samples a pixel in a pass; a power of two, so that coverage sums to exactly 1."""
EDGE_SAMPLES = 16
"""The same where a pixel shows several surfaces, or a mirror or glass."""
LIGHT_SAMPLES, PENUMBRA_SAMPLES = 4, 16
"""Light samples a pixel, and where some are blocked and some are not."""
GATHERS, LONELY_GATHERS = 4, 32
"""Gather rays a pixel, and where few neighbours share their indirect light with it."""
FEW_PARTNERS = 20
WINDOW = 6.0
"""Radius of the first pass's sharing windows, pixels."""
REACH = 0.2
"""Their radius in space, as a part of the mean distance to what lies around (Ward 1988)."""
TILE = 2048


def survey(
    geometry: Geometry,
    lights: Lights,
    optics: Optics | None,
    camera: Camera,
    film: Film,
    key: np.uint64,
    workers: Workers,
) -> Plan:
    """Look at every pixel and plan its sampling.

    Only geometry and visibility are looked at, with random numbers of their own, so the passes
    that follow are neither biased nor correlated by what is decided here.
    """
    pixels = film.width * film.height
    kinds = np.uint8, np.float32, np.uint8, np.uint8
    look = Survey(*(np.zeros(pixels, kind) for kind in kinds))
    plane = np.zeros((pixels, 7), np.float32)
    workers.ranges(
        lambda first, last: survey_pixels(
            geometry, lights, optics, camera, film, SAMPLES, key, first, last, plane, look
        ),
        pixels,
        TILE,
    )
    nearness = _neighbours(look.nearness, film).mean(axis=0)
    reach = REACH / np.maximum(nearness, 1e-12).astype(np.float32)
    partners = np.zeros(pixels, np.int32)
    nothing = np.zeros((pixels, 0), np.float32)
    workers.ranges(
        lambda first, last: count_windows(
            film, plane, reach, WINDOW, 1.0, first, last, nothing, partners
        ),
        pixels,
        TILE,
    )
    penumbra = _neighbours(look.penumbra, film).max(axis=0) != 0
    smooth = look.smooth != 0
    flat, lonely = (look.flat != 0) & ~smooth, (partners < FEW_PARTNERS) | smooth
    samples = np.where(flat, SAMPLES, EDGE_SAMPLES) if film.jitter else np.ones(pixels, np.int64)
    lights = np.where(penumbra, PENUMBRA_SAMPLES, LIGHT_SAMPLES)
    gathers = np.where(lonely & (flat | smooth), LONELY_GATHERS, GATHERS)
    return Plan(
        samples.astype(np.uint8),
        np.maximum(lights // samples, 1).astype(np.uint8),
        np.maximum(gathers // samples, 1).astype(np.uint8),
        reach,
    )


def _neighbours(values: NDArray, film: Film) -> NDArray:
    """Return each pixel's value and those of its eight neighbours, (9, P)."""
    padded = np.pad(values.reshape(film.height, film.width), 1, mode="edge")
    views = np.lib.stride_tricks.sliding_window_view(padded, (film.height, film.width))
    return views.reshape(9, -1)
