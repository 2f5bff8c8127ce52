"""What readers of one file share: damaged data, numbers, colours, and what is not simulated."""

from __future__ import annotations

import logging
import tempfile
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, SceneWarning, warn
from photonmap.runtime.bounds import refuse_large
from photonmap.runtime.wording import listed, shown
from photonmap.scene.images import Channels, decode_srgb, read_channels
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Vector
from photonmap.scene.scene import Scene
from photonmap.spectra.curves import Floats
from photonmap.spectra.tables import read_bytes

_COARSE = 0.01
"""Spacing of positions, relative to the median edge, from which on surfaces look rough"""
_LIKELY = 4.0
"""Spacings of which all positions are multiples where they were given, and not rounded"""
_NAMED = 40  # Kinds of things lost that are named
_MOST = 1 << 16  # Triangles of a mesh whose edges are measured, evenly chosen
Ints = NDArray[np.int64]
Losses = dict[str, dict[str, None]]
"""What is read but not simulated, and whose it is, in order of appearance."""
SHEEN = "sheen (which brightens cloth where it is seen at grazing angles)"
"""What is left out of cloth, in whatever format"""
Note = Callable[[str], None]  # Takes what is not simulated


def decode_file(path: Path, decode: Callable[[Path, bytes, Losses], Scene]) -> Scene:
    """Read a file whole, and name what is lost in one warning; in another, meshes far away.

    decode : from a file's path and content to its scene; losses are noted in the third argument
    """
    data = read_bytes(path)
    losses: Losses = {}
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", SceneWarning)
            scene = decode(path, data, losses)
    except InputError:
        raise
    except MemoryError as error:
        refuse_large(error, path)
    except Exception as error:  # what a damaged file raises is not documented
        text = " ".join(str(error).split())
        reason = f" ({text[:80]})" if text else ""
        kind = path.suffix[1:].upper()
        message = f"is damaged or not a file of type {kind}{reason}; export it again"
        raise InputError(message, path) from None
    finally:
        log.setLevel(level)
    for each in issued:
        warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    if not any(len(mesh.faces) for mesh in scene.meshes):
        raise InputError("has no triangles; export the surfaces as polygons", path)
    warn_of_rounding(path, scene.meshes)
    if losses:
        named = [
            f"{what} of {listed(owners)}" if owners else what for what, owners in losses.items()
        ]
        more = f"; and {len(named) - _NAMED} more kinds" if len(named) > _NAMED else ""
        warn(f"{path}: not simulated: {'; '.join(named[:_NAMED])}{more}")
    return scene


def note_loss(losses: Losses, what: str, owner: str = "") -> None:
    """Note what is not simulated, and whose it is."""
    owners = losses.setdefault(what, {})
    if owner:
        owners[owner] = None


def decode_colors(values: NDArray[Any], note: Note, owners: str) -> Floats:
    """Return linear reflectances of colours that are encoded in sRGB.

    OBJ, PLY, OFF and STL do not define an encoding. Scanners and MeshLab write what a screen shows,
    and Blender and three.js read these colours as sRGB.

    values : (n, 3), or (n, 4) with an opacity, which is not simulated: integers are fractions of
        the largest of their type; floats lie in [0, 1], or are all whole numbers, up to 255
    Returns (n, 3), of a row that is not finite NaN
    """
    if values.dtype.kind in "ui":
        scaled = values / np.iinfo(values.dtype).max
    else:
        finite = values[np.isfinite(values)]
        in_bytes = finite.max(initial=0.0) > 1.0 and (finite == np.rint(finite)).all()
        scaled = values.astype(np.float64) / (255.0 if in_bytes else 1.0)
    colors = np.clip(scaled[:, :3], 0.0, 1.0)
    if count := int((colors != scaled[:, :3]).any(axis=1, where=~np.isnan(colors)).sum()):
        note(f"{count} colours of {owners} outside [0, 1]")
    if (scaled[:, 3:] < 1.0).any():
        note(f"opacity of {owners}")
    return decode_srgb(colors)


def read_embedded(data: bytes | memoryview, name: str, as_stored: bool = False) -> Channels:
    """Read an image that is part of another file, by a temporary one of a name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        return read_channels(path, as_stored)


def plain(row: Any) -> Vector:
    """Return three numbers of an array, or of other values in a row, as floats."""
    x, y, z = map(float, row)
    return x, y, z


def point_ahead(origin: Floats, ahead: Floats) -> Vector:
    """Return a point from an origin along a unit vector, so far that rounding turns no view."""
    return plain(origin + max(1.0, float(np.abs(origin).max())) * ahead)


def unused_name(wanted: str, index: int, used: set[str]) -> str:
    """Return a node's name, with its index where another has that name; enter it."""
    name = wanted
    while name in used:
        name += f"_{index}"
    used.add(name)
    return name


