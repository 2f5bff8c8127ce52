"""Read the geometry of PLY, STL and glTF files, which trimesh decodes."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming, warn
from photonmap.messages import listed, shown
from photonmap.readers.obj_lines import LARGEST_COORDINATE
from photonmap.readers.tables import read_bytes
from photonmap.scene import Material, Mesh

SUFFIXES = (".ply", ".stl", ".glb", ".gltf")

Losses = dict[str, dict[str, None]]
"""What is read but not simulated, and whose it is, in order of appearance."""

_Reader = Callable[[Path, bytes, Losses], list[Mesh]]


@dataclass(frozen=True)
class Part:
    """Triangles as `photonmap.scene.Mesh` holds them, not checked yet."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None


def read_mesh(path: str | PathLike[str]) -> list[Mesh]:
    """Read the triangles of a PLY, STL, GLB or glTF file.

    Polygons are cut into triangles. Normals and texture coordinates are those of the file;
    without normals a mesh is flat. Vertices in no face are left out. The material is grey and
    called "default", unless a glTF file names another, whose reflectance is the base colour
    where there is no texture. Each node of a glTF scene that shows a mesh becomes one or more
    meshes of the node's name, in the scene's coordinates. What is read but not simulated is
    named in one warning.

    Parameters
    ----------
    path : the file; the buffers of a .gltf file are looked up beside it

    Returns
    -------
    list of Mesh, in the order of the file, scene units

    Raises
    ------
    InputError : the file is missing, damaged or of another kind, needs what is not supported,
        or has no triangles
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"is of no known kind; supported: {', '.join(SUFFIXES)}", path)
    read, data = _reader(suffix), read_bytes(path)
    losses: Losses = {}
    with _decoding(path):
        meshes = read(path, data, losses)
    if not meshes:
        raise InputError("has no triangles; export the surfaces as polygons", path)
    if losses:
        told = [
            f"{what} of {listed(owners)}" if owners else what for what, owners in losses.items()
        ]
        warn(f"{path}: not simulated: {'; '.join(told)}")
    return meshes


def _reader(suffix: str) -> _Reader:
    """Import what reads files of this suffix; it imports this module in turn."""
    if suffix == ".ply":
        from photonmap.readers.ply import read_ply

        return read_ply
    if suffix == ".stl":
        from photonmap.readers.stl import read_stl

        return read_stl
    from photonmap.readers.gltf import read_gltf

    return read_gltf


@contextmanager
def _decoding(path: Path) -> Iterator[None]:
    """Turn whatever damaged data raises into an `InputError`, and keep trimesh quiet."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except Exception as error:
        text = " ".join(str(error).split())
        reason = f" ({text[:80]})" if text else ""
        kind = path.suffix[1:].upper()
        raise InputError(f"is damaged, or no {kind} file{reason}; export it again", path) from None
    finally:
        log.setLevel(level)


def note(losses: Losses, what: str, owner: str = "") -> None:
    """Note what is not simulated, and whose it is."""
    owners = losses.setdefault(what, {})
    if owner:
        owners[owner] = None


def move(part: Part, matrix: NDArray[np.float64]) -> Part:
    """Move a part by a 4×4 matrix; where that mirrors, faces turn, to keep their front outside."""
    linear = matrix[:3, :3]
    mirrors = bool(np.linalg.det(linear) < 0)
    vertices = part.vertices @ linear.T + matrix[:3, 3]
    faces = part.faces[:, ::-1] if mirrors else part.faces
    normals = part.normals
    if normals is not None:
        columns = linear.T
        cofactors = np.cross(columns[[1, 2, 0]], columns[[2, 0, 1]])
        normals = normals @ (-cofactors if mirrors else cofactors)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length != 0)
    return Part(vertices, faces, normals, part.uv)


def build_mesh(path: Path, part: Part, material: Material, name: str) -> Mesh:
    """Check triangles and leave out the vertices they do not use."""
    with naming(f"mesh {shown(name)}", path):
        for kind, rows in (
            ("vertex", part.vertices),
            ("normal", part.normals),
            ("texture coordinate", part.uv),
        ):
            if rows is not None:
                check_rows(kind, rows)
        check_indices(part.faces, len(part.vertices))
    used = np.zeros(len(part.vertices), np.bool_)
    used[part.faces] = True
    faces = (np.cumsum(used) - 1)[part.faces]
    normals, uv = (None if rows is None else rows[used] for rows in (part.normals, part.uv))
    return Mesh(part.vertices[used], faces, material, name, normals, uv)


def check_rows(kind: str, rows: NDArray[np.float64]) -> None:
    """Refuse rows of numbers that are not finite, or too large."""
    bad = ~(np.abs(rows) <= LARGEST_COORDINATE).all(axis=1)
    if bad.any():
        row = int(np.argmax(bad))
        values = ", ".join(f"{value:g}" for value in rows[row])
        limit = f"finite numbers up to {LARGEST_COORDINATE:g}"
        raise InputError(f"{kind} {row} is ({values}); export it with {limit}")


def check_indices(corners: NDArray[np.int64], count: int) -> None:
    """Refuse corners that are none of `count` vertices."""
    bad = (corners < 0) | (corners >= count)
    if bad.any():
        message = f"a face names vertex {corners[bad][0]}, but there are {count}, counted from 0"
        raise InputError(f"{message}; export it again")
