"""The command `python -m photonmap info`: what is in a scene file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.commands import shared
from photonmap.errors import InputError, only_heard
from photonmap.settings import INFO

if TYPE_CHECKING:
    from photonmap.scene.scene import Scene

_THUMBNAIL: dict[str, Any] = {"size": (160, 120), "error": 0.05, "seconds": 10.0}
"""How a small picture is rendered; after these seconds, it stays noisier."""
HELP = "Show what a scene file contains, what a render would simulate, and what is not supported."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    shared.add_scene_options(parser)
    groups = shared.add_options(parser, INFO)
    shared.add_range(groups["image"])
    output = parser.add_argument_group("output")
    output.add_argument("--json", action="store_true", help="print the same as JSON")
    text, usual = "also render a small picture", "SCENE-thumbnail.png beside the scene"
    shared.add_value(output, "thumbnail", "FILE.png", text, bare="", default_text=usual)


def run(options: argparse.Namespace) -> None:
    """Print the description, and render the thumbnail."""
    from photonmap.inspection.describe import inspect_file
    from photonmap.inspection.text import as_text

    path = _name_thumbnail(options)
    bands = shared.choose_options(options, INFO)["bands"]
    scene, description = inspect_file(shared.choose_scene(options), bands)
    as_json = options.json and json.dumps(description, indent=2, ensure_ascii=False)
    print(as_json or as_text(description))
    if path is not None:
        _write_thumbnail(scene, path)


def _write_thumbnail(scene: Scene, path: Path) -> None:
    """Render a scene in RGB for some seconds, and write a small PNG."""
    from photonmap.io.png import encode_png
    from photonmap.render import render
    from photonmap.runtime.writing import replacing

    with only_heard():  # they are in the description
        result = render(scene, bands="rgb", buffers={"radiance", "emission"}, **_THUMBNAIL)
    data = encode_png(result.preview())
    with replacing(path, len(data)) as draft:
        draft.write_bytes(data)


def _name_thumbnail(options: argparse.Namespace) -> Path | None:
    """Return where to write the picture, checked; None for none."""
    from photonmap.runtime.writing import check_file, check_length

    if options.thumbnail is None:
        return None
    scene = Path(options.scene)
    path = Path(options.thumbnail or scene.with_name(f"{scene.stem}-thumbnail.png"))
    if path.suffix.lower() != ".png":
        raise InputError("the name of the thumbnail must end in .png", path)
    check_length(path)
    if not path.parent.is_dir():
        raise InputError(f"the folder {path.parent} does not exist; create it", path)
    check_file(path)
    return path
