"""Textures as kernels take them: addresses of texels, one row a use; and painted meshes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.glossy import STEPS, append_stepped
from photonmap.errors import naming
from photonmap.kernels.bsdf.models import GLOSSY
from photonmap.kernels.core import records
from photonmap.kernels.core.records import CLAMP_U, CLAMP_V, NEAREST
from photonmap.scene.images import LINEAR_TABLE, SRGB_TABLE, Image
from photonmap.scene.material import LEAST_ALPHA, Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import parameters_of
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Floats

IMAGES = tuple(
    name
    for name, parameter in parameters_of(Material).items()
    if parameter.textured or name in ("relief", "coat_relief", "anisotropy_map")
)
"""Attributes of materials that may be, or have, textures"""
_CORNERS = np.array([[0.75, 0.75], [1.25, 0.75], [0.75, 1.25]])
"""Where a triangle's corners lie in its tile, in texels; those of centres are 0.5 and 1.5."""


@dataclass
class TextureTable:
    """All textures of a scene as kernels take them."""

    maps: records.Maps  # one row a use
    rows: dict[str, NDArray[np.int32]]
    """by each of `IMAGES`, (M,) the row that each material uses, -1 for none"""
    clear: NDArray[np.int32]  # (M,) likewise, of what panes of textured tint let pass in every band
    opacity: Floats  # (M,) where there is no texture
    uses: list[tuple[Texture, float]] = field(repr=False)
    """which texture each row of `maps` is, and what its reflectances are divided by"""
    images: list[Any] = field(repr=False)
    """keeps the texels alive, of which kernels have the addresses"""

    def textures(self, bands: Bands) -> records.Textures | None:
        """Return textured reflectances; None where there are none."""
        if (self.rows["reflectance"] < 0).all():
            return None
        basis = bands.reflectance_basis.astype(np.float32, order="C")
        return records.Textures(self.maps, self.rows["reflectance"], basis, self._palettes(bands))

    def _palettes(self, bands: Bands) -> records.Palettes | None:
        """Return the spectra of spectral textures, and indices that count them; None without."""
        address, spectra, first = np.zeros(len(self.uses), np.int64), [], 0
        for row, (texture, shrink) in enumerate(self.uses):
            if isinstance(texture, SpectralTexture):
                index = np.ascontiguousarray(texture.index + np.int32(first))
                self.images.append(index)
                address[row] = index.ctypes.data
                spectra.append(texture.averages(bands) / np.float32(shrink))
                first += len(texture.spectra)
        return records.Palettes(address, np.concatenate(spectra)) if spectra else None

    def lobes(
        self, scattering: records.Scattering | None, bands: Bands
    ) -> records.Scattering | None:
        """Return BSDFs with textures of glossy lobes, and albedos of these, where there are any."""
        names = ("roughness", "glossy", "anisotropy_map", "coat", "coat_roughness")
        roughness, glossy, *others = images = [self.rows[name] for name in names]
        if scattering is None or np.less(images, 0).all():
            return scattering
        basis = bands.reflectance_basis.astype(np.float32, order="C")
        varies = (roughness >= 0) & (scattering.below == GLOSSY)
        albedos, first = append_stepped(scattering.albedos, scattering.parameters[:, 3], varies)
        rows = roughness, glossy, self.rows["reflectance"], *others
        maps = records.LobeMaps(self.maps, *rows, basis, first, STEPS, LEAST_ALPHA)
        return scattering._replace(albedos=albedos, maps=maps)

    def holes(self, panes: records.Panes | None) -> records.Alpha | None:
        """Return opacities; None where all surfaces are opaque."""
        if panes is None and (self.rows["alpha"] < 0).all() and (self.opacity == 1.0).all():
            return None
        if panes is not None and (self.clear >= 0).any():
            panes = panes._replace(image=self.clear, maps=self.maps)
        return records.Alpha(self.opacity, self.rows["alpha"], self.maps, panes)

    def emission_textures(
        self, bands: Bands, power: float, rows: int, geometry: records.Geometry
    ) -> records.EmissionTextures | None:
        """Return textured emission, radiances divided by a power; None where there is none.

        Rows are those of `Lights.spectra`, of which the first are those of materials.
        """
        emitting = np.flatnonzero(self.rows["emission"] >= 0)
        if not len(emitting):
            return None
        slot = np.full(rows, -1, np.int32)
        slot[emitting] = np.arange(len(emitting))
        basis = np.tile(bands.emission_basis / power, (len(emitting), 1))
        basis = basis.astype(np.float32, order="C")
        return records.EmissionTextures(
            self.maps, slot, self.rows["emission"][emitting], basis, geometry.uv, geometry.triangles
        )


