"""Save a scene as OBJ, MTL and TOML, or as glTF, with spectra and images in a folder beside."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming, warn
from photonmap.io.readers.decoding import Ints
from photonmap.io.writers.gltf import write_gltf
from photonmap.io.writers.toml import Assets, check_name, name_materials, write_scene
from photonmap.runtime.wording import listed
from photonmap.runtime.writing import check_file, check_length, drafts_beside
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, Number, parameters_of
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.layers import explicit
from photonmap.scene.textures import Texture
from photonmap.spectra.rgb_spaces import encode_srgb

_TOML = ".toml"
_COMPANIONS = {".obj": (".mtl", _TOML), ".glb": (_TOML,), ".gltf": (".bin", _TOML)}
"""Suffixes of files that scenes are saved as, and of those that may be written beside them."""


def companions(path: Path) -> list[Path]:
    """Return the files that may be written beside a file, and the folder.

    Another suffix, or a name that is too long, is an `InputError`.
    """
    suffix = path.suffix.lower()
    if suffix not in _COMPANIONS:
        known = ", ".join(_COMPANIONS)
        raise InputError(f"does not end in one of {known}, which scenes are saved as", path)
    beside = [*map(path.with_suffix, _COMPANIONS[suffix]), path.with_name(_folder(path))]
    for each in (path, *beside):
        check_length(each)
    return beside


def _folder(path: Path) -> str:
    return f"{path.stem}_files"


def save_scene(scene: Scene, path: str | PathLike[str]) -> list[Path]:
    """Write FILE.obj with FILE.mtl and FILE.toml, or FILE.glb, or FILE.gltf with FILE.bin.

    Beside glTF, FILE.toml is written only for what glTF cannot hold, or in place of one that is
    there. Spectra and other files that these name are in the folder FILE_files. All of them are
    written, or none.

    `photonmap.load_scene` reads the same arrays, spectra, cameras and lights from OBJ, with these
    exceptions: tangents are left out, with a warning, meshes of one name and material become one,
    vertices that no face uses are left out, textures become linear floats multiplied by their
    factor, and colours of faces become colours of vertices. In glTF, coordinates are float32, about
    the middle of the scene unless they are so already, and textures have 8 bits, or 16 if they are
    not 8-bit sRGB in the scene.

    Parameters
    ----------
    scene : what to write
    path : FILE.obj, FILE.glb or FILE.gltf; its folder is made if it is missing

    Returns
    -------
    The files that were written, this one first, and the folder FILE_files if there is one

    Raises
    ------
    InputError
        if the path is not of this kind, or in a folder that cannot be written to, the scene has no
        faces, or a name cannot be written
    OSError
        if writing fails; nothing is left of it
    """
    path = Path(path)
    companions(path)
    with naming("the file", path):
        check_name(path.stem)
    if not any(len(mesh.faces) for mesh in scene.meshes):
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to write")
    check_file(path)
    is_obj = path.suffix.lower() == ".obj"
    write: Callable[[Scene, Path, Assets], None] = _write_obj if is_obj else write_gltf
    with drafts_beside(path) as folder:
        draft = folder / path.name
        with Assets(draft.with_name(_folder(path))) as assets:
            write(scene, draft, assets)
        toml = draft.with_suffix(_TOML)
        if path.with_suffix(_TOML).exists() and not toml.exists():
            toml.write_text(f'mesh = "{path.name}"\n', "utf-8")
        return _publish(folder, path)


def _write_obj(scene: Scene, path: Path, assets: Assets) -> None:
    named = name_materials(scene)
    blocks = []
    for name, material in named.items():
        with naming("material"):
            check_name(material.name)
        blocks.append("\n".join([f"newmtl {name}", *_statements(material, name, assets), ""]))
    path.with_suffix(".mtl").write_text("\n".join(blocks), "utf-8")
    write_obj(scene, path, {id(material): name for name, material in named.items()})
    kept = {name: values for name, material in named.items() if (values := beyond_mtl(material))}
    lost = [mesh.name for mesh in scene.meshes if mesh.tangents is not None]
    if lost:
        warn(f"OBJ holds no tangents: those of {listed(lost)} will follow from coordinates")
    lines = write_scene(kept, scene.every_camera, scene.lights, assets)
    path.with_suffix(_TOML).write_text("\n".join(lines), "utf-8")


def _publish(folder: Path, path: Path) -> list[Path]:
    """Move what a folder holds to where it belongs, the file that is asked for last."""
    written = [path]
    for draft in sorted(folder.iterdir()):
        place = path.with_name(draft.name)
        if draft.is_dir():
            place.mkdir(exist_ok=True)
            for file in draft.iterdir():
                file.replace(place / file.name)
        elif place != path:
            draft.replace(place)
        if place != path:
            written.append(place)
    (folder / path.name).replace(path)
    return written


_BY_OTHERS = ("name", "relief", "dispersion")  # Attributes that statements hold in another form
_ROWS = 3 << 14  # Rows written at a time: whole triangles


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
