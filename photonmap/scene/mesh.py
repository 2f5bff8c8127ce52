"""Triangle meshes of one material each, of arrays or as trimesh has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.runtime.wording import shown
from photonmap.scene.images import decode_srgb
from photonmap.scene.material import Material
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Floats

LARGEST_COORDINATE = 1e30
"""Largest coordinate that readers accept, scene units: products of several stay within float64."""
Rows = Floats | None


@dataclass(frozen=True, eq=False, repr=False)
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
    tangents : (V, 4) float64, or None: x, y and z of the direction in which u rises, of any length,
        and 1 or -1 for whether v rises along normal × tangent or against it, as in glTF and
        MikkTSpace. They count where there are normals; rows of 0, and meshes without, have those
        that follow from the texture coordinates
    colors : diffuse reflectance in [0, 1] in place of the material's, linear RGB, or None:
        (V, 3) of vertices, interpolated linearly over each face; or (F, 1, 3) of faces, which may
        be given as (F, 3) unless there are as many vertices; or (F, 3, 3) of each face's corners

    Raises
    ------
    InputError : the material is none, an array does not hold numbers, or a face holds other than
        whole ones; shapes and ranges are checked when the mesh is rendered
    """

    vertices: Floats
    faces: NDArray[np.int64]
    material: Material = field(default_factory=Material)
    name: str = "mesh"
    normals: Floats | None = None
    uv: Floats | None = None
    colors: Floats | None = None
    tangents: Floats | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            vertices: ArrayLike,
            faces: ArrayLike,
            material: Material = ...,
            name: str = "mesh",
            normals: ArrayLike | None = None,
            uv: ArrayLike | None = None,
            colors: ArrayLike | None = None,
            tangents: ArrayLike | None = None,
        ) -> None:
            """Take array-likes."""

    def __post_init__(self) -> None:
        """Turn array-likes into arrays of the documented types."""
        if not isinstance(self.material, Material):
            raise InputError(
                f"mesh {self.name!r}: {shown(self.material)} is not a material; "
                "make one by photonmap.Material, as in Material('red', (0.6, 0.1, 0.1))"
            )
        for attribute in ("vertices", "faces", "normals", "uv", "colors", "tangents"):
            value: ArrayLike | None = getattr(self, attribute)
            if value is not None:
                kind = np.int64 if attribute == "faces" else np.float64
                with naming(f"mesh {self.name!r}: {attribute}"):
                    object.__setattr__(self, attribute, _as_array(value, kind))
        colors = self.colors
        if colors is not None and colors.shape == (len(self.faces), 3) != self.vertices.shape:
            object.__setattr__(self, "colors", colors[:, None])

    def split_corners(self) -> Mesh:
        """Return the same surface with a vertex for each corner of each face, in their order.

        Colours become those of vertices.
        """
        corners, colors = self.faces.ravel(), self.colors
        if colors is not None and colors.ndim == 3:
            colors = np.broadcast_to(colors, (len(self.faces), 3, 3)).reshape(-1, 3)
        elif colors is not None:
            colors = colors[corners]
        faces = np.arange(len(corners)).reshape(-1, 3)
        return self.with_rows(lambda rows: rows[corners], faces=faces, colors=colors)

    def with_rows(self, change: Callable[[Floats], Floats], **others: Any) -> Mesh:
        """Return the mesh with its rows of vertices changed, and other attributes given."""
        held = {name: getattr(self, name) for name in ("vertices", "normals", "uv", "tangents")}
        changed: dict[str, Any] = {
            name: change(rows) for name, rows in held.items() if rows is not None
        }
        return replace(self, **changed, **others)

    @property
    def unit_normals(self) -> Floats | None:
        """The shading normals, (V, 3), of length 1; or 0, where they are not finite too."""
        return None if self.normals is None else _unit(self.normals)

    @property
    def unit_tangents(self) -> Floats | None:
        """The tangents, (V, 4), of length 1; or 0, where they are not finite or lack a sign."""
        if self.tangents is None:
            return None
        along, sign = _unit(self.tangents[:, :3]), np.sign(self.tangents[:, 3:])
        sound = np.isfinite(sign) & (sign != 0.0) & along.any(axis=1, keepdims=True)
        return np.where(sound, np.hstack([along, sign]), 0.0)

    def __repr__(self) -> str:
        return f"<Mesh {self.name!r}: {len(self.faces)} triangles of {self.material.name!r}>"

    @classmethod
    def from_trimesh(
        cls, mesh: Any, material: Material | None = None, name: str = "mesh", smooth: bool = False
    ) -> Mesh:
        """Return a `trimesh.Trimesh`; of a `trimesh.Scene`, see `Scene.from_trimesh`.

        Parameters
        ----------
        mesh : its colours of vertices or faces, or its texture, become the reflectance
        material : in place of them
        name : of the object
        smooth : whether it gets trimesh's vertex normals
        """
        look = Look(material) if material else look_of(mesh.visual, name)
        normals = mesh.vertex_normals if smooth else None
        return cls(mesh.vertices, mesh.faces, look.material, name, normals, look.uv, look.colors)


