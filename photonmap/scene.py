"""What a user describes: meshes, materials and a camera, in scene units; see `lights` too."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.lights import Light
from photonmap.spectra.curves import Color
from photonmap.textures import Paint, Texture
from photonmap.vectors import Vector


@dataclass(frozen=True)
class Material:
    """A surface, the same on both sides, that may also emit from its front.

    It reflects diffusely, and like a mirror, or both; or with an index of refraction it is smooth
    glass: its closed mesh, wound outwards, parts the inside from the air.

    Parameters
    ----------
    name : how warnings and records call it
    reflectance : diffuse albedo in [0, 1]; glass has none
    emission : radiance leaving the front (counter-clockwise) side, W·m⁻²·sr⁻¹
    mirror : reflectance of a mirror, alone or as a coat; with `reflectance` 1 at most
    ior : index of refraction of the inside, against air; None for what is no glass
    tint : what glass transmits at each crossing of its surface, in [0, 1]
    alpha : opacity in [0, 1]: the chance that a ray does not pass straight through

    A colour is a number (a constant spectrum), a linear RGB triple, or a `Spectrum`; reflectance,
    emission and alpha may be a `Texture`.
    """

    name: str = "grey"
    reflectance: Paint = 0.5
    emission: Paint = 0.0
    mirror: Color = 0.0
    ior: float | None = None
    tint: Color = 1.0
    alpha: float | Texture = 1.0

    @classmethod
    def polished(cls, name: str = "mirror", mirror: Color = 1.0) -> Material:
        """Return a perfect mirror of this reflectance."""
        return cls(name, 0.0, mirror=mirror)

    @classmethod
    def glass(cls, name: str = "glass", ior: float = 1.5, tint: Color = 1.0) -> Material:
        """Return smooth glass."""
        return cls(name, 0.0, ior=ior, tint=tint)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one material.

    Parameters
    ----------
    vertices : (V, 3) float64, scene units
    faces : (F, 3) int, rows of vertex indices, counter-clockwise seen from the front
    material : of every face
    name : the object it belongs to; meshes of one name share an object id
    normals : (V, 3) float64 shading normals, or None; a row that is zero or not finite
        means flat
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

    @classmethod
    def from_trimesh(
        cls, mesh: Any, material: Material | None = None, name: str = "mesh", smooth: bool = False
    ) -> Mesh:
        """Take the geometry of a `trimesh.Trimesh`; `smooth` takes its vertex normals too."""
        normals = mesh.vertex_normals if smooth else None
        return cls(mesh.vertices, mesh.faces, material or Material(), name, normals)


@dataclass(frozen=True)
class Camera:
    """A pinhole.

    Parameters
    ----------
    origin, target : scene units
    up : any vector not along the view
    fov : full vertical angle, degrees
    """

    origin: Vector
    target: Vector
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = 40.0


@dataclass
class Scene:
    """All that is rendered. Emitting meshes are lights too.

    Parameters
    ----------
    meshes : the surfaces
    lights : lights that are no surface
    camera : None frames the scene from +z
    name : how records call it
    """

    meshes: list[Mesh] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    name: str = "scene"
