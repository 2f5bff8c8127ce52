"""Pixels that show one reflectance and one piece of surface."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.results.result import Result
from photonmap.scene.projections import RayMap
from photonmap.scene.scene import Scene

Mask = NDArray[np.bool_]

_RAYS = 3
"""Rays along each side of a pixel."""
_REACH = 2
"""How far from a pixel's centre its rays reach, in rays: a sixth of a pixel beyond its sides."""
_BEND = np.cos(np.radians(20.0))
"""Least cosine between the normals of one piece of surface in a pixel."""
_STEP = 0.5
"""Largest step in depth within a piece of surface, in widths of a pixel at its distance."""


def one_piece(scene: Scene, size: tuple[int, int], at_centre: bool = False) -> Mask:
    """Return the pixels that show one piece of surface, of one object and material: (H, W).

    5×5 rays through each pixel and just beside it meet the same object and material, with normals
    within 20° and no step in depth.

    Parameters
    ----------
    scene : with a camera
    size : width and height, pixels
    at_centre : samples pass through the pixels' centres alone, where there is one surface

    Raises
    ------
    InputError : the scene has no camera
    """
    onlooker, (width, height), camera = Onlooker(scene), size, scene.camera
    if camera is None:
        raise InputError("the scene has no camera; give it one, and render it by that")
    if at_centre or isinstance(camera.projection, RayMap):
        there = onlooker.see(camera, size, ("object_id",))["object_id"] > 0
        return there & at_centre
    names = ("object_id", "material_id", "normal", "depth")
    seen = onlooker.see(camera, (_RAYS * width, _RAYS * height), names)
    padded = {
        name: np.pad(image, ((1, 1), (1, 1), (0, 0))[: image.ndim], mode="edge")
        for name, image in seen.items()
    }

    def at(name: str, row: int, column: int) -> NDArray[np.float64]:
        """Return the values of the rays so far from the pixels' centres."""
        first, other = row + _REACH, column + _REACH
        return padded[name][first::_RAYS, other::_RAYS][:height, :width].astype(np.float64)

    normal, depth = at("normal", 0, 0), at("depth", 0, 0)
    pure = at("object_id", 0, 0) > 0
    near = range(-_REACH, _REACH + 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        for row, column in product(near, near):
            for name in ("object_id", "material_id"):
                pure &= at(name, row, column) == at(name, 0, 0)
            pure &= (at("normal", row, column) * normal).sum(axis=-1) >= _BEND
            opposite = 1.0 / at("depth", row, column) + 1.0 / at("depth", -row, -column)
            pure &= np.abs(opposite * depth - 2.0) <= _STEP / height
    return pure


def pure_pixels(result: Result, scene: Scene, pieces: Mask | None = None) -> Mask:
    """Return where `one_piece` holds, no pass saw another reflectance, and surfaces cover it.

    Parameters
    ----------
    pieces : what `one_piece` returns, where it is known
    """
    if pieces is None:
        pieces = one_piece(scene, result.size, result.record["arguments"]["pixel"] == "center")
    pure = pieces & (result.coverage == 1.0)
    spread = result.errors.get("reflectance")
    return pure if spread is None else pure & (spread == 0.0).all(axis=-1)
