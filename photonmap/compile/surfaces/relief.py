"""What follows tangents, as kernels take it: relief, and facets that differ along a surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.glossy import AZIMUTHS, COARSE, GRID, azimuth_albedos
from photonmap.compile.textures import TextureTable
from photonmap.kernels.core import records
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.surfaces.relief import BumpMap, NoRelief, NormalMap
from photonmap.spectra.curves import Floats

STRENGTHS = 9  # Of an image: those between are interpolated


@dataclass
class Reliefs:
    """The relief of a scene's surfaces, and of clear coats over them; and what follows tangents.

    The geometry has materials, and texture coordinates where there are any; `size` is that of the
    kernels' unit of length in scene units; tangents are of vertices, see `given_tangents`.
    """

    geometry: records.Geometry
    table: TextureTable
    size: float
    tangents: Floats

    def of_surfaces(self, materials: Sequence[Material]) -> records.Relief | None:
        """Return what turns the shading normals of M materials; None where nothing does."""
        if (self.table.rows["relief"] < 0).all():
            return None
        return self._compile([material.relief for material in materials], self.table.rows["relief"])

    def of_coats(self, materials: Sequence[Material]) -> records.Relief | None:
        """Return what turns the normals of coats that have their own; None where none has."""
        reliefs = [material.own_coat_relief for material in materials]
        if all(relief is None for relief in reliefs):
            return None
        return self._compile(reliefs, self.table.rows["coat_relief"])

    def _compile(
        self, reliefs: Sequence[NormalMap | BumpMap | NoRelief | None], rows: NDArray[np.int32]
    ) -> records.Relief:
        is_height = np.array([relief is not None and relief.is_height for relief in reliefs])
        factor = np.array([0.0 if relief is None else relief.factor for relief in reliefs])
        by_directions = (rows >= 0) & ~is_height
        return records.Relief(
            self.table.maps,
            rows,
            is_height.astype(np.uint8),
            np.where(is_height, factor / self.size, factor),
            vertex_tangents(self.geometry, by_directions[self.geometry.material], self.tangents),
        )

    def with_anisotropy(
        self, scattering: records.Scattering | None, materials: Sequence[Material]
    ) -> records.Scattering | None:
        """Return BSDFs of M materials with what tells how lobes differ along surfaces, if any."""
        chosen = np.array([each.is_glossy and each.is_anisotropic for each in materials])
        if scattering is None or not chosen.any():
            return scattering
        anisotropy = self._anisotropy(materials, chosen)
        albedos, first = scattering.albedos.copy(), anisotropy.first
        for index in np.flatnonzero(chosen).tolist():
            across, refraction = scattering.parameters[index, [0, 3]].tolist()
            rows = _rows(materials[index], across, refraction)
            albedos[index] = rows[-1, 0]
            if len(rows) > 1:
                albedos = np.concatenate([albedos, rows[:, 0]])
            albedos = np.concatenate([albedos, *rows[:, 1:]])
            first[index] = len(albedos) - AZIMUTHS
        return scattering._replace(albedos=albedos, anisotropy=anisotropy)

    def with_anisotropic_chains(
        self, specular: records.Specular | None, materials: Sequence[Material]
    ) -> records.Specular | None:
        """Return specular lobes with what tells how rough ones differ along surfaces, if any do."""
        chosen = np.array([each.is_anisotropic and each.chain_alpha > 0.0 for each in materials])
        if specular is None or not chosen.any():
            return specular
        return specular._replace(anisotropy=self._anisotropy(materials, chosen))

    def _anisotropy(
        self, materials: Sequence[Material], chosen: NDArray[np.bool_]
    ) -> records.Anisotropy:
        """Return how the chosen materials, (M,), differ along surfaces, with no rows of albedos."""
        stretch = np.array([_largest(material) ** 2 for material in materials]) * chosen
        angles = 2.0 * np.pi * np.array([material.anisotropy_rotation for material in materials])
        turn = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        is_stretched = (stretch > 0.0)[self.geometry.material]
        tangents = vertex_tangents(self.geometry, is_stretched, self.tangents)
        first = np.full(len(materials), -1, np.int32)
        return records.Anisotropy(stretch, turn, first, AZIMUTHS, STRENGTHS, tangents)


def _largest(material: Material) -> float:
    """Return the largest anisotropy of a material; 0 where it is alike in all directions."""
    if not material.is_brushed:
        return material.is_anisotropic * material.anisotropy
    assert material.anisotropy_map is not None
    return material.anisotropy * material.anisotropy_map.strengths[1]


def _rows(material: Material, across: float, refraction: float) -> Floats:
    """Return `azimuth_albedos` of one strength, or of an image's from 0 to the largest, (S, …).

    Where an image has one strength all over, no others are looked up. `across` is α across the
    tangent.
    """
    largest = _largest(material)

    def rows(strength: float, grid: int = COARSE) -> Floats:
        along = across + (1.0 - across) * strength**2
        return azimuth_albedos(along, across, refraction, grid)

    if not material.is_brushed:
        return rows(largest, GRID)[None]
    assert material.anisotropy_map is not None
    low, high = material.anisotropy_map.strengths
    places = np.linspace(0.0, largest, STRENGTHS) if low < high else np.full(STRENGTHS, largest)
    return np.array([rows(strength) for strength in places.tolist()])


def given_tangents(meshes: Sequence[Mesh]) -> Floats:
    """Return the tangents that meshes have, (V, 4), of length 1 and with a sign; 0 for none."""
    rows = []
    for mesh in meshes:
        tangents = mesh.unit_tangents
        normals = None if tangents is None else mesh.unit_normals
        if tangents is None or normals is None:
            rows.append(np.zeros((len(mesh.vertices), 4)))
        else:
            rows.append(np.where(normals.any(axis=1, keepdims=True), tangents, 0.0))
    return np.concatenate(rows)


def vertex_tangents(
    geometry: records.Geometry, chosen: NDArray[np.bool_], given: Floats
) -> NDArray[np.float32]:
    """Return directions at vertices in which u rises, (V, 4), unit or 0 where the mesh is flat.

    The last column is the sign of those that are given (`given_tangents`), and 0 of others. Each of
    these is the mean over the chosen triangles, (T,), around it, weighted by their angles there, in
    the plane of the vertex's normal (as MikkTSpace: M. Mikkelsen, "Simulation of wrinkled surfaces
    revisited", 2008).
    """
    tangents = np.zeros(geometry.vertices.shape)
    if len(geometry.shading_normals) and len(geometry.uv):
        tangents = _by_coordinates(geometry, chosen)
    is_given = given[:, 3:] != 0.0
    joined = np.where(is_given, given, np.pad(tangents, ((0, 0), (0, 1))))
    return joined.astype(np.float32)


def _by_coordinates(geometry: records.Geometry, chosen: NDArray[np.bool_]) -> Floats:
    """Return the tangents of vertices, (V, 3), that follow from texture coordinates."""
    tangents = np.zeros(geometry.vertices.shape)
    faces = geometry.triangles[chosen]
    corners = geometry.vertices[faces].astype(np.float64)
    by_u = _rising(corners, geometry.uv[faces].astype(np.float64))
    normals = geometry.shading_normals.astype(np.float64)
    for corner in range(3):
        vertex = faces[:, corner]
        normal = normals[vertex]
        along = _unit(by_u - (by_u * normal).sum(axis=1, keepdims=True) * normal)
        edges = [_unit(corners[:, (corner + k) % 3] - corners[:, corner]) for k in (1, 2)]
        angle = np.arccos(np.clip((edges[0] * edges[1]).sum(axis=1), -1.0, 1.0))
        np.add.at(tangents, vertex, along * angle[:, None])
    tangents[(normals == 0.0).all(axis=1)] = 0.0
    return _unit(tangents)


def _rising(corners: Floats, uv: Floats) -> Floats:
    """Return the direction in which u rises, (T, 3), of any length; 0 where there is none."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    along, across = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = along[:, 0] * across[:, 1] - across[:, 0] * along[:, 1]
    return (first * across[:, 1:] - second * along[:, 1:]) * np.sign(area)[:, None]


def _unit(vectors: Floats) -> Floats:
    """Return vectors of length 1, and 0 for 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 1e-30)