def _as_array(value: ArrayLike, kind: type) -> NDArray[Any]:
    """Return an array of numbers of a kind; refuse others, and parts where that is whole."""
    is_whole = kind is np.int64
    try:
        given = np.ascontiguousarray(value, None if is_whole else kind)
        with np.errstate(invalid="ignore"):
            array: NDArray[Any] = given.astype(kind, copy=False)
    except (TypeError, ValueError):
        raise InputError(f"{shown(value)} is not an array of numbers; give one") from None
    if is_whole and given.dtype.kind == "f" and (array != given).any():
        row = int(np.argwhere(array != given)[0][0])
        raise InputError(
            f"row {row} is {given[row].tolist()}; give whole numbers, the indices of vertices"
        )
    return array


def _unit(rows: Floats) -> Floats:
    """Return rows at length 1; 0 for 0, and for what is not finite."""
    largest = np.abs(rows).max(axis=1, initial=0.0, keepdims=True)
    sound = (largest > 0.0) & (largest < np.inf)
    scaled = np.divide(rows, largest, out=np.zeros_like(rows), where=sound)
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.divide(scaled, length, out=scaled, where=sound)


class Look(NamedTuple):
    """A material, and the attributes of `Mesh` that go with it."""

    material: Material
    uv: Rows = None
    colors: Rows = None


def look_of(visual: Any, name: str) -> Look:
    """Return the look of a `trimesh.Trimesh`, of which `visual` is the attribute.

    Colours of vertices and faces, and the texels of images, are sRGB; the colour of a material,
    which multiplies its image if it is of the PBR kind, is linear, as in glTF and MTL. Opacity,
    gloss and emission are not taken. The name is that of a material without its own.
    """
    match visual.kind:
        case "vertex":
            return Look(Material(), colors=_decode(visual.vertex_colors))
        case "face":
            return Look(Material(), colors=_decode(visual.face_colors)[:, None])
        case "texture":
            material = visual.material
            image = getattr(material, "baseColorTexture", getattr(material, "image", None))
            factor = getattr(material, "baseColorFactor", None)
            if image is None and factor is None:
                factor = getattr(material, "diffuse", None)
            values = np.asarray((1.0, 1.0, 1.0) if factor is None else factor)[:3]
            scale = 255.0 if values.dtype.kind in "ui" else 1.0
            red, green, blue = (values / scale).tolist()
            name = getattr(material, "name", None) or name
            if image is None:
                return Look(Material(name, (red, green, blue)))
            texels = np.asarray(image.convert("RGB"))
            return Look(Material(name, Texture.of(texels, factor=(red, green, blue))), visual.uv)
    return Look(Material())


def _decode(colors: Any) -> Floats:
    """Return linear RGB, (n, 3), of 8-bit RGBA."""
    linear: Floats = decode_srgb(np.asarray(colors)[:, :3] / 255.0)
    return linear
