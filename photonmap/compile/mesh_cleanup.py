"""Meshes without what exporters leave in them: stray vertices, coincident surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.mesh import Mesh

Bools = NDArray[np.bool_]
_MIX = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)


def without_strays(mesh: Mesh) -> Mesh:
    """Return a mesh without the vertices that no face uses: far ones would stretch the scene."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    if used.all():
        return mesh
    place, colors = np.cumsum(used) - 1, mesh.colors
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        faces=place[mesh.faces],
        normals=None if mesh.normals is None else mesh.normals[used],
        uv=None if mesh.uv is None or len(mesh.uv) != len(used) else mesh.uv[used],
        tangents=None if mesh.tangents is None else mesh.tangents[used],
        colors=colors[used] if colors is not None and colors.ndim == 2 else colors,
    )


def find_single(
    vertices: NDArray[np.float32],
    triangles: NDArray[np.int64],
    owner: NDArray[np.int64],
    traits: tuple[Bools, NDArray[np.int64], NDArray[np.int32]],
) -> Bools:
    """Return which triangles to keep where several have the same corners, in any order: (T,).

    One of them, an emitter if there is one, or else of the lowest rank; two emitters back to back;
    and none where bodies of equal glass touch, since light passes there unhindered.

    Parameters
    ----------
    owner : (T,) the mesh of each triangle
    traits : of each mesh, whether it may emit; the number of its medium, 0 for anything but glass;
        its rank
    """
    emitting, media, ranks = traits
    kept = np.ones(len(triangles), bool)
    corners = _codes(vertices)[triangles]
    codes = corners.sum(axis=1)
    ordered = np.sort(codes)
    if (ordered[1:] != ordered[:-1]).all():
        return kept
    _, group, count = np.unique(codes, return_inverse=True, return_counts=True)
    several = np.flatnonzero(count[group] > 1)
    group = group[several]
    order = np.lexsort((ranks[owner[several]], ~emitting[owner[several]], group))
    several, group = several[order], group[order]
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    first = several[np.repeat(starts, np.diff(starts, append=len(group)))]
    turned = _winding(corners[several]) != _winding(corners[first])
    here, there = owner[several], owner[first]
    kept[several] = (several == first) | (turned & emitting[here] & emitting[there])
    inside = turned & (media[here] > 0) & (media[here] == media[there])
    kept[first[inside]] = False
    return kept


def _codes(vertices: NDArray[np.float32]) -> NDArray[np.uint64]:
    """Return a number for each place, (V,)."""
    bits = (vertices + np.float32(0.0)).view(np.uint32).astype(np.uint64)
    code = np.zeros(len(vertices), np.uint64)
    for axis in range(3):
        code = (code ^ bits[:, axis]) * _MIX[axis]
        code ^= code >> np.uint64(29)
    return code


def _winding(corners: NDArray[np.uint64]) -> Bools:
    """Return the orientation of triples of corners, (T,)."""
    return (corners < np.roll(corners, -1, axis=1)).sum(axis=1) == 2
