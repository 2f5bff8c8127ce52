"""Scenes that come with photonmap, as OBJ, MTL and TOML files and as functions."""

from dataclasses import replace
from pathlib import Path

from photonmap.io.readers.scene_file import load_scene
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

FOLDER = Path(__file__).parent


def cornell_box() -> Scene:
    """Return the Cornell box in its common form: 2 units wide, camera at z = 3.9."""
    return _load("cornell_box.obj")


def cornell_box_measured() -> Scene:
    """Return the Cornell box with measured spectra of its walls and of its light."""
    return _load("cornell_box_measured.toml")


def cornell_balls() -> Scene:
    """Return the Cornell box with a mirror ball and a glass ball in place of its boxes."""
    box = cornell_box()
    mirror = ball((-0.4, -0.65, -0.3), Material.polished("mirror", 0.9))
    glass = ball((0.4, -0.65, 0.2), Material.glass("glass", 1.5))
    walls = [mesh for mesh in box.meshes if "box" not in mesh.name]
    return replace(box, meshes=[*walls, mirror, glass], name="cornell_balls")


def ball(center: tuple[float, float, float], material: Material) -> Mesh:
    """Return a smooth sphere of radius 0.35 that is named after its material."""
    from trimesh.creation import icosphere

    mesh = icosphere(subdivisions=6, radius=0.35)
    return Mesh(mesh.vertices + center, mesh.faces, material, material.name, mesh.vertices / 0.35)


def furnace() -> Scene:
    """Return a closed box that emits 0.5 and reflects 0.75: radiance is 2 everywhere."""
    return _load("furnace.obj")


def two_rooms() -> Scene:
    """Return two rooms joined by a doorway: the light in one, the camera in the other."""
    return _load("two_rooms.obj")


def _load(name: str) -> Scene:
    """Return a scene; what a user makes of it is not the fault of its file."""
    return replace(load_scene(FOLDER / name), file=None)
