"""Triangle meshes of one material each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.scene.material import Material

LARGEST_COORDINATE = 1e30
"""Largest coordinate that readers accept, scene units: products of several stay within float64."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one material.

    Parameters
    ----------
    vertices : (V, 3) float64, scene units
    faces : (F, 3) int, rows of vertex indices, counter-clockwise seen from the front
    material : of every face
    name : of the object it belongs to; meshes of one name share an object id
    normals : (V, 3) float64 shading normals, or None; where a row is zero or not finite, the
        surface is flat
    uv : (V, 2) float64 texture coordinates, or None
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    material: Material = field(default_factory=Material)
    name: str = "mesh"
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Turn array-likes into arrays of the documented types."""
        for attribute, kind in (
            ("vertices", np.float64),
            ("faces", np.int64),
            ("normals", np.float64),
            ("uv", np.float64),
        ):
            value: ArrayLike | None = getattr(self, attribute)
            if value is not None:
                object.__setattr__(self, attribute, np.ascontiguousarray(value, dtype=kind))

    @property
    def unit_normals(self) -> NDArray[np.float64] | None:
        """The shading normals, (V, 3), of length 1; or 0, where they are not finite too."""
        if self.normals is None:
            return None
        largest = np.abs(self.normals).max(axis=1, initial=0.0, keepdims=True)
        sound = (largest > 0.0) & (largest < np.inf)
        scaled = np.divide(self.normals, largest, out=np.zeros_like(self.normals), where=sound)
        length = np.linalg.norm(scaled, axis=1, keepdims=True)
        return np.divide(scaled, length, out=scaled, where=sound)

    @classmethod
    def from_trimesh(
        cls, mesh: Any, material: Material | None = None, name: str = "mesh", smooth: bool = False
    ) -> Mesh:
        """Return the geometry of a `trimesh.Trimesh`, with its vertex normals if `smooth`."""
        normals = mesh.vertex_normals if smooth else None
        return cls(mesh.vertices, mesh.faces, material or Material(), name, normals)
