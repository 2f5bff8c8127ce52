"""A quick picture of a scene."""

from __future__ import annotations

from pathlib import Path

from photonmap.errors import InputError
from photonmap.io.png import write_png
from photonmap.render import render
from photonmap.report.files import replacing
from photonmap.runtime.file_checks import check_writable
from photonmap.scene.scene import Scene

SIZE = 160, 120
ERROR = 0.05
SECONDS = 10.0
"""After which the picture stays noisier than `ERROR`."""


def check_thumbnail(path: Path) -> Path:
    """Check that a picture can be written there."""
    if path.suffix.lower() != ".png":
        raise InputError("the name of the thumbnail must end in .png", path)
    if not path.parent.is_dir():
        raise InputError(f"the folder {path.parent} does not exist; create it", path)
    check_writable(path.parent, path)
    return path


def write_thumbnail(scene: Scene, path: Path) -> None:
    """Render a scene in RGB for some seconds, and write a small PNG."""
    shown = {"radiance", "emission"}
    result = render(scene, bands="rgb", size=SIZE, error=ERROR, seconds=SECONDS, buffers=shown)
    with replacing(path) as draft:
        write_png(result.preview(), draft)
