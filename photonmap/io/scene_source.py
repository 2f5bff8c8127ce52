"""A scene file, and what a user chooses in place of what it says."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from photonmap.errors import InputError, SceneWarning

if TYPE_CHECKING:
    from photonmap.scene.scene import Scene


@dataclass(frozen=True)
class SceneSource:
    """Where a scene comes from; can be sent to another process.

    Parameters
    ----------
    path : of the scene file
    missing_textures : "error" or "grey", see `photonmap.load_scene`
    camera : attributes of `photonmap.Camera` that replace those of the file's camera; without one,
        `up` and `fov` hold for the view of the whole scene, and `origin` looks at its middle
    munsell, illuminants : files of measured spectra; None for those that the environment names
    view : the name of one of the file's cameras; None for the first
    root : folder below which all files lie that the scene names; None for its own
    strict : refuse a file that is read with a warning
    """

    path: str
    missing_textures: Literal["error", "grey"] = "error"
    camera: dict[str, Any] = field(default_factory=dict)
    munsell: str | None = None
    illuminants: str | None = None
    view: str | None = None
    root: str | None = None
    strict: bool = False

    def load(self) -> Scene:
        """Load the scene, with the chosen spectra and camera.

        Raises
        ------
        InputError : as `photonmap.load_scene`; strictly, there is a warning; a file of spectra
            cannot be read; there is no camera of the name; or there is no camera to give a
            target alone
        """
        return self.choose(self.read())

    def read(self) -> Scene:
        """Load the scene with the chosen spectra, and the cameras of the file."""
        from photonmap.io.readers.scene_file import load_scene

        use_measured_sets(self.munsell, self.illuminants)
        with refusing_warnings() if self.strict else nullcontext():
            return load_scene(self.path, self.missing_textures, self.root)

    def choose(self, scene: Scene) -> Scene:
        """Return the scene that was read with the chosen camera; `InputError` as `load`."""
        from photonmap.scene.camera import Camera

        scene = replace(scene)
        if self.view is not None:
            scene = scene.seen_by(self.view)
        if scene.camera is not None:
            scene.camera = scene.camera.changed(**self.camera)
        elif "origin" in self.camera:
            scene.camera = Camera(**{"target": scene.middle, **self.camera})
        elif "target" in self.camera:
            raise InputError("the scene has no camera, so --target needs --origin too")
        else:
            for name, value in self.camera.items():
                setattr(scene, name, value)
        return scene

    def views(self, size: tuple[int, int]) -> list[SceneSource]:
        """Return the source once for each of its cameras; for its one view if it has not several.

        Parameters
        ----------
        size : width and height of the images, pixels

        Raises
        ------
        InputError : as `load`; or one of the cameras cannot take an image of this size
        """
        from photonmap.scene.camera import check_image_size

        cameras = [camera for camera in self.load().every_camera if camera.name]
        for camera in cameras:
            check_image_size(camera.changed(**self.camera), size)
        return [replace(self, view=camera.name) for camera in cameras] or [self]


@contextmanager
def refusing_warnings() -> Iterator[None]:
    """Make errors of the warnings about a scene in this context."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        try:
            yield
        except SceneWarning as warning:
            raise InputError(f"{warning} (without --strict, a warning)") from None


def use_measured_sets(munsell_chips: str | None, illuminants: str | None) -> None:
    """Let names of colours refer to files of measured spectra; None leaves what is set."""
    from photonmap.spectra import color_text, munsell

    if munsell_chips:
        os.environ[munsell.VARIABLE] = munsell_chips
        munsell.measured_set()
    if illuminants:
        os.environ[color_text.ILLUMINANTS] = illuminants
        color_text.measured_illuminants()
