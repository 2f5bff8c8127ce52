"""Whether meshes lie so far from the origin that 32-bit numbers have lost their shape."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from photonmap.errors import warn
from photonmap.runtime.wording import shown
from photonmap.scene.mesh import Mesh

_COARSE = 0.01
"""Spacing of positions, relative to the median edge, from which on surfaces look rough"""
_LIKELY = 4.0
"""Spacings of which all positions are multiples where they were given, and not rounded"""
_MOST = 1 << 16
"""Triangles of a mesh whose edges are measured, evenly chosen"""


class _Rounding(NamedTuple):
    """How coarse the positions of a mesh are.

    Parameters
    ----------
    far, spacing : of the coordinates farthest from 0, scene units
    share : the spacing relative to the mesh's longest side
    name : of the mesh
    """

    share: float
    spacing: float
    far: float
    name: str


def warn_of_rounding(path: Path, meshes: Sequence[Mesh]) -> None:
    """Warn of meshes whose positions, in 32 bits, are coarse next to their edges."""
    found = [rounding for mesh in meshes if (rounding := _find_rounding(mesh)) is not None]
    if found:
        worst = max(found)
        others = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        warn(
            f"{path}: mesh {shown(worst.name)}{others} is {worst.far:.3g} away from the origin, "
            f"where positions in 32 bits are {worst.spacing:.3g} apart, "
            f"{100.0 * worst.share:.2g}% of its size: its shape is coarse; centre it before export"
        )


def _find_rounding(mesh: Mesh) -> _Rounding | None:
    """Return how coarse the positions of a mesh are; None where that does not matter."""
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
    return _Rounding(share, float(spacing[axis]), float(far[axis]), mesh.name)
