"""Closed bodies of glass, in the order in which they claim the space that they share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.errors import warn
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh

TOUCHING = 1e-6
"""Distance, in sizes of the scene, below which surfaces touch."""

UNRANKED = (1 << 30) - 1
"""Rank of meshes that are no bodies."""

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Body(NamedTuple):
    """A closed mesh of solid glass."""

    mesh: int
    """among the scene's meshes"""
    material: Material
    shape: Any
    """`trimesh.Trimesh` in the kernels' units"""

    @property
    def inside(self) -> int:
        """The mesh of what is inside: -1, air, where it is wound inwards, like a bubble's."""
        return self.mesh if self.shape.volume > 0.0 else -1

    @property
    def bounds(self) -> Floats:
        """Smallest and largest coordinates, (2, 3)."""
        return np.asarray(self.shape.bounds)

    def contains(self, points: Floats) -> Bools:
        """Return which points, (P, 3), lie inside."""
        within = near(self.bounds, points, points)
        rows = np.flatnonzero(within)
        if len(rows):
            within[rows] = self.shape.contains(points[rows])
        return within


def near(bounds: Floats, low: Floats, high: Floats) -> Bools:
    """Return which boxes, from low to high, (…, 3), touch one of bounds (2, 3)."""
    touches = (low <= bounds[1] + TOUCHING) & (high >= bounds[0] - TOUCHING)
    return np.asarray(touches.all(axis=-1))


def find_bodies(meshes: Sequence[Mesh], absorbing: set[int], frame: Frame) -> list[Body]:
    """Return the bodies that matter to what lies around them: those that claim space come first.

    That is glass that absorbs, and glass that touches other glass or contains it. Of bodies that
    overlap, the one of the higher priority claims what they share, or else the smaller one.

    Parameters
    ----------
    absorbing : ids of materials that absorb
    frame : of the kernels' units
    """
    solid = [i for i, mesh in enumerate(meshes) if is_solid(mesh.material)]
    boxes = {i: np.stack([f(meshes[i].vertices, axis=0) for f in (np.min, np.max)]) for i in solid}
    scaled = {i: (box - frame.center) / frame.size for i, box in boxes.items()}
    met = {i: any(j != i and near(scaled[i], *scaled[j]) for j in solid) for i in solid}
    found, unknown = [], []
    for i in solid:
        absorbs = id(meshes[i].material) in absorbing
        if not absorbs and not met[i]:
            continue
        body = _body(i, meshes[i], frame)
        if body.shape.is_watertight:
            found.append(body)
        elif absorbs or any(j != i and _overlap(scaled[i], scaled[j]) for j in solid):
            unknown.append(meshes[i])
    names = [mesh.name for mesh in unknown if mesh.material.outside == 1.0]
    if names:
        warn(
            f"glass is no closed mesh in {listed(names)}: what lies inside is unknown, and it "
            "refracts against air"
        )
    return sorted(found, key=lambda body: (-body.material.priority, np.ptp(body.bounds, 0).prod()))


def _overlap(one: Floats, other: Floats) -> bool:
    """Return whether boxes share more than parts of their surfaces."""
    low, high = np.maximum(one[0], other[0]), np.minimum(one[1], other[1])
    flat = np.ptp(one, axis=0) <= TOUCHING
    beyond = (one[0] > other[0] + TOUCHING) & (one[1] < other[1] - TOUCHING)
    return bool(np.where(flat, beyond, high > low + TOUCHING).all())


def ranks_of(count: int, bodies: Sequence[Body]) -> NDArray[np.int32]:
    """Return the rank of each of so many meshes, by which they claim space: 0 comes first."""
    ranks = np.full(count, UNRANKED, np.int32)
    ranks[[body.mesh for body in bodies]] = np.arange(len(bodies), dtype=np.int32)
    return ranks


def is_solid(material: Material) -> bool:
    """Return whether it is glass with an inside."""
    return material.ior is not None and not material.thin


def _body(index: int, mesh: Mesh, frame: Frame) -> Body:
    import trimesh

    vertices = ((mesh.vertices - frame.center) / frame.size).astype(np.float32)
    shape = trimesh.Trimesh(vertices.astype(np.float64), mesh.faces, process=True)
    return Body(index, mesh.material, shape)
