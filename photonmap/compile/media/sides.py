"""What lies on each side of each triangle: glass, or air."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.media.bodies import TOUCHING, UNRANKED, Body, is_solid, near, ranks_of
from photonmap.kernels.core.records import Geometry
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.spectra.curves import Spectrum

Ints = NDArray[np.int32]
Bools = NDArray[np.bool_]


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
    body that claims more: its triangles are kept there.

    Parameters
    ----------
    bodies : those that claim space come first
    owner : (T,) the mesh of each triangle
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
    media = _distinct_media(meshes)
    return Sides(mesh, kept & ~(glass & (media[mesh[:, 0]] == media[mesh[:, 1]])))


def _distinct_media(meshes: Sequence[Mesh]) -> Ints:
    """Return a number for what each mesh is made of, and last one for air."""
    numbers: dict[object, int] = {}
    media = [numbers.setdefault(medium_of(mesh.material), len(numbers)) for mesh in meshes]
    return np.array([*media, -1], np.int32)


def medium_of(material: Material) -> tuple[object, ...]:
    """Return what the inside of a material does with light: equal for equal insides of glass."""
    color, distance = material.attenuation_color, material.attenuation_distance
    index = material.ior, material.abbe, material.dispersion
    if isinstance(color, Spectrum):
        return *index, id(color), distance
    clear = bool(np.all(np.equal(color, 1.0)))
    return *index, *((1.0, None) if clear else (tuple(np.ravel(color).tolist()), distance))
