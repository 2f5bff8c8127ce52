"""Load a scene by its file's suffix, with the camera that stands beside it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.camera import check_camera
from photonmap.errors import InputError
from photonmap.messages import shown, suggest
from photonmap.readers.obj import read_obj
from photonmap.scene import Camera, Mesh, Scene

_READERS: dict[str, Callable[[Path], list[Mesh]]] = {".obj": read_obj}
_SECTIONS = {"camera": ("origin", "target", "up", "fov")}
_REQUIRED = ("origin", "target")


def load_scene(path: str | PathLike[str]) -> Scene:
    """Load a scene file.

    A TOML file of the same stem beside it may hold the camera: a section `[camera]` with
    `origin` and `target` (scene units), and optionally `up` and `fov` (degrees, vertical).

    Parameters
    ----------
    path : an OBJ file

    Returns
    -------
    Scene, named by the file's stem; its camera is None where no file describes one

    Raises
    ------
    InputError : the file is of no known kind, or it or one it refers to cannot be read
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"is of no known kind; supported: {', '.join(_READERS)}", path)
    camera = _read_camera(path.with_suffix(".toml"))
    return Scene(reader(path), camera=camera, name=path.stem)


def _read_camera(path: Path) -> Camera | None:
    """Read the camera of a TOML file; None where there is none.

    Raises
    ------
    InputError : the file is no TOML, a section or key is not known, or the camera is not valid
    """
    text = _read_text(path)
    sections = _parse_toml(text, path)
    _check_known(sections, _SECTIONS, "section", text, path)
    if "camera" not in sections:
        return None
    line = _line_of(text, "camera")
    camera = sections["camera"]
    if not isinstance(camera, dict):
        raise InputError("camera is no section; write [camera] above its keys", path, line)
    _check_known(camera, _SECTIONS["camera"], "[camera] key", text, path)
    for key in _REQUIRED:
        if key not in camera:
            raise InputError(f"[camera] lacks {key}; add {key} = [x, y, z]", path, line)
    lines = {key: _line_of(text, key) for key in _SECTIONS["camera"]}
    return check_camera(Camera(**camera), path, lines)


def _read_text(path: Path) -> str:
    """Read UTF-8; a missing file counts as empty."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror}); check the file", path) from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise InputError("is not in UTF-8; save it so", path, line) from None


def _parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Parse TOML; a syntax error names its line."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        reason, _, place = str(error).partition(" (at ")
        found = re.match(r"line (\d+)", place)
        line = int(found[1]) if found else len(text.splitlines()) if place else None
        raise InputError(f"is not valid TOML: {reason}; mend it", path, line) from None


def _check_known(
    names: Collection[str], known: Collection[str], kind: str, text: str, path: Path
) -> None:
    """Raise on a name that is not known."""
    for name in names:
        if name not in known:
            message = f"{kind} {shown(name)} is not known; {suggest(name, known)}"
            raise InputError(message, path, _line_of(text, name))


def _line_of(text: str, name: str) -> int | None:
    """Find the first line that has a section or key of this name."""
    pattern = rf"^[^#\n]*?(?<![\w-]){re.escape(name)}[\"']?[ \t]*[=.\]]"
    found = re.search(pattern, text, re.MULTILINE)
    return text.count("\n", 0, found.start()) + 1 if found else None
