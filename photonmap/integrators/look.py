"""What cameras see of a scene, without rendering it."""

from __future__ import annotations

import warnings
from collections.abc import Container
from dataclasses import replace
from typing import Any

from numpy.typing import NDArray

from photonmap.buffers import DEFAULT
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import SceneWarning
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.kernels.core.passes import Film
from photonmap.runtime.workers import Workers
from photonmap.scene.camera import Camera
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands


class Onlooker:
    """Looks at a scene with any camera; what is to be said of the scene, its render says.

    Parameters
    ----------
    scene : to look at
    threads : None for one a processor

    Raises
    ------
    InputError : the scene cannot be rendered
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            self._compiled = compile_scene(scene, Bands.parse(1))
        self._threads = threads

    def see(
        self, camera: Camera, size: tuple[int, int], kept: Container[str] = DEFAULT
    ) -> dict[str, NDArray[Any]]:
        """Return the buffers at the pixels' centres, (H, W) or (H, W, 3), as a render has them.

        Parameters
        ----------
        size : width and height, pixels
        kept : names of the buffers
        """
        compiled = replace(self._compiled, camera=camera)
        with Workers(self._threads) as workers:
            rows = first_hit_buffers(compiled, Film(*size, False), workers, kept)
        return {name: row.reshape(size[1], size[0], *row.shape[1:]) for name, row in rows.items()}
