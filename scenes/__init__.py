"""Scenes that come with photonmap, as OBJ, MTL and TOML files and as functions."""

from dataclasses import replace
from pathlib import Path

from photonmap.readers.scene_file import load_scene
from photonmap.scene import Material, Mesh, Scene

FOLDER = Path(__file__).parent


def cornell_box() -> Scene:
    """Return the Cornell box in its common form: 2 units wide, camera at z = 3.9."""
    return load_scene(FOLDER / "cornell_box.obj")


def cornell_box_measured() -> Scene:
    """Return the Cornell box with the measured spectra of its walls and of its lamp."""
    return load_scene(FOLDER / "cornell_box_measured.toml")


def cornell_balls() -> Scene:
    """Return the Cornell box with a ball of a mirror and one of glass in place of its boxes."""
    box = cornell_box()
    mirror = _ball((-0.4, -0.65, -0.3), Material.polished("mirror", 0.9))
    glass = _ball((0.4, -0.65, 0.2), Material.glass("glass", 1.5))
    walls = [mesh for mesh in box.meshes if "box" not in mesh.name]
    return replace(box, meshes=[*walls, mirror, glass], name="cornell_balls")


def _ball(center: tuple[float, float, float], material: Material) -> Mesh:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=6, radius=0.35)
    return Mesh(ball.vertices + center, ball.faces, material, material.name, ball.vertices / 0.35)


def furnace() -> Scene:
    """Return a closed box that emits 0.5 and reflects 0.75: radiance is 2 everywhere."""
    return load_scene(FOLDER / "furnace.obj")


def two_rooms() -> Scene:
    """Return two rooms with the lamp in one, the camera in the other, a door between them."""
    return load_scene(FOLDER / "two_rooms.obj")