def warn_of_rounding(path: Path, meshes: Sequence[Mesh]) -> None:
    """Warn of meshes whose positions, in 32 bits, are coarse next to their edges."""
    found = [rounding for mesh in meshes if (rounding := _find_rounding(mesh)) is not None]
    if found:
        share, spacing, far, name = max(found)
        others = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        warn(
            f"{path}: mesh {shown(name)}{others} is {far:.3g} away from the origin, "
            f"where positions in 32 bits are {spacing:.3g} apart, "
            f"{100.0 * share:.2g}% of its size: its shape is coarse; centre it before export"
        )


def _find_rounding(mesh: Mesh) -> tuple[float, float, float, str] | None:
    """Return how coarse the positions of a mesh are; None where that does not matter.

    That is their spacing, relative to the longest side and in scene units; the coordinate farthest
    from 0; and the mesh's name.
    """
    if not len(mesh.faces):
        return None
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    far, sides = np.maximum(-low, high), high - low
    if not 0.0 < sides.max() < far.max() < np.finfo(np.float32).max:
        return None
    spacing = np.where(sides > 0.0, np.spacing(far.astype(np.float32)), 0.0).astype(np.float64)
    axis = int(np.argmax(spacing))
    along = mesh.vertices[:, axis]
    is_single = (along == along.astype(np.float32)).all()
    if not is_single or not np.fmod(along, _LIKELY * spacing[axis]).any():
        return None
    corners = mesh.vertices[mesh.faces[:: -(-len(mesh.faces) // _MOST)]]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    if spacing[axis] < _COARSE * np.median(edges):
        return None
    share = float(spacing[axis] / sides.max())
    return share, float(spacing[axis]), float(far[axis]), mesh.name


_SPACE, _PLUS, _MINUS, _POINT, _ZERO = b" +-.0"
_PLAIN = np.isin(np.arange(256), list(b"0123456789+-. \v\n"))
_POWERS = 10.0 ** np.arange(23)
_EXACT = 1 << 53  # Integers up to here, and powers of ten up to 10²², are exact in float64


def begins(inside: NDArray[np.bool_]) -> Ints:
    """Return where runs of True begin; the first element is False."""
    return np.flatnonzero(inside[1:] & ~inside[:-1]) + 1


def parse_integers(text: NDArray[np.uint8]) -> Ints:
    """Parse integers.

    text : (B,) uint8, numbers separated by white space, which also comes first and last
    Returns (W,) int64, a value for each word; too few or too many values where one is malformed
    """
    signs = np.flatnonzero((text == _PLUS) | (text == _MINUS))
    if (text[signs - 1] > _SPACE).any() or (text[signs + 1] < _ZERO).any():
        return np.empty(0, np.int64)
    values: Ints = _parse(text, np.int64)
    return values


def parse_floats(text: NDArray[np.uint8]) -> Floats | None:
    """Parse decimals, correctly rounded.

    Returns (W,) float64, a value for each word, or None where one is malformed
    """
    solid = text > _SPACE
    words = begins(solid)
    values = _parse_plain(text, words, begins(~solid))
    if values is None:
        values = _parse(text, np.float64)
    return values if len(values) == len(words) else None


def check_decimals(path: Path, data: bytes, before: int = 0) -> None:
    """Raise `InputError` for the first word of a text that is no decimal.

    before : lines of the file before the text
    """
    for number, line in enumerate(data.splitlines(), start=before + 1):
        for word in line.split():
            if not _is_decimal(word):
                text = shown(word.decode(errors="replace"))
                raise InputError(f"{text} is not a number; export it again", path, number)


def _is_decimal(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return b"_" not in word


def _parse_plain(text: NDArray[np.uint8], words: Ints, ends: Ints) -> Floats | None:
    """Parse decimals without exponents as integers over powers of ten, which is faster.

    Where both are exact, the quotient is the nearest float64 (Clinger, "How to read floating
    point numbers accurately", 1990). None where they are not.

    words, ends : (W,) where each word begins and ends
    """
    sign = (text == _PLUS) | (text == _MINUS)
    if not _PLAIN[text].all() or np.count_nonzero(sign) != np.count_nonzero(sign[words]):
        return None
    point = text == _POINT
    points = np.flatnonzero(point)
    owners = np.searchsorted(ends, points, "right")
    decimals = np.zeros(len(words), np.int64)
    decimals[owners] = ends[owners] - points - 1
    digits = parse_integers(text[~point])
    if (
        len(digits) != len(words)
        or (np.diff(owners) == 0).any()
        or decimals.max(initial=0) >= len(_POWERS)
        or digits.max(initial=0) > _EXACT
        or digits.min(initial=0) < -_EXACT
    ):
        return None
    return digits / _POWERS[decimals]


def _parse(text: NDArray[np.uint8], kind: type) -> NDArray[Any]:
    """Parse numbers; return none if one is malformed, or if there are none."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text.tobytes().rstrip() or b"none", kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return np.empty(0, kind)
