"""How much scenes differ: the correlation of what their cameras see."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.scene.scene import Scene
from photonmap.scene.textures import mean_color
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.observer import luminance


class Appearance(NamedTuple):
    """What a scene's camera sees, without its light: logarithms by pixel, (H, W) float64."""

    depth: NDArray[np.float64]
    reflectance: NDArray[np.float64]


def appearance_of(scene: Scene, size: tuple[int, int] = (32, 24)) -> Appearance:
    """Return the logarithms of distance and of luminous reflectance that a scene's camera sees.

    Parameters
    ----------
    size : width and height of the maps, pixels

    Raises
    ------
    InputError : the scene has no camera, or cannot be rendered
    """
    if scene.camera is None:
        raise InputError(f"scene {scene.name!r} has no camera; give it one")
    seen = Onlooker(scene).see(scene.camera, size, ("distance", "material_id"))
    materials = list({mesh.material.name: mesh.material for mesh in scene.meshes}.values())
    paints = [material.reflectance for material in materials]
    lightness = [luminance(p if isinstance(p, Spectrum) else mean_color(p)) for p in paints]
    hit = seen["material_id"] > 0
    depth = np.where(hit, seen["distance"], seen["distance"].max())
    shade = np.where(hit, np.array([1.0, *lightness])[seen["material_id"]], 1.0)
    return Appearance(np.log(np.maximum(depth, 1e-6)), np.log(np.maximum(shade, 0.01)))


def correlations(maps: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the correlation of each pair of maps of equal shape, (n, n)."""
    return np.corrcoef([each.ravel() for each in maps])


def nearest_neighbours(maps: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the correlation of each map with the one that is most like it, (n,)."""
    found = correlations(maps)
    np.fill_diagonal(found, -np.inf)
    return found.max(axis=1)
