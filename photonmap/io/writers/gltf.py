"""Write a scene as glTF 2.0, and what glTF cannot hold as TOML beside it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.gltf import Gltf
from photonmap.io.readers.meshes import Part, build_mesh
from photonmap.io.readers.registry import ReadOptions
from photonmap.io.writers.assets import Assets
from photonmap.io.writers.gltf_parts.differences import (
    find_material_changes,
    is_same_light,
    is_same_view,
)
from photonmap.io.writers.gltf_parts.draft import Draft, pack_glb
from photonmap.io.writers.gltf_parts.materials import write_material
from photonmap.io.writers.gltf_parts.nodes import add_cameras, add_lights
from photonmap.io.writers.gltf_parts.textures import TextureWriter
from photonmap.io.writers.mtl import name_materials
from photonmap.io.writers.toml import write_cameras, write_lights, write_materials
from photonmap.scene.camera import check_camera
from photonmap.scene.lights import check_light, name_lights
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.scene.textures import is_black

_SMALL = (1 << 16) - 1
"""Vertices from which on indices take 32 bits; the last index of 16 bits is not allowed."""


def write_gltf(scene: Scene, path: Path, assets: Assets) -> None:
    """Write FILE.glb, or FILE.gltf and FILE.bin; and FILE.toml if glTF cannot hold all.

    What the TOML file has to say is found by reading materials, cameras and lights back.

    Parameters
    ----------
    path : FILE.glb or FILE.gltf
    assets : takes the files that the TOML file names

    Raises
    ------
    InputError
        if there are no faces, a light or camera is not valid, or a GLB file would be too large
    """
    scene = replace(scene, meshes=_with_white(scene.meshes))
    meshes = [_checked(mesh, path) for mesh in scene.meshes if len(mesh.faces)]
    if not meshes:
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to write")
    draft, named = Draft(), name_materials(scene)
    scene = _with_names(scene, named)
    textures = TextureWriter(draft)
    for name, material in named.items():
        draft.add("materials", write_material(material, name, draft, textures))
    low = np.min([mesh.vertices.min(axis=0) for mesh in meshes], axis=0)
    high = np.max([mesh.vertices.max(axis=0) for mesh in meshes], axis=0)
    nodes = _add_meshes(draft, meshes, named, 0.5 * low + 0.5 * high)
    size = float((high - low).max()) or 1.0
    nodes += add_cameras(draft, scene.every_camera, size)
    nodes += add_lights(draft, scene.lights, named)
    draft.tree |= {"scene": 0, "scenes": [{"name": scene.name, "nodes": nodes}]}
    is_glb = path.suffix.lower() == ".glb"
    tree, data = draft.finish(None if is_glb else quote(f"{path.stem}.bin"))
    if is_glb:
        path.write_bytes(pack_glb(tree, data))
    else:
        path.with_suffix(".bin").write_bytes(data)
        path.write_text(json.dumps(tree, indent=1, ensure_ascii=False), "utf-8")
    read = Gltf(path, tree, memoryview(data), options=ReadOptions(), losses={})
    if lines := _find_differences(scene, named, read, assets):
        text = "\n".join([f'mesh = "{path.name}"', "", *lines])
        path.with_suffix(".toml").write_text(text, "utf-8")
    draft.warn()


def _with_white(meshes: list[Mesh]) -> list[Mesh]:
    """Return meshes whose colours are those of vertices, and a factor of what is white."""
    white: dict[int, Material] = {}
    result = []
    for mesh in meshes:
        if mesh.colors is not None:
            painted = replace(mesh.material, reflectance=(1.0, 1.0, 1.0))
            split = mesh.split_corners() if mesh.colors.ndim == 3 else mesh
            mesh = replace(split, material=white.setdefault(id(mesh.material), painted))
        result.append(mesh)
    return result


def _checked(mesh: Mesh, path: Path) -> Mesh:
    """Return a mesh without the vertices that no face uses."""
    part = Part(
        mesh.vertices, mesh.faces, mesh.unit_normals, mesh.uv, mesh.colors, mesh.unit_tangents
    )
    return build_mesh(Path(path.name), part, mesh.material, mesh.name)


def _find_differences(
    scene: Scene, named: Mapping[str, Material], read: Gltf, assets: Assets
) -> list[str]:
    """Return the lines of the TOML file that make a scene of what was read; none if it is one."""
    changes = {
        name: found
        for index, (name, material) in enumerate(named.items())
        if (found := find_material_changes(material, read.material(index)))
    }
    views, lamps = read.cameras(), {light.name: light for light in read.lights()}
    same = [is_same_view(*pair) for pair in zip(scene.cameras, views, strict=False)]
    cameras = scene.cameras if sum(same) < len(scene.cameras) else []
    lights = [each for each in scene.lights if not is_same_light(each, lamps.get(each.name))]
    return [
        *write_materials(changes, assets),
        *write_cameras(cameras, assets),
        *write_lights(lights, assets),
    ]


def _with_names(scene: Scene, named: Mapping[str, Material]) -> Scene:
    """Return a scene with checked cameras and lights, all lights with names."""
    cameras = [check_camera(camera) for camera in scene.every_camera]
    emitting = [name for name, material in named.items() if not is_black(material.emission)]
    lights = name_lights([check_light(light) for light in scene.lights], emitting)
    return Scene(scene.meshes, lights, name=scene.name, cameras=cameras)


def _add_meshes(
    draft: Draft, meshes: list[Mesh], named: Mapping[str, Material], middle: NDArray[np.float64]
) -> list[int]:
    """Add a node for each name of meshes, and a primitive for each mesh; return the nodes.

    Coordinates that float32 cannot represent are taken from the middle of the scene: one point for
    all meshes, so that vertices that coincide still do.
    """
    numbers = {id(material): index for index, material in enumerate(named.values())}
    exact = all(np.array_equal(m.vertices, m.vertices.astype(np.float32)) for m in meshes)
    origin = np.zeros(3) if exact else middle
    nodes = []
    for name in dict.fromkeys(mesh.name for mesh in meshes):
        primitives = [
            _add_primitive(draft, mesh, origin, numbers[id(mesh.material)])
            for mesh in meshes
            if mesh.name == name
        ]
        label = {"name": name} if name else {}
        node: dict[str, Any] = {**label, "mesh": draft.add("meshes", {"primitives": primitives})}
        if origin.any():
            node["translation"] = origin.tolist()
        nodes.append(draft.add("nodes", node))
    return nodes


def _add_primitive(
    draft: Draft, mesh: Mesh, origin: NDArray[np.float64], material: int
) -> dict[str, Any]:
    """Add the arrays of a mesh; v counts downwards."""
    attributes = {"POSITION": draft.add_rows(mesh.vertices - origin, "<f4", limits=True)}
    if mesh.normals is not None:
        attributes["NORMAL"] = draft.add_rows(mesh.normals, "<f4")
    if mesh.uv is not None:
        uv = np.stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]], axis=1)
        attributes["TEXCOORD_0"] = draft.add_rows(uv, "<f4")
    if mesh.tangents is not None:
        attributes["TANGENT"] = draft.add_rows(mesh.tangents, "<f4")
    if mesh.colors is not None:
        attributes["COLOR_0"] = draft.add_rows(mesh.colors, "<f4")
    kind = "<u2" if len(mesh.vertices) < _SMALL else "<u4"
    indices = draft.add_rows(mesh.faces.ravel(), kind)
    return {"attributes": attributes, "indices": indices, "material": material}
