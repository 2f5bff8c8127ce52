"""Write the meshes of a scene as OBJ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.writers.assets import check_name
from photonmap.scene.images import encode_srgb
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene

_ROWS = 3 << 14
"""Rows written at a time: whole triangles"""


def write_obj(scene: Scene, path: Path, materials: Mapping[int, str]) -> None:
    """Write all meshes that have faces, with numbers that are read back to the last bit.

    Colours, which are encoded in sRGB, are read back to within rounding. Those of faces become
    colours of vertices, one vertex for each corner.

    Parameters
    ----------
    materials : names in the MTL file of the same stem, by the id of the material

    Raises
    ------
    InputError
        if there are no faces, or a name cannot be written
    """
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    if not meshes:
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to write")
    known = np.zeros(3, np.int64)
    with path.open("w", encoding="utf-8") as file:
        file.write(f"mtllib {path.stem}.mtl\n")
        for mesh in meshes:
            with naming("mesh"):
                check_name(mesh.name)
            file.write(f"o {mesh.name}\nusemtl {materials[id(mesh.material)]}\n")
            known += _write_mesh(file, mesh, known + 1)


def _write_mesh(file: TextIO, mesh: Mesh, first: NDArray[np.int64]) -> NDArray[np.int64]:
    """Write one mesh without its unused vertices.

    Parameters
    ----------
    first : (3,) numbers of its first vertex, texture coordinate and normal

    Returns
    -------
    (3,) how many of them it has
    """
    if mesh.colors is not None and mesh.colors.ndim == 3:
        mesh = mesh.split_corners()
    used, renumbered = np.unique(mesh.faces, return_inverse=True)
    normals = mesh.normals
    if normals is not None:  # flat where they are not finite, or 0
        normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, 0.0)
    vertices = mesh.vertices
    if mesh.colors is not None:
        vertices = np.hstack([vertices, encode_srgb(mesh.colors)])
    tables = (("v", vertices), ("vt", mesh.uv), ("vn", normals))
    for keyword, rows in tables:
        if rows is not None:
            for part in _parts(rows[used]):
                file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in part)
    shape = "/".join(
        "" if rows is None else f"{{{index}}}" for index, (_, rows) in enumerate(tables)
    ).rstrip("/")
    numbers = renumbered.reshape(-1, 1) + first
    for part in _parts(numbers):
        corners = [shape.format(*row) for row in part]
        lines = (f"f {' '.join(corners[at : at + 3])}\n" for at in range(0, len(corners), 3))
        file.writelines(lines)
    return np.array([0 if rows is None else len(used) for _, rows in tables])


def _parts(rows: NDArray[Any]) -> Iterator[list[list[Any]]]:
    """Yield rows as lists, so many at a time that lists stay small."""
    return (rows[at : at + _ROWS].tolist() for at in range(0, len(rows), _ROWS))
