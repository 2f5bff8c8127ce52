"""Meshes as files hold them: checked, moved, and without the vertices that no face uses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.readers.decoding import Losses, note_loss
from photonmap.io.readers.polygons import triangulate
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.mesh import LARGEST_COORDINATE, Mesh


@dataclass(frozen=True)
class Part:
    """Triangles that are not checked yet.

    Parameters
    ----------
    vertices : (V, 3), scene units
    faces : (F, 3), indices of vertices
    normals : (V, 3) or None
    uv : (V, 2) or None, v upwards
    colors : (V, 3) of vertices or (F, 1, 3) of faces, linear, or None
    tangents : (V, 4) or None, as in `Mesh`
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None
    colors: NDArray[np.float64] | None = None
    tangents: NDArray[np.float64] | None = None


def cut_polygons(
    vertices: NDArray[np.float64],
    corners: NDArray[np.int64],
    sizes: NDArray[np.int64],
    losses: Losses,
    normals: NDArray[np.float64] | None = None,
    uv: NDArray[np.float64] | None = None,
    colors: NDArray[np.float64] | None = None,
) -> Part:
    """Cut polygons into triangles, and note those of fewer than three corners or without area.

    Parameters
    ----------
    vertices, normals, uv : as in `Part`
    corners : (C,) indices of vertices, one polygon after another; all of them valid
    sizes : (F,) corners of each polygon, up to `LARGEST_FACE`
    losses : takes the polygons that are left out
    colors : as in `Part`, those of faces for each polygon
    """
    large = sizes >= 3
    if small := np.count_nonzero(~large):
        note_loss(losses, f"{small} faces of fewer than three corners")
        corners, sizes = corners[np.repeat(large, sizes)], sizes[large]
        if colors is not None and colors.ndim == 3:
            colors = colors[large]
    if (sizes == 3).all():
        return Part(vertices, corners.reshape(-1, 3), normals, uv, colors)
    triangles, owners = triangulate(vertices, corners.astype(np.int32), sizes)
    if empty := len(sizes) - np.count_nonzero(np.bincount(owners)):
        note_loss(losses, f"{empty} faces without area")
    if colors is not None and colors.ndim == 3:
        colors = colors[owners]
    return Part(vertices, corners[triangles], normals, uv, colors)


def move(part: Part, matrix: NDArray[np.float64]) -> Part:
    """Transform a part by a (4, 4) matrix; faces are reversed where it mirrors, to stay outside."""
    linear = matrix[:3, :3]
    mirrors = bool(np.linalg.det(linear) < 0)
    vertices = part.vertices
    if not np.array_equal(matrix, np.eye(4)):
        vertices = vertices @ linear.T + matrix[:3, 3]
    faces = part.faces[:, ::-1] if mirrors else part.faces
    normals = part.normals
    if normals is not None:
        columns = linear.T
        cofactors = np.cross(columns[[1, 2, 0]], columns[[2, 0, 1]])
        normals = normals @ (-cofactors if mirrors else cofactors)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length != 0)
    tangents = part.tangents
    if tangents is not None:
        sign = -tangents[:, 3] if mirrors else tangents[:, 3]
        tangents = np.column_stack([tangents[:, :3] @ linear.T, sign])
    return replace(part, vertices=vertices, faces=faces, normals=normals, tangents=tangents)


def is_closed(part: Part) -> bool:
    """Return whether each edge has a triangle on either side; vertices of one place are one."""
    _, same = np.unique(part.vertices, axis=0, return_inverse=True)
    corners = same.reshape(-1)[part.faces]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1]
    return bool((counts % 2 == 0).all())


def build_mesh(path: Path, part: Part, material: Material, name: str) -> Mesh:
    """Check triangles and leave out the vertices they do not use."""
    with naming(f"mesh {shown(name)}", path):
        for kind, rows in (
            ("vertex", part.vertices),
            ("normal", part.normals),
            ("texture coordinate", part.uv),
            ("colour", part.colors),
        ):
            if rows is not None:
                check_rows(kind, rows.reshape(len(rows), -1))
        check_indices(part.faces, len(part.vertices))
    used = np.zeros(len(part.vertices), np.bool_)
    used[part.faces] = True
    colors, others = part.colors, (part.normals, part.uv, part.tangents)
    if used.all():
        normals, uv, tangents = others
        return Mesh(part.vertices, part.faces, material, name, normals, uv, colors, tangents)
    faces = (np.cumsum(used) - 1)[part.faces]
    normals, uv, tangents = (None if rows is None else rows[used] for rows in others)
    if colors is not None and colors.ndim == 2:
        colors = colors[used]
    return Mesh(part.vertices[used], faces, material, name, normals, uv, colors, tangents)


def check_rows(kind: str, rows: NDArray[np.float64]) -> None:
    """Refuse rows of numbers that are not finite, or too large."""
    if rows.size and not (-rows.min() <= LARGEST_COORDINATE >= rows.max()):  # or one is NaN
        bad = ~(np.abs(rows) <= LARGEST_COORDINATE).all(axis=1)
        row = int(np.argmax(bad))
        values = ", ".join(f"{value:g}" for value in rows[row])
        limit = f"finite numbers up to {LARGEST_COORDINATE:g}"
        raise InputError(f"{kind} {row} is ({values}); export it with {limit}")


def check_indices(corners: NDArray[np.int64], count: int) -> None:
    """Refuse corners that are none of `count` vertices."""
    if corners.size and not 0 <= corners.min() <= corners.max() < count:
        bad = (corners < 0) | (corners >= count)
        message = f"a face names vertex {corners[bad][0]}, but there are {count}, counted from 0"
        raise InputError(f"{message}; export it again")
