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


def build_setting(name: str, seed: int = 0, materials: str = "lambertian") -> Setting:
    if name not in SCENES:
        raise InputError(f"there is no scene {name!r}; {suggest(name, SCENES)}")
    rng = _random(name, seed)
    palette = Palette(rng.spawn(1)[0], materials)
    return ROOMS[name](rng, palette) if name in ROOMS else build_object(name, rng, palette)


def build_scene(
    name: str,
    seed: int = 0,
    illumination: str | Illumination = "white",
    materials: str = "lambertian",
) -> Scene:
    chosen = choose_illumination(illumination, _random(f"{name} {illumination}", seed))
    return build_setting(name, seed, materials).lit(chosen)


def _random(name: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a scene and a seed."""
    return np.random.Generator(np.random.PCG64([seed, zlib.crc32(name.encode())]))
