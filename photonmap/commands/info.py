"""The command `python -m photonmap info`: what is in a scene file."""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path

from photonmap.commands.options import (
    add_options,
    add_range,
    add_scene_options,
    add_value,
    choose_options,
    choose_scene,
)
from photonmap.errors import SceneWarning
from photonmap.settings import INFO

HELP = "Show what a scene file contains, what a render would simulate, and what is not supported."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_scene_options(parser)
    groups = add_options(parser, INFO)
    add_range(groups["image"])
    output = parser.add_argument_group("output")
    output.add_argument("--json", action="store_true", help="print the same as JSON")
    text, usual = "also render a small picture", "SCENE-thumbnail.png beside the scene"
    add_value(output, "thumbnail", "FILE.png", text, bare="", default_text=usual)


def run(options: argparse.Namespace) -> None:
    """Print the description, and render the thumbnail."""
    from photonmap.inspection.describe import inspect_file
    from photonmap.inspection.text import as_text

    path = _name_thumbnail(options)
    scene, description = inspect_file(choose_scene(options), choose_options(options, INFO)["bands"])
    as_json = options.json and json.dumps(description, indent=2, ensure_ascii=False)
    print(as_json or as_text(description))
    if path is not None:
        from photonmap.inspection.thumbnail import write_thumbnail

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # they are in the description
            write_thumbnail(scene, path)


def _name_thumbnail(options: argparse.Namespace) -> Path | None:
    """Return where to write the picture, checked; None for none."""
    if options.thumbnail is None:
        return None
    from photonmap.inspection.thumbnail import check_thumbnail

    scene = Path(options.scene)
    usual = scene.with_name(f"{scene.stem}-thumbnail.png")
    return check_thumbnail(Path(options.thumbnail or usual))
