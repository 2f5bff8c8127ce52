"""A scene: meshes, lights and cameras, in scene units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from photonmap.errors import InputError, warn
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.camera import FOV, Camera, check_camera
from photonmap.scene.lights import AreaLight, Light, area_meshes
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Vector
from photonmap.scene.textures import is_black, mean_color
from photonmap.spectra.curves import Color

T = TypeVar("T")

_REMEDY = "make a mesh by photonmap.Mesh or Mesh.from_trimesh, read a file by photonmap.load_scene"


@dataclass(repr=False)
class Scene:
    """What is rendered. Emitting meshes are lights too.

    Parameters
    ----------
    meshes : the surfaces
    lights : lights that are not surfaces; each `AreaLight` among them becomes one of the meshes
    camera : what the scene is rendered by: the first of `cameras` by default; None looks at the
        whole scene from the front, right and above
    name : used in records
    cameras : all of the scene, if there are several, with names that differ
    up : direction that is up where there is no camera; (0, 0, 1) for many files of CAD
    fov : full vertical angle of view where there is no camera, degrees
    file : from which it was loaded, named in errors; None for a scene of your own
    """

    meshes: list[Mesh] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    name: str = "scene"
    cameras: list[Camera] = field(default_factory=list)
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = FOV
    file: str | None = field(default=None, compare=False)
    lights_file: str | None = field(default=None, compare=False)
    """the TOML file of lights, named in their errors; None if they are of `file` or of none"""

    if TYPE_CHECKING:

        def __init__(
            self,
            meshes: Mesh | Sequence[Mesh] = ...,
            lights: Light | Sequence[Light] = ...,
            camera: Camera | None = None,
            name: str = "scene",
            cameras: Sequence[Camera] = ...,
            up: Vector = ...,
            fov: float = ...,
            file: str | None = None,
        ) -> None:
            """Take a mesh or a light where there is but one."""

    def __post_init__(self) -> None:
        """Look by the first camera unless one is given.

        Raises
        ------
        InputError : there are other things than meshes among the meshes, there is no list, an
            area light is not valid, or several cameras do not have different names
        """
        self.meshes = _listed(self.meshes, Mesh)
        self.lights = _listed(self.lights, Light)
        self.cameras = _listed(self.cameras, Camera)
        for mesh in self.meshes:
            if not isinstance(mesh, Mesh):
                raise InputError(f"{shown(mesh)} is not a mesh; {_REMEDY}")
        if areas := [light for light in self.lights if isinstance(light, AreaLight)]:
            self.meshes = [*self.meshes, *area_meshes(areas, self.meshes)]
            self.lights = [light for light in self.lights if not isinstance(light, AreaLight)]
        if len(self.cameras) > 1:
            check_names(self.cameras)
        if self.camera is None and self.cameras:
            self.camera = self.cameras[0]

    @classmethod
    def from_trimesh(cls, scene: Any, name: str = "scene", smooth: bool = False) -> Scene:
        """Return the meshes of a `trimesh.Scene`, one for each node, and its camera if it has one.

        Parameters
        ----------
        scene : its lights are not taken; what is not a mesh is left out, with a warning
        name : of the result
        smooth : whether meshes get trimesh's vertex normals
        """
        meshes: list[Mesh] = []
        materials: dict[str, Material] = {}
        others = 0
        for node in scene.graph.nodes_geometry:
            matrix, key = scene.graph[node]
            if not hasattr(scene.geometry[key], "faces"):
                others += 1
                continue
            moved = scene.geometry[key].copy()
            moved.apply_transform(matrix)
            mesh = Mesh.from_trimesh(moved, name=node, smooth=smooth)
            material = materials.setdefault(key, mesh.material)
            meshes.append(replace(mesh, material=material))
        if others:
            warn(f"scene {shown(name)}: {others} geometries that are no meshes are left out")
        return cls(meshes, camera=_camera(scene) if scene.has_camera else None, name=name)

    def __repr__(self) -> str:
        faces = sum(len(mesh.faces) for mesh in self.meshes)
        emissions = [mesh.material.emission for mesh in self.meshes]  # unchecked
        emitting = sum(isinstance(each, str) or not is_black(each) for each in emissions)
        meshes = f"{len(self.meshes)} meshes{f' (emitting: {emitting})' if emitting else ''}"
        lights = f"{len(self.lights)} {'other ' if emitting else ''}lights"
        view = "no camera" if self.camera is None else f"camera at {self.camera.origin}"
        return f"<Scene {self.name!r}: {meshes} of {faces} triangles, {lights}, {view}>"

    @property
    def every_camera(self) -> list[Camera]:
        """The camera in use, and the others, which have other names."""
        if self.camera is None:
            return []
        return [self.camera, *(each for each in self.cameras if each.name != self.camera.name)]

    @property
    def light_colors(self) -> list[tuple[str, Color]]:
        """The names and colours of emitting materials and of lights.

        Of a texture its mean, of a light whose colours are an image white.
        """
        paints = {id(mesh.material): mesh.material for mesh in self.meshes}.values()
        shining = [(each.name, mean_color(each.emission)) for each in paints]
        lights = [(light.name or light.kind, light.color) for light in self.lights]
        return [(name, color) for name, color in shining + lights if not is_black(color)]

    @property
    def middle(self) -> Vector:
        """The middle of the box around all vertices, scene units; (0, 0, 0) without any."""
        parts = [mesh.vertices for mesh in self.meshes if len(mesh.vertices)]
        if not parts:
            return 0.0, 0.0, 0.0
        low = np.min([vertices.min(axis=0) for vertices in parts], axis=0)
        high = np.max([vertices.max(axis=0) for vertices in parts], axis=0)
        x, y, z = (0.5 * low + 0.5 * high).tolist()
        return x, y, z

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

    def seen_by_each(self, cameras: Sequence[Camera | str] | None = None) -> list[Scene]:
        """Return the scene once with each of some cameras in use.

        Parameters
        ----------
        cameras : any cameras, or names of the scene's own; None for all that it has

        Raises
        ------
        InputError : there are none, one is not valid, or no camera has a name
        """
        chosen = self.every_camera if cameras is None else cameras
        if isinstance(chosen, Camera | str):
            chosen = [chosen]
        if not isinstance(chosen, list | tuple) or not chosen:
            remedy = "give some, as in cameras=[photonmap.Camera((0, 0, 3), (0, 0, 0))]"
            raise InputError(f"there are no cameras to render by; {remedy}")
        return [
            self.seen_by(each)
            if isinstance(each, str)
            else replace(self, camera=check_camera(each))
            for each in chosen
        ]

    def with_materials(self, materials: Mapping[str, Material]) -> Scene:
        """Return the scene with other materials for some of its objects.

        Parameters
        ----------
        materials : by names of meshes; all of a name get the material, and lose their `colors`

        Raises
        ------
        InputError : no mesh has one of the names
        """
        names = dict.fromkeys(mesh.name for mesh in self.meshes)
        for name in materials:
            if name not in names:
                raise InputError(f"there is no mesh {shown(name)}; {suggest(name, names)}")
        painted = [
            replace(mesh, material=materials[mesh.name], colors=None)
            if mesh.name in materials
            else mesh
            for mesh in self.meshes
        ]
        return replace(self, meshes=painted)


def _camera(scene: Any) -> Camera:
    """Return the camera of a `trimesh.Scene`, which looks along its -z."""
    matrix = scene.camera_transform
    origin, ahead, up = matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1]
    return Camera(
        tuple(origin.tolist()),
        tuple((origin + ahead).tolist()),
        tuple(up.tolist()),
        fov=float(scene.camera.fov[1]),
    )


def check_scene(scene: object) -> Scene:
    """Return a scene; anything else is an `InputError`."""
    if isinstance(scene, Scene):
        return scene
    raise InputError(f"{shown(scene)} is not a scene; give a photonmap.Scene, as in Scene([mesh])")


def _listed(values: Any, kind: type[T]) -> list[T]:
    """Return a list of what is given: one thing of a kind, or several in a sequence."""
    if isinstance(values, kind):
        return [values]
    if isinstance(values, list | tuple):
        return values if isinstance(values, list) else [*values]
    name = kind.__name__
    raise InputError(f"{shown(values)} is not a list of photonmap.{name}; {_REMEDY}")


def check_names(cameras: Iterable[Camera]) -> None:
    """Check that several cameras have names, which differ, or raise `InputError`."""
    found: set[str] = set()
    for camera in cameras:
        if not camera.name:
            raise InputError("one of several cameras has no name; name each")
        if camera.name in found:
            raise InputError(f"two cameras are named {shown(camera.name)}; name each differently")
        found.add(camera.name)
