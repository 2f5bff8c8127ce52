"""CDFs of the texels of a sky, by what they send to surfaces of any normal.

A map is divided into blocks. For each cell of normals, blocks are weighed by their light times the
cosine that they have on average, to whichever normal at the cell's corners and centre sees them
best. A block that any normal of the cell may see gets a chance at least.
"""

from __future__ import annotations

import itertools
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.cdf import make_cdf
from photonmap.kernels.lights.environment import (
    ALL_AROUND,
    BLOCK_COLUMNS,
    BLOCK_ROWS,
    STEPS,
)

Floats = NDArray[np.float64]

MIDDLE = (0.5, 0.5)
WITHIN_CELL = (MIDDLE, *itertools.product((0.0, 1.0), repeat=2))
WITHIN_BLOCK = tuple(itertools.product((0.25, 0.75), repeat=2))
"""Places where cosines are taken, as fractions of the way across."""
LEAST_COSINE = 0.02
"""Of blocks that are seen at all."""
REACH = 1.01
"""Factor on the angles from the middle of a block or cell to its corners, for rounding."""


class SkyCdfs(NamedTuple):
    """Fields of `kernels.core.records.Environment`."""

    block_rows: Floats
    block_columns: Floats
    rows: Floats
    columns: Floats


def sky_cdfs(light: Floats, cosines: Floats, rotation: float) -> SkyCdfs:
    """Return the CDFs of a map.

    Parameters
    ----------
    light : (H, W) radiance of texels; at least 16 × 32
    cosines : (H + 1,) of the zenith angles between rows
    rotation : of the map about +y, 1 for a full turn
    """
    height, width = light.shape
    row_edges, column_edges = _edges(height, BLOCK_ROWS), _edges(width, BLOCK_COLUMNS)
    light = light * -np.diff(cosines)[:, None]
    in_columns = np.add.reduceat(light, column_edges[:-1], axis=1)
    blocks = np.add.reduceat(in_columns, row_edges[:-1], axis=0)
    seen = np.append(blocks * _mean_cosines(height, width, rotation), blocks[None], axis=0)
    return SkyCdfs(
        make_cdf(seen.sum(axis=2)),
        make_cdf(seen),
        _cdf_by_part(np.ascontiguousarray(in_columns.T), row_edges),
        _cdf_by_part(light, column_edges),
    )


def fine_enough(texels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a map, (H, W, 3), whose texels are divided until each block has one at least."""
    height, width = texels.shape[:2]
    texels = np.repeat(texels, -(-BLOCK_ROWS // height), axis=0)
    return np.repeat(texels, -(-BLOCK_COLUMNS // width), axis=1)


def _edges(count: int, blocks: int) -> NDArray[np.int64]:
    """Return where blocks of rows or columns begin and end, as kernels say, (blocks + 1,)."""
    return -(-np.arange(blocks + 1) * count // blocks)


def _cdf_by_part(weights: Floats, edges: NDArray[np.int64]) -> Floats:
    """Return weights, (…, n), as CDFs that rise to 1 between any two edges."""
    return np.concatenate(
        [make_cdf(weights[..., a:b]) for a, b in itertools.pairwise(edges)], axis=-1
    )


@cache
def _mean_cosines(height: int, width: int, rotation: float) -> NDArray[np.float32]:
    """Return by which cosine blocks count for the cells of normals, (K, 16, 32)."""
    down, turn = _edges(height, BLOCK_ROWS) / height, _edges(width, BLOCK_COLUMNS) / width
    turn -= rotation
    middles, *across = (_directions(down, turn, *place) for place in (MIDDLE, *WITHIN_BLOCK))
    means = np.zeros((ALL_AROUND, BLOCK_ROWS * BLOCK_COLUMNS), np.float32)
    for place in WITHIN_CELL:
        normals = _normals(*place)
        cosines = [np.maximum(normals @ directions, 0.0) for directions in across]
        means = np.maximum(means, np.mean(cosines, axis=0))
    half = np.hypot(np.pi * np.diff(down).max(), 2.0 * np.pi * np.diff(turn).max()) / 2.0
    reach = REACH * (half + np.arctan(np.sqrt(2.0) / STEPS))
    seen = _normals(*MIDDLE) @ middles > -np.sin(reach)
    means = np.where(seen, np.maximum(means, LEAST_COSINE), 0.0)
    return means.reshape(-1, BLOCK_ROWS, BLOCK_COLUMNS)


def _directions(down: Floats, turn: Floats, s: float, t: float) -> NDArray[np.float32]:
    """Return directions at a place within each block, (3, 16 · 32).

    `down` and `turn` are edges of rows and columns, as fractions of the map.
    """
    theta = np.pi * (down[:-1] + s * np.diff(down))[:, None]
    phi = 2.0 * np.pi * (turn[:-1] + t * np.diff(turn) - 0.5)
    x, z = np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi)
    y = np.broadcast_to(np.cos(theta), x.shape)
    return np.stack([x, y, z]).reshape(3, -1).astype(np.float32)


def _normals(s: float, t: float) -> NDArray[np.float32]:
    """Return the normal at a place within each cell of `cell_of_normal`, (K, 3)."""
    faces, rows, columns = np.unravel_index(np.arange(ALL_AROUND), (6, STEPS, STEPS))
    normals, each = np.empty((ALL_AROUND, 3), np.float32), np.arange(ALL_AROUND)
    axes = faces // 2
    normals[each, axes] = 1.0 - 2.0 * (faces % 2)
    normals[each, (axes + 1) % 3] = 2.0 * (rows + s) / STEPS - 1.0
    normals[each, (axes + 2) % 3] = 2.0 * (columns + t) / STEPS - 1.0
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)
