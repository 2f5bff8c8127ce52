"""Build the scenes of a data set from their names and a seed."""

from __future__ import annotations

import zlib

import numpy as np

from photonmap.dataset.lighting import Illumination, choose_illumination
from photonmap.dataset.objects import OBJECTS, build_object
from photonmap.dataset.palette import Palette
from photonmap.dataset.rooms import ROOMS
from photonmap.dataset.setting import Setting
from photonmap.errors import InputError
from photonmap.messages import suggest
from photonmap.scene import Scene

SCENES = (*OBJECTS, *ROOMS)
"""Names of all scenes: single objects, then rooms."""

PRESETS = {"icip2013": SCENES, "small": ("jug", "boulder", "living_room", "pottery")}
"""Lists of scenes: as many objects and rooms as Beigpour et al. (ICIP 2013) have; and a few."""

LARGEST_SEED = 2**63 - 1


def build_scene(
    name: str,
    seed: int = 0,
    illumination: str | Illumination = "white",
    materials: str = "lambertian",
) -> Scene:
    """Build a scene; the same arguments give the same arrays.

    The illumination changes the lamps alone: shapes, places and reflectances depend on the name,
    the seed and the materials.

    Parameters
    ----------
    name : one of `SCENES`
    seed : draws shapes, places, reflectances, and the colours of an illumination
    illumination : one of `photonmap.dataset.lighting.ILLUMINATIONS`, or one of your own
    materials : "lambertian", or "mixed", with glazes, mirrors and glass

    Returns
    -------
    Scene in metres, y up, with a camera; lamps are meshes whose material is named after their group

    Raises
    ------
    InputError : there is no such scene, illumination or material, or the seed is out of range
    """
    setting = build_setting(name, seed, materials)
    return setting.lit(draw_illumination(name, seed, illumination))


def draw_illumination(
    name: str, seed: int, illumination: str | Illumination = "white"
) -> Illumination:
    """Draw the colours of an illumination for a scene's name and seed; see `build_scene`."""
    return choose_illumination(illumination, _random(f"light of {name}", seed))


def build_setting(name: str, seed: int = 0, materials: str = "lambertian") -> Setting:
    """Build a scene whose lamps are off, to light it in several ways; see `build_scene`."""
    if name not in SCENES:
        raise InputError(f"there is no scene {name!r}; {suggest(str(name), SCENES)}")
    rng = _random(name, seed)
    palette = Palette(rng.spawn(1)[0], materials)
    return ROOMS[name](rng, palette) if name in ROOMS else build_object(name, rng, palette)


def _random(name: str, seed: int) -> np.random.Generator:
    """Return random numbers for a purpose and a seed."""
    if not isinstance(seed, int | np.integer) or not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed {seed!r} must be a whole number from 0 to {LARGEST_SEED}")
    return np.random.Generator(np.random.PCG64([int(seed), zlib.crc32(name.encode())]))
