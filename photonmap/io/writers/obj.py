"""Write the meshes of a scene as OBJ, and its materials as MTL."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import naming
from photonmap.io.readers.decoding import Ints
from photonmap.io.writers.toml import Assets, check_name
from photonmap.scene.images import encode_srgb
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, Number, parameters_of
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.layers import explicit
from photonmap.scene.textures import Texture

_BY_OTHERS = ("name", "relief", "dispersion")  # Attributes that statements hold in another form
_ROWS = 3 << 14  # Rows written at a time: whole triangles


def write_mtl(scene: Scene, path: Path, assets: Assets) -> dict[int, str]:
    """Write all materials that faces use.

    Returns dict from the id of a material to its name in the file: the second "wall" is "wall 2"
    """
    named = name_materials(scene)
    blocks = []
    for name, material in named.items():
        with naming("material"):
            check_name(material.name)
        blocks.append("\n".join([f"newmtl {name}", *_statements(material, name, assets), ""]))
    path.write_text("\n".join(blocks), "utf-8")
    return {id(material): name for name, material in named.items()}


def name_materials(scene: Scene) -> dict[str, Material]:
    """Return all materials that faces use under names that differ: the second is "wall 2"."""
    used = {id(mesh.material): mesh.material for mesh in scene.meshes if len(mesh.faces)}
    named: dict[str, Material] = {}
    for material in used.values():
        wanted = name = material.name or "material"
        count = 1
        while name in named:
            count += 1
            name = f"{wanted} {count}"
        named[name] = material
    return named


def beyond_mtl(material: Material) -> dict[str, Any]:
    """Return the attributes of a material that no statement of MTL can hold."""
    return {
        attribute: value
        for attribute, parameter in parameters_of(Material).items()
        if not parameter.mtl and attribute not in _BY_OTHERS
        if (value := getattr(material, attribute)) != getattr(Material, attribute)
    }


def _statements(material: Material, name: str, assets: Assets) -> Iterator[str]:
    """Yield the lines of a material below its name: all that differs from the defaults.

    The reflectance is always among them: without it, a mirror in MTL has none.
    """
    material = explicit(material)
    opaque = 3 if material.mirror != 0.0 else 1
    yield f"illum {opaque if material.ior is None else 4}"
    if material.relief is not None:
        keyword = "map_Bump" if material.relief.is_height else "norm"
        image = assets.texture(material.relief.texture, f"{name} relief")
        yield f"{keyword} -bm {material.relief.factor!r} {image}"
    if material.dispersion is not None:
        yield f"abbe {material.nearest_abbe!r}"
    for attribute, parameter in parameters_of(Material).items():
        if not parameter.mtl or not (parameter.mtl == "Kd" or material.takes(attribute)):
            continue
        value = getattr(material, attribute)
        label = name if parameter.mtl == "Kd" else f"{name} {attribute}"
        if isinstance(value, Texture):
            is_mask = isinstance(parameter, Number)
            yield f"map_{parameter.mtl} {assets.texture(value, label, opacity=is_mask)}"
        elif isinstance(parameter, Number) and value != getattr(Material, attribute):
            yield f"{parameter.mtl} {float(value)!r}"
        elif isinstance(parameter, Colored) and (
            parameter.mtl == "Kd" or value != getattr(Material, attribute)
        ):
            yield f"{parameter.mtl} spectral {assets.color(value, label)}"


def write_obj(scene: Scene, path: Path, materials: Mapping[int, str]) -> None:
    """Write all meshes that have faces, with numbers that are read back to the last bit.

    Colours, which are encoded in sRGB, are read back to within rounding. Those of faces become
    colours of vertices, one vertex for each corner.

    materials : names in the MTL file of the same stem, by the id of the material
    """
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    known = np.zeros(3, np.int64)
    with path.open("w", encoding="utf-8") as file:
        file.write(f"mtllib {path.stem}.mtl\n")
        for mesh in meshes:
            with naming("mesh"):
                check_name(mesh.name)
            file.write(f"o {mesh.name}\nusemtl {materials[id(mesh.material)]}\n")
            known += _write_mesh(file, mesh, known + 1)


def _write_mesh(file: TextIO, mesh: Mesh, first: Ints) -> Ints:
    """Write one mesh without its unused vertices.

    first : (3,) numbers of its first vertex, texture coordinate and normal
    Returns (3,) how many of them it has
    """
    if mesh.colors is not None and mesh.colors.ndim == 3:
        mesh = mesh.split_corners()
    used, renumbered = np.unique(mesh.faces, return_inverse=True)
    normals = mesh.normals
    if normals is not None:  # flat where they are not finite, or 0
        normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, 0.0)
    vertices = mesh.vertices
    if mesh.colors is not None:
        vertices = np.hstack([vertices, encode_srgb(mesh.colors)])
    tables = (("v", vertices), ("vt", mesh.uv), ("vn", normals))
    for keyword, rows in tables:
        if rows is not None:
            for part in _parts(rows[used]):
                file.writelines(f"{keyword} {' '.join(map(repr, row))}\n" for row in part)
    shape = "/".join(
        "" if rows is None else f"{{{index}}}" for index, (_, rows) in enumerate(tables)
    ).rstrip("/")
    numbers = renumbered.reshape(-1, 1) + first
    for part in _parts(numbers):
        corners = [shape.format(*row) for row in part]
        lines = (f"f {' '.join(corners[at : at + 3])}\n" for at in range(0, len(corners), 3))
        file.writelines(lines)
    return np.array([0 if rows is None else len(used) for _, rows in tables])


def _parts(rows: NDArray[Any]) -> Iterator[list[list[Any]]]:
    """Yield rows as lists, so many at a time that lists stay small."""
    return (rows[at : at + _ROWS].tolist() for at in range(0, len(rows), _ROWS))
