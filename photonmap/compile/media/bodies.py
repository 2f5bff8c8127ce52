"""Closed bodies of glass, the order in which they claim space, and what lies beside triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.errors import warn
from photonmap.kernels.core.records import Geometry
from photonmap.runtime.wording import listed
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.spectra.curves import Spectrum

TOUCHING = 1e-6
"""Distance, in sizes of the scene, below which surfaces touch."""

UNRANKED = (1 << 30) - 1
"""Rank of meshes that are no bodies."""

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]


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

    That is glass that absorbs (ids of materials), and glass that touches other glass or contains
    it. Of bodies that overlap, the one of the higher priority claims what they share, or else the
    smaller one.
    """
    solid = [i for i, mesh in enumerate(meshes) if is_solid(mesh.material)]
    if not solid:
        return []
    import trimesh

    boxes = {i: np.stack([f(meshes[i].vertices, axis=0) for f in (np.min, np.max)]) for i in solid}
    scaled = {i: (box - frame.center) / frame.size for i, box in boxes.items()}
    met = {i: any(j != i and near(scaled[i], *scaled[j]) for j in solid) for i in solid}
    found, unknown = [], []
    for i in solid:
        absorbs = id(meshes[i].material) in absorbing
        if not absorbs and not met[i]:
            continue
        vertices = ((meshes[i].vertices - frame.center) / frame.size).astype(np.float32)
        shape = trimesh.Trimesh(vertices.astype(np.float64), meshes[i].faces, process=True)
        body = Body(i, meshes[i].material, shape)
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


class Sides(NamedTuple):
    """Of T triangles."""

    mesh: Ints
    """(T, 2), the mesh of glass in which the front and the back lie, -1 for air"""
    kept: Bools
    """(T,), whether light changes there"""


def find_sides(
    meshes: Sequence[Mesh], bodies: Sequence[Body], geometry: Geometry, owner: NDArray[np.int64]
) -> Sides:
    """Return what lies on each side of triangles, and which of those of glass to keep.

    One is left out where the same glass lies on both sides, or where it lies on the surface of a
    body that claims more: its triangles are kept there. `owner`, (T,), is the mesh of each
    triangle.
    """
    glass = np.array([is_solid(mesh.material) for mesh in meshes])[owner]
    ranks = ranks_of(len(meshes), bodies)
    mesh = np.full((len(owner), 2), -1, np.int32)
    mesh[glass, 1] = owner[glass]
    claimed = np.full((len(owner), 2), UNRANKED + 1, np.int32)
    claimed[glass, 1] = ranks[owner[glass]]
    for rank, body in enumerate(bodies):
        if body.inside < 0:
            claimed[owner == body.mesh] = rank, UNRANKED
    kept = np.ones(len(owner), bool)
    centroids = geometry.vertices[geometry.triangles].mean(axis=1, dtype=np.float64)
    for rank, body in enumerate(bodies):
        rows = np.flatnonzero((owner != body.mesh) & near(body.bounds, centroids, centroids))
        step = TOUCHING * geometry.normals[rows]
        within = np.stack([body.contains(centroids[rows] + step * sign) for sign in (1, -1)], 1)
        kept[rows] &= ~(glass[rows] & (within[:, 0] != within[:, 1]) & (ranks[owner[rows]] > rank))
        within &= rank < claimed[rows]
        mesh[rows] = np.where(within, body.inside, mesh[rows])
        claimed[rows] = np.where(within, rank, claimed[rows])
    numbers: dict[object, int] = {}
    each = [numbers.setdefault(medium_of(mesh.material), len(numbers)) for mesh in meshes]
    media = np.array([*each, -1], np.int32)  # the last one is air
    return Sides(mesh, kept & ~(glass & (media[mesh[:, 0]] == media[mesh[:, 1]])))


def medium_of(material: Material) -> tuple[object, ...]:
    """Return what the inside of a material does with light: equal for equal insides of glass."""
    color, distance = material.attenuation_color, material.attenuation_distance
    index = material.ior, material.abbe, material.dispersion
    if isinstance(color, Spectrum):
        return *index, id(color), distance
    clear = bool(np.all(np.equal(color, 1.0)))
    return *index, *((1.0, None) if clear else (tuple(np.ravel(color).tolist()), distance))
