"""Decide how much sampling each pixel gets, from a look at the geometry before the passes."""

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import (
    Camera,
    Film,
    Lights,
    Plan,
    SceneArrays,
    Survey,
)
from photonmap.kernels.share import count_windows
from photonmap.kernels.survey import survey_pixels
from photonmap.storage import RAM, Storage
from photonmap.workers import Workers

SAMPLES = 4
"""Camera samples of a pixel in a pass; a power of two, as coverage sums to 1."""
EDGE_SAMPLES = 16
"""The same where a pixel shows several surfaces, or a mirror or glass."""
LIGHT_SAMPLES, PENUMBRA_SAMPLES = 4, 32
"""Light samples of a pixel, and where some are blocked and some are not."""
MIXED_LIGHT_SAMPLES = 16
"""Where one tells little of all light: of a sky, of lamps of several colours, of many."""
GATHERS, MOST_GATHERS = 8, 64
"""Gather rays of a pixel, and where few neighbours share their indirect light with it."""
SHARED_GATHERS = 256
"""Gather rays of all that share their light, where a pixel's own are not too many."""
WINDOW = 6.0
"""Radius of the first pass's sharing windows, pixels."""
REACH = 0.2
"""Their radius in space, as a part of the mean distance to what lies around (Ward 1988)."""
TILE = 2048
LINES = 64
"""Lines of the image that are planned at a time."""


def survey(
    scene: SceneArrays,
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
    geometry, _, lights, optics, _ = scene
    textured = _textured_materials(scene)
    pixels = film.width * film.height
    kinds = np.uint8, np.uint8, np.float32, np.uint8, np.uint8
    look = Survey(*(storage.zeros(pixels, kind) for kind in kinds))
    plane = storage.zeros((pixels, 7))
    workers.ranges(
        lambda first, last: survey_pixels(
            geometry, lights, optics, textured, camera, film, key, first, last, plane, look
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
    least = 1 if optics is None else SAMPLES  # caustics vary within a pixel
    lit = _light_samples(lights)
    workers.ranges(
        lambda first, last: _plan_samples(film, look, partners, least, lit, first, last, plan),
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
    film: Film,
    look: Survey,
    partners: NDArray[np.int32],
    least: int,
    lit: int,
    first: int,
    last: int,
    plan: Plan,
) -> None:
    """Decide on the samples of the pixels of lines first..last.

    `least` samples of the camera, and `lit` of lights outside of penumbrae, at the least.
    """
    lines = slice(first * film.width, last * film.width)
    penumbra = _neighbours(look.penumbra, film, first, last).max(axis=0) != 0
    flat, even, smooth = (part[lines] != 0 for part in (look.flat, look.even, look.smooth))
    gathers = 2 ** np.ceil(np.log2(SHARED_GATHERS / partners[lines])).astype(int)
    gathers = np.where(smooth | ~flat, MOST_GATHERS, np.clip(gathers, GATHERS, MOST_GATHERS))
    samples = np.where(flat & ~smooth, SAMPLES, EDGE_SAMPLES)
    samples[even & ~penumbra & (gathers == GATHERS)] = least
    if not film.jitter:
        samples[:] = 1
    lights = np.where(penumbra, PENUMBRA_SAMPLES, lit)
    plan.samples[lines] = samples
    plan.lights[lines] = np.maximum(lights // samples, 1)
    plan.gathers[lines] = np.maximum(gathers // samples, 1)


def _textured_materials(scene: SceneArrays) -> NDArray[np.uint8]:
    """Tell of each material, (M,), whether its looks vary over a surface."""
    geometry, materials, lights, _, textures = scene
    textured = np.zeros(len(materials.reflectance), bool)
    if textures is not None:
        textured |= textures.reflectance >= 0
    if geometry.alpha is not None:
        textured |= geometry.alpha.image >= 0
    if lights.glow is not None:
        textured |= lights.glow.slot[: len(textured)] >= 0
    return textured.astype(np.uint8)


def _light_samples(lights: Lights) -> int:
    """Return how many light samples a pixel gets outside of penumbrae."""
    many = lights.tree or lights.environment or lights.glow
    mixed = many or len(np.unique(lights.spectrum)) > 1
    return MIXED_LIGHT_SAMPLES if mixed else LIGHT_SAMPLES


def _neighbours(values: NDArray, film: Film, first: int, last: int) -> NDArray:
    """Return the values of the pixels of lines first..last and of their eight neighbours, (9, L).

    The image's edges are doubled.
    """
    lines = np.clip(np.arange(first - 1, last + 1), 0, film.height - 1)
    image = values.reshape(film.height, film.width)[lines]
    padded = np.pad(image, ((0, 0), (1, 1)), mode="edge")
    views = np.lib.stride_tricks.sliding_window_view(padded, (last - first, film.width))
    return views.reshape(9, -1)
