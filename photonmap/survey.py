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
from photonmap.workers import Workers

SAMPLES = 4
"""Camera samples of a pixel in a survey, and in a pass; a power of two, as coverage sums to 1."""
EDGE_SAMPLES = 16
"""The same where a pixel shows several surfaces, or a mirror or glass."""
EVEN_LIGHT_SAMPLES, LIGHT_SAMPLES, PENUMBRA_SAMPLES = 4, 4, 16
"""Light samples of a pixel: of lamps that are alike, of others, and where something blocks some."""
GATHERS, MOST_GATHERS = 8, 64
"""Gather rays of a pixel, and where few neighbours share their indirect light with it."""
SHARED_GATHERS = 256
"""Gather rays of all that share their light, where a pixel's own are not too many."""
WINDOW = 6.0
"""Radius of the first pass's sharing windows, pixels."""
REACH = 0.2
"""Their radius in space, as a part of the mean distance to what lies around (Ward 1988)."""
TILE = 2048


def survey(
    scene: SceneArrays, camera: Camera, film: Film, key: np.uint64, workers: Workers
) -> Plan:
    """Look at every pixel and plan its sampling.

    Only geometry and visibility are looked at, with random numbers of their own, so the passes
    that follow are neither biased nor correlated by what is decided here.
    """
    geometry, _, lights, optics, _ = scene
    textured = _textured_materials(scene)
    pixels = film.width * film.height
    kinds = np.uint8, np.uint8, np.float32, np.uint8, np.uint8
    look = Survey(*(np.zeros(pixels, kind) for kind in kinds))
    plane = np.zeros((pixels, 7), np.float32)
    workers.ranges(
        lambda first, last: survey_pixels(
            geometry, lights, optics, textured, camera, film, SAMPLES, key, first, last, plane, look
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
    flat, even, smooth = look.flat != 0, look.even != 0, look.smooth != 0
    gathers = np.clip(2 ** np.ceil(np.log2(SHARED_GATHERS / partners)), GATHERS, MOST_GATHERS)
    gathers[smooth | ~flat] = MOST_GATHERS
    samples = np.where(flat & ~smooth, SAMPLES, EDGE_SAMPLES)
    samples[even & ~penumbra & (gathers == GATHERS)] = 1
    if not film.jitter:
        samples[:] = 1
    lamps = np.where(penumbra, PENUMBRA_SAMPLES, _light_samples(lights))
    return Plan(
        samples.astype(np.uint16),
        np.maximum(lamps // samples, 1).astype(np.uint16),
        np.maximum(gathers // samples, 1).astype(np.uint16),
        reach,
    )


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
    """Return how many light samples a pixel gets where nothing blocks any."""
    varied = lights.environment or lights.glow or lights.tree
    alike = not varied and len(np.unique(lights.spectrum)) == 1
    return EVEN_LIGHT_SAMPLES if alike else LIGHT_SAMPLES


def _neighbours(values: NDArray, film: Film) -> NDArray:
    """Return each pixel's value and those of its eight neighbours, (9, P)."""
    padded = np.pad(values.reshape(film.height, film.width), 1, mode="edge")
    views = np.lib.stride_tricks.sliding_window_view(padded, (film.height, film.width))
    return views.reshape(9, -1)
