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
    output.add_argument(
        "--thumbnail",
        nargs="?",
        const="",
        metavar="FILE.png",
        help="also render a small picture (default: SCENE-thumbnail.png beside the scene)",
    )


def run(options: argparse.Namespace) -> None:
    """Print the description, and render the thumbnail.

    Raises
    ------
    InputError : the scene cannot be read or rendered, or the thumbnail not be written
    """
    from photonmap.inspection.describe import inspect_file
    from photonmap.inspection.text import as_text

    path = _name_thumbnail(options)
    scene, description = inspect_file(choose_scene(options), choose_options(options, INFO)["bands"])
    print(
        json.dumps(description, indent=2, ensure_ascii=False)
        if options.json
        else as_text(description)
    )
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
    return check_thumbnail(
        Path(options.thumbnail or scene.with_name(f"{scene.stem}-thumbnail.png"))
    )
