"""The command `python -m photonmap convert`: write a scene in another format."""

from __future__ import annotations

import argparse
from pathlib import Path

from photonmap.commands import shared
from photonmap.errors import InputError
from photonmap.io.scene_source import SceneSource

HELP = "Convert a scene of any format that can be read to OBJ, MTL and TOML, or to glTF."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("scene", metavar="SCENE", help="the scene file to read")
    text = "what to write: FILE.obj, FILE.glb or FILE.gltf"
    parser.add_argument("output", metavar="FILE", help=text)
    shared.add_material_options(parser)
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> None:
    """Read the scene, write it, and print the names of the files."""
    from photonmap.io.readers.scene_file import scene_files
    from photonmap.io.writers.scene_file import save_scene

    output = Path(options.output)
    _check_output(scene_files(options.scene), output)
    source = SceneSource(options.scene, **shared.how_to_read(options))
    shared.say(options, *save_scene(source.load(), output))


def _check_output(inputs: list[Path], output: Path) -> None:
    """Refuse to replace what is read, and files beside the output that would be read with it."""
    from photonmap.io.writers.scene_file import companions

    read = {path.resolve() for path in inputs}
    for path in (output, *companions(output)):
        if path.resolve() in read:
            remedy = "choose another name for the output"
            raise InputError(f"is a file of the scene itself; {remedy}", path)
        if path.exists() and not output.exists():
            raise InputError(f"exists, but {output.name} does not; rename one of them", path)