def compile_textures(
    materials: Sequence[Material], shrink: Floats, clear: Mapping[int, Texture] | None = None
) -> TextureTable:
    """Collect the textures of M checked materials; reflectances are divided by `shrink`, (M,).

    `clear` has those of panes by the number of their material, see
    `photonmap.compile.surfaces.glass.clear_textures`.
    """
    uses: list[tuple[Texture, float]] = []

    def use(image: Texture | None, shrink: float = 1.0) -> int:
        if image is None:
            return -1
        uses.append((image, shrink))
        return len(uses) - 1

    rows = {name: np.full(len(materials), -1, np.int32) for name in IMAGES}
    passed, opacity = np.full(len(materials), -1, np.int32), np.ones(len(materials))
    for index, material in enumerate(materials):
        for name in IMAGES:
            if isinstance(getattr(material, name), float | tuple | None):
                continue  # as most are
            with naming(f"material {material.name!r}: {name}"):
                divisor = shrink[index] if name == "reflectance" else 1.0
                rows[name][index] = use(_image(material, name), divisor)
        if not isinstance(material.alpha, Texture):
            opacity[index] = material.alpha
    for index, texture in (clear or {}).items():
        passed[index] = use(texture)
    maps, images = _maps(uses)
    return TextureTable(maps, rows, passed, opacity, uses, images)


def _image(material: Material, name: str) -> Texture | None:
    """Return the image of an attribute; None where there is none, or it has no effect."""
    value: Any = material.own_coat_relief if name == "coat_relief" else getattr(material, name)
    if name == "anisotropy_map":
        return value.scaled(material.anisotropy) if material.is_brushed else None
    if name in ("relief", "coat_relief"):
        return None if value is None else value.image
    is_idle = name == "coat_roughness" and not material.is_coated
    return value if isinstance(value, Texture) and not is_idle else None


def _maps(uses: list[tuple[Texture, float]]) -> tuple[records.Maps, list[Any]]:
    """Return all uses as a table, and the arrays whose addresses are in it."""
    arrays = [np.ascontiguousarray(texture.image.texels) for texture, _ in uses]
    textures = [texture for texture, _ in uses]
    bytes_of = {False: records.BYTES, True: records.SRGB}
    kinds = [
        records.FLOATS if texels.dtype == np.float32 else bytes_of[texture.image.srgb]
        for texture, texels in zip(textures, arrays, strict=True)
    ]
    factors = [np.array(texture.factor, np.float64) / shrink for texture, shrink in uses]
    maps = records.Maps(
        np.array([array.ctypes.data for array in arrays], np.int64),
        np.array([array.shape for array in arrays], np.int32).reshape(-1, 3),
        np.array(kinds, np.uint8),
        np.array([_flags(texture) for texture in textures], np.uint8),
        np.array([(*t.scale, *t.offset) for t in textures], np.float64).reshape(-1, 4),
        np.array(factors, np.float64).reshape(-1, 3),
        np.stack([LINEAR_TABLE, SRGB_TABLE]),
    )
    return maps, arrays


def _flags(texture: Texture) -> int:
    return int(np.dot((*texture.clamps, texture.nearest), (CLAMP_U, CLAMP_V, NEAREST)))


@dataclass(frozen=True, kw_only=True)
class TriangleColors(Texture):
    """A texture of tiles, whose texels may lie outside the range of the colours that are seen.

    `colors`, (T, 3, 3) float32, are the linear RGB of each triangle's corners.
    """

    colors: NDArray[np.float32]

    @property
    def values(self) -> NDArray[Any]:
        """The colours of corners, in the place of texels."""
        return self.colors


def paint_meshes(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Turn the colours of meshes into textures; those of one material share one.

    Triangles of coloured meshes have corners of their own in the result.
    """
    result = list(meshes)
    groups: dict[int, list[int]] = {}
    for index, mesh in enumerate(meshes):
        if mesh.colors is not None:
            groups.setdefault(id(mesh.material), []).append(index)
    for members in groups.values():
        split = [meshes[index].split_corners() for index in members]
        colors = [np.asarray(mesh.colors, np.float32) for mesh in split]
        texture, uv = _tile(np.concatenate(colors).reshape(-1, 3, 3))
        material = replace(split[0].material, reflectance=texture)
        parts = np.split(uv.reshape(-1, 2), np.cumsum([len(part) for part in colors[:-1]]))
        for index, mesh, part in zip(members, split, parts, strict=True):
            result[index] = replace(mesh, material=material, uv=part, colors=None)
    return result


def _tile(colors: NDArray[np.float32]) -> tuple[TriangleColors, Floats]:
    """Return a texture of tiles, and its coordinates at corners, (T, 3, 2), in texels."""
    columns = math.isqrt(len(colors) - 1) + 1
    rows = -(-len(colors) // columns)
    tiles = np.zeros((rows * columns, 2, 2, 3), np.float32)
    a, b, c = colors.swapaxes(0, 1)
    tiles[: len(colors), 0, 0] = 2.0 * a - 0.5 * (b + c)
    tiles[: len(colors), 0, 1] = 1.5 * b - 0.5 * c
    tiles[: len(colors), 1, 0] = 1.5 * c - 0.5 * b
    tiles[: len(colors), 1, 1] = 1.5 * (b + c) - 2.0 * a
    texels = tiles.reshape(rows, columns, 2, 2, 3).swapaxes(1, 2).reshape(2 * rows, 2 * columns, 3)
    row, column = np.divmod(np.arange(len(colors)), columns)
    uv = 2.0 * np.stack([column, row], axis=1)[:, None] + _CORNERS
    scale = (0.5 / columns, -0.5 / rows)
    return TriangleColors(Image(texels, False), scale, (0.0, 1.0), colors=colors), uv
