"""A scene: meshes, lights and cameras, in scene units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, shown
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.mesh import Mesh


@dataclass
class Scene:
    """What is rendered. Emitting meshes are lights too.

    Parameters
    ----------
    meshes : the surfaces
    lights : lights that are not surfaces
    camera : what the scene is rendered by: the first of `cameras` by default; None looks at the
        whole scene from +z
    name : used in records
    cameras : all of the scene, if there are several, with names that differ
    """

    meshes: list[Mesh] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    name: str = "scene"
    cameras: list[Camera] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Look by the first camera unless one is given."""
        if self.camera is None and self.cameras:
            self.camera = self.cameras[0]

    @property
    def every_camera(self) -> list[Camera]:
        """The camera in use, and the others, which have other names."""
        if self.camera is None:
            return []
        return [self.camera, *(each for each in self.cameras if each.name != self.camera.name)]

    def seen_by(self, name: str) -> Scene:
        """Return the scene with the camera of a name in use.

        Raises
        ------
        InputError : no camera has this name
        """
        for camera in self.every_camera:
            if camera.name == name:
                return replace(self, camera=camera)
        names = [camera.name for camera in self.every_camera if camera.name]
        known = f"the scene has {listed(names)}" if names else "the scene has no named camera"
        raise InputError(f"there is no camera {shown(name)}; {known}")


def check_names(cameras: Iterable[Camera]) -> None:
    """Check that several cameras have names, which differ.

    Raises
    ------
    InputError : two have the same name, or one has none
    """
    found: set[str] = set()
    for camera in cameras:
        if not camera.name:
            raise InputError("one of several cameras has no name; name each")
        if camera.name in found:
            raise InputError(f"two cameras are named {shown(camera.name)}; name each differently")
        found.add(camera.name)
