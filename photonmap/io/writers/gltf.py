"""Write a scene as glTF 2.0, and what glTF cannot hold as TOML beside it."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from photonmap.io.readers.gltf import Gltf
from photonmap.io.readers.meshes import Part, build_mesh, side_axes
from photonmap.io.readers.registry import ReadOptions
from photonmap.io.writers import gltf_draft
from photonmap.io.writers.gltf_draft import Draft, Json
from photonmap.io.writers.toml import Assets, name_materials, write_scene
from photonmap.scene import lights
from photonmap.scene.camera import ALL, NOT_IN_FILES, Camera, check_camera, frame_of
from photonmap.scene.material import LOBES, Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import (
    Emission,
    Fluorescent,
    Parameter,
    Reflectance,
    Text,
    parameters_of,
)
from photonmap.scene.parameters import Part as PartParameter
from photonmap.scene.projections import Orthographic, Pinhole
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.layers import explicit
from photonmap.scene.surfaces.relief import BumpMap
from photonmap.scene.textures import Texture, is_black
from photonmap.spectra.curves import Floats, Spectrum

_LIGHTS = "KHR_lights_punctual"
_NEAR = 1e-3  # Distance of the near plane, by the size of the scene
_FAR = 1e3
_SMALL = (1 << 16) - 1
"""Vertices from which on indices take 32 bits; the last index of 16 bits is not allowed."""


def write_gltf(scene: Scene, path: Path, assets: Assets) -> None:
    """Write a scene with faces as FILE.glb, or FILE.gltf and FILE.bin; and the rest as FILE.toml.

    What the TOML file has to say is found by reading materials, cameras and lights back.
    """
    scene = replace(scene, meshes=_with_white(scene.meshes))
    meshes = []
    for mesh in scene.meshes:
        if len(mesh.faces):
            normals, tangents = mesh.unit_normals, mesh.unit_tangents
            part = Part(mesh.vertices, mesh.faces, normals, mesh.uv, mesh.colors, tangents)
            meshes.append(build_mesh(Path(path.name), part, mesh.material, mesh.name))
    draft, named = Draft(), name_materials(scene)
    scene = _with_names(scene, named)
    textures = gltf_draft.TextureWriter(draft)
    for name, material in named.items():
        draft.add("materials", gltf_draft.MaterialWriter(material, name, textures).write())
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
        path.write_bytes(gltf_draft.pack_glb(tree, data))
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


def _find_differences(
    scene: Scene, named: Mapping[str, Material], read: Gltf, assets: Assets
) -> list[str]:
    """Return the lines of the TOML file that make a scene of what was read; none if it is one."""
    changes = {
        name: found
        for index, (name, material) in enumerate(named.items())
        if (found := find_material_changes(material, read.material(index)))
    }
    views, lamps = read.cameras([]), {light.name: light for light in read.lights()}
    same = [is_same_view(*pair) for pair in zip(scene.cameras, views, strict=False)]
    cameras = scene.cameras if sum(same) < len(scene.cameras) else []
    others = [each for each in scene.lights if not is_same_light(each, lamps.get(each.name))]
    return write_scene(changes, cameras, others, assets)


def _with_names(scene: Scene, named: Mapping[str, Material]) -> Scene:
    cameras = [check_camera(camera) for camera in scene.every_camera]
    emitting = [name for name, material in named.items() if not is_black(material.emission)]
    named_lights = lights.check_lights(scene.lights, emitting)
    return Scene(scene.meshes, named_lights, name=scene.name, cameras=cameras)


def _add_meshes(
    draft: Draft, meshes: list[Mesh], named: Mapping[str, Material], middle: Floats
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
        node: Json = {**label, "mesh": draft.add("meshes", {"primitives": primitives})}
        if origin.any():
            node["translation"] = origin.tolist()
        nodes.append(draft.add("nodes", node))
    return nodes


def _add_primitive(draft: Draft, mesh: Mesh, origin: Floats, material: int) -> Json:
    attributes = {"POSITION": draft.add_rows(mesh.vertices - origin, "<f4", limits=True)}
    uv = None if mesh.uv is None else np.stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]], axis=1)
    tables = {"NORMAL": mesh.normals, "TEXCOORD_0": uv}
    for name, rows in {**tables, "TANGENT": mesh.tangents, "COLOR_0": mesh.colors}.items():
        if rows is not None:
            attributes[name] = draft.add_rows(rows, "<f4")
    kind = "<u2" if len(mesh.vertices) < _SMALL else "<u4"
    indices = draft.add_rows(mesh.faces.ravel(), kind)
    return {"attributes": attributes, "indices": indices, "material": material}


def add_cameras(draft: Draft, cameras: Sequence[Camera], size: float) -> list[int]:
    """Add the cameras that glTF knows; return their nodes.

    size : of the scene, which planes that cut off nothing lie at
    """
    nodes = []
    for camera in cameras:
        look: Json
        match camera.model:
            case Pinhole(fov):
                lens = {"yfov": math.radians(fov), "znear": _NEAR * size}
                look = {"type": "perspective", "perspective": lens}
            case Orthographic(height):
                lens = {"xmag": height / 2.0, "ymag": height / 2.0}
                lens |= {"znear": 0.0, "zfar": _FAR * size}
                look = {"type": "orthographic", "orthographic": lens}
            case _:
                continue
        view, right, up = frame_of(camera)
        node = {
            "name": camera.name or "camera",
            "camera": draft.add("cameras", look),
            "matrix": _matrix(right, up, -view, camera.origin),
        }
        nodes.append(draft.add("nodes", node))
    return nodes


def add_lights(draft: Draft, lights: Sequence[lights.Light], taken: Collection[str]) -> list[int]:
    """Add the lights that glTF knows under names that its reader keeps; return their nodes.

    lights : with names; a photometric light is written as a point
    taken : names that lights in glTF files cannot have
    """
    items: list[Json] = []
    nodes = []
    for light in lights:
        described = _describe(light)
        if described is None or light.name in (ALL, *taken) or set(light.name) & set(NOT_IN_FILES):
            continue
        item, axis, position = described
        z = -np.array(axis, np.float64)
        x, y = side_axes(z)
        color, intensity = gltf_draft.split_exactly(gltf_draft.rgb_emission(light.color))
        node = {
            "name": light.name,
            "extensions": draft.use(_LIGHTS, {"light": len(items)}),
            "matrix": _matrix(x, y, z, position),
        }
        items.append({"name": light.name, "color": color, "intensity": intensity, **item})
        nodes.append(draft.add("nodes", node))
    if items:
        draft.tree["extensions"] = {_LIGHTS: {"lights": items}}
    return nodes


def _describe(light: lights.Light) -> tuple[Json, Any, Any] | None:
    """Return the JSON of a light without its colour, its axis and position; None if unknown."""
    match light:
        case lights.PointLight() | lights.PhotometricLight():
            return {"type": "point"}, (0.0, 0.0, -1.0), light.position
        case lights.DirectionalLight():
            return {"type": "directional"}, light.emitter().axis, (0.0, 0.0, 0.0)
        case lights.SpotLight(outer=outer) if outer <= 90.0:
            angles = {
                "innerConeAngle": math.radians(light.inner),
                "outerConeAngle": math.radians(outer),
            }
            return {"type": "spot", "spot": angles}, light.emitter().axis, light.position
    return None


def _matrix(x: Any, y: Any, z: Any, origin: Any) -> list[float]:
    columns = np.zeros((4, 4))
    columns[:, :3] = np.array([x, y, z, origin])
    columns[3, 3] = 1.0
    return [float(value) for value in columns.ravel() + 0.0]


def _close(a: Any, b: Any) -> bool:
    """Return whether numbers are the same to kernels, which compute with float32."""
    return np.allclose(a, b, rtol=1e-9, atol=1e-12)


def find_material_changes(wanted: Material, read: Material) -> Json:
    """Return the attributes of a material that were read otherwise; textures stay as they are."""
    found, wanted = {}, explicit(wanted)
    for attribute, parameter in parameters_of(Material).items():
        value, other = getattr(wanted, attribute), getattr(read, attribute)
        owners = [name for name, lobe in LOBES.items() if attribute in lobe.parameters]
        is_idle = bool(owners) and not any(map(wanted.has, owners))
        if isinstance(parameter, Text) or isinstance(value, Texture) or is_idle:
            continue
        if attribute == "coat_relief":
            value, other = wanted.own_coat_relief, read.own_coat_relief
            if type(value) is not type(other):
                found[attribute] = value
            continue
        if isinstance(parameter, PartParameter):
            if isinstance(value, BumpMap) or (attribute == "dispersion" and value != other):
                found[attribute] = value
            continue
        if attribute == "abbe" and wanted.dispersion is not None:
            continue
        is_dye = isinstance(parameter, Fluorescent)
        if value != other if is_dye else not _is_same(parameter, value, other):
            found[attribute] = value
    return found


def _is_same(parameter: Parameter, value: Any, other: Any) -> bool:
    """Return whether two values look the same in any bands.

    An equal triple is D65 as an emission, but a constant spectrum as a reflectance.
    """
    if isinstance(value, Spectrum):
        return False
    if isinstance(other, Texture):
        if np.ptp(other.image.texels, axis=(0, 1)).any():
            return False
        other = other.mean  # white, to hold opacity
    if value is None or other is None:
        return value is other
    if isinstance(parameter, Reflectance):
        return _close(np.ones(3) * value, np.ones(3) * other)
    if isinstance(parameter, Emission) and np.any(value) and np.ndim(value) != np.ndim(other):
        return False
    return _close(value, other)


def is_same_view(wanted: Camera, read: Camera) -> bool:
    """Return whether two checked cameras give the same picture, and have the same name."""
    if wanted.projection is not None or wanted.lens is not None:
        return False
    same_place = _close([wanted.origin, *frame_of(wanted)], [read.origin, *frame_of(read)])
    same_size = _close([wanted.fov, wanted.height or 0.0], [read.fov, read.height or 0.0])
    return same_place and same_size and (wanted.name or "camera") == read.name


def is_same_light(wanted: lights.Light, read: lights.Light | None) -> bool:
    """Return whether a light was read as it was, up to rounding; `read` is None where it was not.

    The target of a spot only gives a direction, as does the length of a direction.
    """
    if type(wanted) is not type(read) or wanted.group not in ("", wanted.name):
        return False
    assert read is not None
    declared = parameters_of(type(wanted))[wanted.color_attribute or ""]
    if not _is_same(declared, wanted.color, read.color):
        return False
    return _close(_shape(wanted), _shape(read))


def _shape(light: lights.Light) -> list[float]:
    """Return where a light stands and how it shines."""
    emitter = light.emitter()
    return [*(emitter.position or ()), *emitter.axis, *emitter.parameters.values(), emitter.cone]
