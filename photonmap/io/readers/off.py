"""Read Geomview's OFF files: the worked example of a reader in docs/extending.md.

OFF or COFF; the numbers of vertices, faces and edges; one vertex a line; one face a line, the
number of its corners before their vertices, counted from 0. Three or four numbers behind either
are a colour. # begins a comment.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Ints, Losses, decode_colors, decode_file, note_loss
from photonmap.io.readers.meshes import LARGEST_FACE, build_mesh, cut_polygons
from photonmap.io.readers.registry import GREY, ReadOptions
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.mesh import LARGEST_COORDINATE
from photonmap.scene.scene import Scene
from photonmap.spectra.curves import Floats

SUFFIXES = (".off",)

_HEADERS = ("OFF", "COFF")


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the one mesh of an OFF file; its material is grey and called "default".

    Polygons are cut into triangles, and vertices that no face uses are left out. Colours are those
    of vertices, or else of faces.
    """
    return decode_file(path, _decode)


class _Line(NamedTuple):
    """A line that is not blank: its number in the file, and its words."""

    number: int
    words: list[str]

    def error(self, path: Path, problem: str) -> InputError:
        """Return an error that names the line and what it says."""
        return InputError(f"{shown(' '.join(self.words))} {problem}", path, self.number)


def _decode(path: Path, data: bytes, losses: Losses) -> Scene:
    lines = _split_lines(data)
    _strip_header(path, lines)
    vertex_count, face_count = _read_counts(path, lines)
    body = lines[1:]
    if len(body) < vertex_count + face_count:
        message = f"is truncated: it announces {vertex_count} vertices and {face_count} faces"
        raise InputError(f"{message}, but has {len(body)} lines of them; export it again", path)
    if len(body) > vertex_count + face_count:
        message = "follows the last face; correct the numbers of vertices and faces"
        raise body[vertex_count + face_count].error(path, message)
    if not face_count:
        return Scene()
    vertices = _read_vertices(path, body[:vertex_count])
    corners, sizes = _read_faces(path, body[vertex_count:], vertex_count)
    colors = _find_colors(path, body, sizes, losses)
    part = cut_polygons(vertices, corners, sizes, losses, colors=colors)
    return Scene([build_mesh(path, part, Material("default"), path.stem)], name=path.stem)


def _split_lines(data: bytes) -> list[_Line]:
    rows = enumerate(data.decode("utf-8-sig", "replace").splitlines(), start=1)
    lines = ((number, text.partition("#")[0].split()) for number, text in rows)
    return [_Line(number, words) for number, words in lines if words]


def _strip_header(path: Path, lines: list[_Line]) -> None:
    if not lines or lines[0].words[0] not in _HEADERS:
        message = "does not begin with OFF or COFF; export it as one of them, in text"
        raise InputError(message, path, lines[0].number if lines else None)
    del lines[0].words[0]
    if not lines[0].words:
        del lines[0]


def _read_counts(path: Path, lines: list[_Line]) -> tuple[int, int]:
    """Return the numbers of vertices and faces; that of edges is ignored, and may be missing."""
    words = lines[0].words if lines else []
    if len(words) in (2, 3) and all(word.isdecimal() for word in words):
        return int(words[0]), int(words[1])
    if not lines:
        raise InputError("ends after its header; export it again", path)
    raise lines[0].error(path, "is not a line of counts; write those of vertices, faces and edges")


def _read_vertices(path: Path, lines: Sequence[_Line]) -> Floats:
    vertices = np.empty((len(lines), 3))
    for row, line in enumerate(lines):
        try:
            vertices[row] = [float(word) for word in line.words[:3]]
        except ValueError:
            vertices[row] = np.nan
        if not (np.abs(vertices[row]) <= LARGEST_COORDINATE).all():
            limit = f"three finite numbers up to {LARGEST_COORDINATE:g}"
            raise line.error(path, f"is not a vertex; write {limit}")
    return vertices


def _read_faces(path: Path, lines: Sequence[_Line], vertex_count: int) -> tuple[Ints, Ints]:
    """Return the corners of all faces, (C,), and how many each has, (F,)."""
    corners: list[int] = []
    sizes = []
    for line in lines:
        size = int(line.words[0]) if line.words[0].isdecimal() else -1
        if not 0 <= size <= LARGEST_FACE or len(line.words) <= size:
            raise line.error(path, "is not a face; write 3 or more corners after their number")
        face = [int(word) if word.isdecimal() else -1 for word in line.words[1 : 1 + size]]
        if size and not 0 <= min(face) <= max(face) < vertex_count:
            last = vertex_count - 1
            raise line.error(path, f"names vertices that do not exist; number them 0 to {last}")
        corners += face
        sizes.append(size)
    return np.array(corners, np.int64), np.array(sizes, np.int64)


def _find_colors(path: Path, lines: Sequence[_Line], sizes: Ints, losses: Losses) -> Floats | None:
    """Return the colours of vertices, (V, 3), or else of faces, (F, 1, 3); None if there are none.

    lines : of vertices, then of faces
    """
    count = len(lines) - len(sizes)
    of_vertices = _read_colors(path, lines[:count], [3] * count, "vertices", losses)
    begins = (1 + sizes).tolist()
    of_faces = _read_colors(path, lines[count:], begins, "faces", losses)
    if of_faces is None:
        return of_vertices
    if of_vertices is not None:
        note_loss(losses, "colours of faces beside those of vertices")
        return of_vertices
    return of_faces[:, None]


def _read_colors(
    path: Path, lines: Sequence[_Line], begins: list[int], owners: str, losses: Losses
) -> Floats | None:
    """Return the colours behind each line's other numbers, (n, 3), grey where it has none.

    A single number is an index into a table that the file does not hold.
    """
    values = np.full((len(lines), 4), np.nan)
    for row, (line, begin) in enumerate(zip(lines, begins, strict=True)):
        words = line.words[begin:]
        if len(words) not in (3, 4):
            if words:
                note_loss(losses, f"colours of {owners} that are not three or four numbers")
            continue
        try:
            values[row, : len(words)] = [float(word) for word in words]
        except ValueError:
            raise line.error(path, "ends in no colour; write three numbers, or none") from None
    given = np.isfinite(values[:, :3]).all(axis=1)
    if not given.any():
        return None
    colors = decode_colors(values, partial(note_loss, losses), owners)
    colors[~given] = GREY
    return colors
