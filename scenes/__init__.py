"""Scenes that come with photonmap, as OBJ, MTL and TOML files and as functions."""

from pathlib import Path

from photonmap.readers.scene_file import load_scene
from photonmap.scene import Scene

FOLDER = Path(__file__).parent


def cornell_box() -> Scene:
    """Return the Cornell box in its common form: 2 units wide, camera at z = 3.9."""
    return load_scene(FOLDER / "cornell_box.obj")


def cornell_box_measured() -> Scene:
    """Return the Cornell box with the measured spectra of its walls and of its lamp."""
    return load_scene(FOLDER / "cornell_box_measured.toml")


def furnace() -> Scene:
    """Return a closed box that emits 0.5 and reflects 0.75: radiance is 2 everywhere."""
    return load_scene(FOLDER / "furnace.obj")


def two_rooms() -> Scene:
    """Return two rooms with the lamp in one, the camera in the other, a door between them."""
    return load_scene(FOLDER / "two_rooms.obj")
