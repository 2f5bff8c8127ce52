"""Meshes and materials in words and numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import parameters_of
from photonmap.scene.surfaces.anisotropy_map import AnisotropyMap
from photonmap.scene.surfaces.dispersion import Cauchy, NamedGlass, Sellmeier
from photonmap.scene.surfaces.layers import name_kind
from photonmap.scene.surfaces.relief import BumpMap, NoRelief, NormalMap
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Spectrum

SMOOTH = 1e-4
"""Radians by which normals of a triangle's corners differ where shading is smooth."""
MOST = 1 << 16
"""Triangles of a mesh that are examined, evenly chosen."""


def describe_mesh(mesh: Mesh) -> dict[str, Any]:
    """Return what the JSON says of a mesh."""
    return {
        "name": mesh.name,
        "material": mesh.material.name,
        "triangles": len(mesh.faces),
        "vertices": len(mesh.vertices),
        "uv": mesh.uv is not None,
        "normals": mesh.normals is not None,
        "smooth": _is_smooth(mesh),
        "colors": _describe_colors(mesh),
    }


def _describe_colors(mesh: Mesh) -> dict[str, Any] | None:
    """Return whose the colours are that replace the reflectance, and their mean; None for none."""
    if mesh.colors is None:
        return None
    owners = "vertices" if mesh.colors.ndim == 2 else "faces"
    if mesh.colors.shape[1:] == (3, 3):
        owners = "corners of faces"
    return {"of": owners, "mean": mesh.colors.reshape(-1, 3).mean(axis=0).tolist()}


def _is_smooth(mesh: Mesh) -> bool:
    """Return whether normals vary within triangles."""
    if mesh.normals is None:
        return False
    faces = mesh.faces[:: -(-len(mesh.faces) // MOST)]
    normals = mesh.normals[faces]
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.finfo(float).tiny)
    return bool((np.abs(normals - normals[:, :1]) > SMOOTH).any())


def describe_materials(meshes: Sequence[Mesh]) -> list[dict[str, Any]]:
    """Return what the JSON says of the materials of meshes, in order of appearance.

    Materials of one name, as one in the colours of several meshes, have the names of their meshes.
    """
    users: dict[int, list[Mesh]] = {}
    for mesh in meshes:
        users.setdefault(id(mesh.material), []).append(mesh)
    materials = [group[0].material for group in users.values()]
    count = Counter(material.name for material in materials)
    return [
        {
            "name": material.name,
            "kind": name_kind(material),
            "triangles": sum(len(mesh.faces) for mesh in group),
            **(_name_users(group) if count[material.name] > 1 else {}),
            **_describe_attributes(material),
        }
        for material, group in zip(materials, users.values(), strict=True)
    ]


def _name_users(meshes: Sequence[Mesh]) -> dict[str, list[str]]:
    return {"meshes": [*dict.fromkeys(mesh.name for mesh in meshes)]}


def _describe_attributes(material: Material) -> dict[str, Any]:
    """Return the attributes that differ from the defaults, and the reflectance of what has one."""
    attributes = {}
    for attribute in parameters_of(Material):
        value = getattr(material, attribute)
        if attribute == "name" or not material.takes(attribute):
            continue
        default = getattr(Material, attribute)
        is_default = isinstance(value, float | int | tuple) and value in (default, (default,) * 3)
        if attribute == "reflectance" or not is_default:
            attributes[attribute] = describe_color(value)
    return {name: value for name, value in attributes.items() if value is not None}


def describe_color(color: Any) -> Any:
    """Return a colour for JSON: a number, [red, green, blue], or an object for what is larger."""
    if isinstance(color, Spectrum):
        low, high = color.wavelengths[[0, -1]].tolist()
        return {"spectrum": {"samples": len(color.values), "range_nm": [low, high]}}
    if isinstance(color, SpectralTexture):
        (height, width), low_high = color.index.shape, color.wavelengths[[0, -1]].tolist()
        spectra = {"spectra": len(color.spectra), "samples": len(color.wavelengths)}
        size = {"width": width, "height": height}
        return {"texture": {**size, **spectra, "range_nm": low_high, "mean": list(color.mean)}}
    if isinstance(color, Texture):
        height, width, channels = color.image.texels.shape
        bits = 8 * color.image.texels.itemsize
        return {
            "texture": {
                "width": width,
                "height": height,
                "channels": channels,
                "bits": bits,
                "mean": list(color.mean),
            }
        }
    if isinstance(color, NormalMap | BumpMap):
        return {"type": color.kind, "factor": color.factor, **describe_color(color.texture)}
    if isinstance(color, AnisotropyMap):
        return describe_color(color.texture)
    if isinstance(color, NoRelief):
        return color.kind
    if isinstance(color, Cauchy | Sellmeier | NamedGlass):
        return {"type": color.kind, **asdict(color)}
    return list(color) if isinstance(color, tuple) else color
