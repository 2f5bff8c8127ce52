"""Read scenes of Mitsuba, versions 2 and 3, and those of 0.x whose names differ."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from photonmap.io.readers.decoding import Losses, decode_file
from photonmap.io.readers.mitsuba_parts.context import Context, Files
from photonmap.io.readers.mitsuba_parts.emitters import read_emitters
from photonmap.io.readers.mitsuba_parts.load import load_nodes
from photonmap.io.readers.mitsuba_parts.materials.bsdfs import Bsdfs
from photonmap.io.readers.mitsuba_parts.sensors import read_sensor
from photonmap.io.readers.mitsuba_parts.shapes import Shapes
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.named_files import allowed_folder
from photonmap.scene.scene import Scene

SUFFIXES = (".xml",)


def read(path: Path, options: ReadOptions) -> Scene:
    """Read a scene with its shapes, emitters and sensors.

    Each shape becomes a mesh, called by its id or else its type. Files that the scene names are
    looked up in its folder, and not outside of it.

    Raises
    ------
    InputError : as `decode_file`; or the scene needs what is not simulated
    """
    return decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: Losses) -> Scene:
    context = Context(Files(path, allowed_folder(path)), options.missing_textures, losses)
    scene = load_nodes(path, data, context.files)
    shapes = Shapes(Bsdfs(context))
    meshes = [mesh for shape in scene.parts("shape") for mesh in shapes.meshes(shape)]
    lights = read_emitters(context, scene.parts("emitter"))
    cameras = [read_sensor(context, sensor) for sensor in scene.parts("sensor")]
    return Scene(meshes, lights, name=path.stem, cameras=cameras)
