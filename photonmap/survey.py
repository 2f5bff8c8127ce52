"""Decide how much sampling each pixel gets, from a look at the geometry before the passes."""

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import Camera, Film, Geometry, Lights, Optics, Plan, Survey
from photonmap.kernels.share import count_windows
from photonmap.kernels.survey import survey_pixels
from photonmap.storage import RAM, Storage
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
LINES = 64
"""Lines of the image that are planned at a time."""


def survey(
    geometry: Geometry,
    lights: Lights,
    optics: Optics | None,
    camera: Camera,
    film: Film,
    key: np.uint64,
    workers: Workers,
    storage: Storage = RAM,
) -> Plan:
    """Look at every pixel and plan its sampling.

    Only geometry and visibility are looked at, with random numbers of their own, so the passes
    that follow are neither biased nor correlated by what is decided here.
    """
    pixels = film.width * film.height
    kinds = np.uint8, np.float32, np.uint8, np.uint8
    look = Survey(*(storage.zeros(pixels, kind) for kind in kinds))
    plane = storage.zeros((pixels, 7))
    workers.ranges(
        lambda first, last: survey_pixels(
            geometry, lights, optics, camera, film, SAMPLES, key, first, last, plane, look
        ),
        pixels,
        TILE,
    )
    plan = Plan(*(storage.zeros(pixels, np.uint8) for _ in range(3)), storage.zeros(pixels))
    workers.ranges(
        lambda first, last: _plan_reach(film, look, first, last, plan), film.height, LINES
    )
    partners = storage.zeros(pixels, np.int32)
    nothing = np.zeros((pixels, 0), np.float32)
    workers.ranges(
        lambda first, last: count_windows(
            film, plane, plan.reach, WINDOW, 1.0, first, last, nothing, partners
        ),
        pixels,
        TILE,
    )
    workers.ranges(
        lambda first, last: _plan_samples(film, look, partners, first, last, plan),
        film.height,
        LINES,
    )
    return plan


def _plan_reach(film: Film, look: Survey, first: int, last: int, plan: Plan) -> None:
    """Decide how far the pixels of lines first..last share."""
    nearness = _neighbours(look.nearness, film, first, last).mean(axis=0)
    lines = slice(first * film.width, last * film.width)
    plan.reach[lines] = REACH / np.maximum(nearness, 1e-12).astype(np.float32)


def _plan_samples(
    film: Film, look: Survey, partners: NDArray[np.int32], first: int, last: int, plan: Plan
) -> None:
    """Decide on the samples of the pixels of lines first..last."""
    lines = slice(first * film.width, last * film.width)
    penumbra = _neighbours(look.penumbra, film, first, last).max(axis=0) != 0
    smooth = look.smooth[lines] != 0
    flat, lonely = (look.flat[lines] != 0) & ~smooth, (partners[lines] < FEW_PARTNERS) | smooth
    samples = np.where(flat, SAMPLES, EDGE_SAMPLES) if film.jitter else np.ones(len(flat), int)
    lights = np.where(penumbra, PENUMBRA_SAMPLES, LIGHT_SAMPLES)
    gathers = np.where(lonely & (flat | smooth), LONELY_GATHERS, GATHERS)
    plan.samples[lines] = samples
    plan.lights[lines] = np.maximum(lights // samples, 1)
    plan.gathers[lines] = np.maximum(gathers // samples, 1)


def _neighbours(values: NDArray, film: Film, first: int, last: int) -> NDArray:
    """Return the values of the pixels of lines first..last and of their eight neighbours, (9, L).

    The image's edges are doubled.
    """
    lines = np.clip(np.arange(first - 1, last + 1), 0, film.height - 1)
    image = values.reshape(film.height, film.width)[lines]
    padded = np.pad(image, ((0, 0), (1, 1)), mode="edge")
    views = np.lib.stride_tricks.sliding_window_view(padded, (last - first, film.width))
    return views.reshape(9, -1)
