"""Build the scenes of a data set from their names and a seed."""

from __future__ import annotations

import zlib

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.scenes.illumination import (
    AnyIllumination,
    Illumination,
    choose_illumination,
    find_illumination,
)
from photonmap.dataset.scenes.outdoors import OUTDOORS
from photonmap.dataset.scenes.random_lights import RandomLights
from photonmap.dataset.scenes.rooms.catalogue import KINDS, ROOMS
from photonmap.dataset.scenes.single_objects import OBJECTS, build_object
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.errors import InputError
from photonmap.runtime.wording import suggest
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands

SCENES = (*OBJECTS, *ROOMS, *OUTDOORS)
"""Names of all scenes: single objects, rooms, and places outdoors."""
PAPER_SCENES = (*OBJECTS, *KINDS)
"""As many objects and rooms as Beigpour et al. 2013 have."""

SCALES = (0.8, 3.0)
"""Smallest and largest factor of the size of rooms."""

LARGEST_SEED = 2**63 - 1
"""The largest seed of a scene."""


def build_scene(
    name: str,
    seed: int = 0,
    illumination: AnyIllumination = "white",
    materials: str = "lambertian",
    lightness: float | None = None,
    scale: float = 1.0,
) -> Scene:
    """Build a scene; equal arguments give equal arrays.

    The illumination changes the emitters alone: shapes, positions and reflectances depend on the
    name, the seed and the materials. The lightness changes only the reflectances.

    Parameters
    ----------
    name : one of `SCENES`
    seed : draws shapes, positions, reflectances, and the colours of the illumination
    illumination : one of `photonmap.dataset.scenes.illumination.NAMED`, or your own
    materials : one of `photonmap.dataset.models.materials.MATERIALS`: "lambertian", or
        "mixed" with glazes, mirrors and glass, "textured" with wood, cloth, stone and prints,
        "glossy" with rough varnish and metal, "rich" with both, or "fluorescent" with brightened
        paper and textiles and dyes
    lightness : mean reflectance over the area of all surfaces, from 0 to 1; None for that of the
        chips as they are drawn
    scale : factor of a room's size; single objects have theirs

    Returns
    -------
    Scene in metres, y up, with a camera; the material of an emitter is named after its light group

    Raises
    ------
    InputError : the scene, illumination or materials are unknown, or a number is out of range
    """
    unlit = build_unlit_scene(name, seed, materials, lightness, scale)
    return unlit.lit(draw_illumination(name, seed, illumination))


def draw_illumination(
    name: str, seed: int, illumination: AnyIllumination = "white", bands: Bands | None = None
) -> Illumination:
    """Draw the lights of an illumination for a scene name and seed; see `build_scene`.

    Of those that are known in all bands, if these are given.
    """
    found = find_illumination(illumination)
    purpose = f"{found.name} light" if isinstance(found, RandomLights) else "light"
    return choose_illumination(found, _random(f"{purpose} of {name}", seed), bands)


def build_unlit_scene(
    name: str,
    seed: int = 0,
    materials: str = "lambertian",
    lightness: float | None = None,
    scale: float = 1.0,
) -> UnlitScene:
    """Build a scene whose emitters are off, to light it in several ways; see `build_scene`."""
    if name not in SCENES:
        raise InputError(f"there is no scene {name!r}; {suggest(str(name), SCENES)}")
    check_looks(lightness, scale)
    draw = Draw(_random(name, seed), materials, lightness)
    if build := {**ROOMS, **OUTDOORS}.get(name):
        return build(draw, scale)
    return build_object(name, draw)


def check_looks(lightness: float | None = None, scale: float = 1.0) -> None:
    """Raise `InputError` if the lightness of a scene or the scale of a room is out of range."""
    if lightness is not None and not 0.0 < lightness < 1.0:
        raise InputError(f"lightness {lightness:g} must be between 0 and 1")
    if not SCALES[0] <= scale <= SCALES[1]:
        raise InputError(f"scale {scale:g} must be from {SCALES[0]:g} to {SCALES[1]:g}")


def _random(name: str, seed: int) -> np.random.Generator:
    """Return a random generator for a purpose and a seed."""
    if not isinstance(seed, int | np.integer) or not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed {seed!r} must be a whole number from 0 to {LARGEST_SEED}")
    return np.random.Generator(np.random.PCG64([int(seed), zlib.crc32(name.encode())]))
