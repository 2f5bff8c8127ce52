"""Read glTF 2.0 files, as text and as GLB."""

from __future__ import annotations

import base64
import json
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, decode_file, note_loss
from photonmap.io.readers.gltf_parts.materials import read_material
from photonmap.io.readers.gltf_parts.nodes import (
    NodeItem,
    read_camera,
    read_light,
    unused_name,
)
from photonmap.io.readers.gltf_parts.textures import Textures
from photonmap.io.readers.meshes import Part, build_mesh, move
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.wording import listed, shown
from photonmap.scene.camera import ALL, NOT_IN_FILES
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.spectra.tables import read_bytes

SUFFIXES = (".glb", ".gltf")

_LIGHTS = "KHR_lights_punctual"
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_HARMLESS = re.compile(
    "KHR_materials_|KHR_texture_|EXT_texture_|MSFT_texture_|KHR_lights_punctual$"
    "|KHR_mesh_quantization$|KHR_xmp"
)
"""glTF extensions that a file may require: geometry is the same without them."""
_KEPT = {
    "accessors": ("componentType", "type", "count", "byteOffset"),
    "bufferViews": ("byteOffset", "byteLength", "byteStride"),
    "buffers": ("byteLength",),
}
_MOVES = ("matrix", "translation", "rotation", "scale", "children")
_LARGEST_INTEGER = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}


@dataclass
class _Gltf:
    """A glTF file, and a plain copy of it that holds geometry alone, for trimesh to decode.

    Parameters
    ----------
    path : the file
    tree : its JSON
    binary : the BIN chunk of a GLB file
    options : a user's choices
    losses : what is not simulated
    """

    path: Path
    tree: dict[str, Any]
    binary: bytes | None
    options: ReadOptions
    losses: Losses
    plain: dict[str, list[Any]] = field(default_factory=lambda: {kind: [] for kind in _KEPT})
    data: dict[str, bytes] = field(default_factory=dict)
    copies: dict[tuple[str, int], int] = field(default_factory=dict)
    materials: dict[int | None, Material] = field(default_factory=dict)

    def error(self, message: str) -> InputError:
        """Return an error about this file."""
        return InputError(message, self.path)

    def item(self, kind: str, index: int) -> dict[str, Any]:
        """Return an item of a top-level array."""
        items = self.tree.get(kind, [])
        if type(index) is not int or not 0 <= index < len(items):
            raise self.error(f"names {kind} {shown(index)}, but has {len(items)}; export it again")
        item: dict[str, Any] = items[index]
        return item

    def copy(self, kind: str, index: int) -> int:
        """Copy an item and what it refers to into the plain tree, once; return its index there."""
        if (kind, index) not in self.copies:
            item = self.item(kind, index)
            plain = {key: item[key] for key in _KEPT[kind] if key in item}
            if kind == "accessors":
                if "sparse" in item or "bufferView" not in item:
                    message = "has sparse or compressed vertices, which are not supported"
                    raise self.error(f"{message}; export it without compression")
                plain["bufferView"] = self.copy("bufferViews", item["bufferView"])
            elif kind == "bufferViews":
                plain["buffer"] = self.copy("buffers", item["buffer"])
                end = item.get("byteOffset", 0) + item["byteLength"]
                if end > len(self.data[str(item["buffer"])]):
                    raise self.error("is truncated: its buffers are too short; export it again")
            else:
                plain["uri"] = str(index)
                self.data[str(index)] = self.load(index, item)
            self.copies[kind, index] = len(self.plain[kind])
            self.plain[kind].append(plain)
        return self.copies[kind, index]

    def load(self, index: int, buffer: dict[str, Any]) -> bytes:
        """Return the bytes of a buffer."""
        uri = buffer.get("uri")
        if uri is None:
            if index or self.binary is None:
                raise self.error(f"has no data for buffer {index}; export it again")
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2], validate=True)
        return read_bytes(self.path.parent / unquote(uri))

    def view(self, index: int) -> bytes:
        """Return the bytes of a buffer view."""
        view = self.item("bufferViews", index)
        self.copy("buffers", view["buffer"])
        begin = view.get("byteOffset", 0)
        return self.data[str(view["buffer"])][begin : begin + view["byteLength"]]

    def node_item(self, index: int, item: dict[str, Any], graph: Any) -> NodeItem:
        """Return a camera or a light where a node puts it."""
        wanted = self.item("nodes", index).get("name") or item.get("name") or f"node_{index}"
        plain = re.sub(f"[{re.escape(NOT_IN_FILES)}]", "_", str(wanted))
        name = unused_name(plain, index, self.names)
        return NodeItem(self.path, item, name, graph.get(str(index))[0], self.losses)

    @cached_property
    def names(self) -> set[str]:
        """Names that cameras and lights may not have: those of each other and of materials."""
        return {ALL, *(str(material.get("name")) for material in self.tree.get("materials", []))}

    @cached_property
    def textures(self) -> Textures:
        """Its textures."""
        return Textures(self.path, self.item, self.view, self.options.missing_textures)

    def material(self, index: int | None) -> Material:
        """Return the material of an index, the same one each time."""
        if index not in self.materials:
            material = Material("default")
            if index is not None:
                item = self.item("materials", index)
                material = read_material(index, item, self.textures, self.losses)
            self.materials[index] = material
        return self.materials[index]


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the meshes, cameras and lights at the nodes of a glTF or GLB file.

    Each node that shows a mesh becomes one or more meshes of the node's name. Buffers and images
    that a file names are looked up beside it.

    Raises
    ------
    InputError : as `decode_file`; or the file needs what is not supported
    """
    return decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: Losses) -> Scene:
    import trimesh

    is_glb = path.suffix.lower() == ".glb"
    tree, binary = _split_glb(path, data) if is_glb else (data, None)
    gltf = _Gltf(path, json.loads(tree.decode("utf-8-sig")), binary, options, losses)
    _check_gltf(gltf)
    _note_gltf(gltf)
    primitives = [_plain_primitives(gltf, mesh) for mesh in gltf.tree.get("meshes", [])]
    plain = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": _roots(gltf)}],
        "nodes": [_plain_node(i, node) for i, node in enumerate(gltf.tree.get("nodes", []))],
        "meshes": [{"primitives": [plain]} for mesh in primitives for _, plain in mesh],
        **gltf.plain,
    }
    text = BytesIO(json.dumps(plain).encode())
    resolver: Any = gltf.data
    scene: Any = trimesh.load(text, file_type="gltf", resolver=resolver, process=False)
    decoded = iter(scene.geometry.values())
    parts = [
        [(_gltf_part(gltf, next(decoded), primitive), primitive) for primitive, _ in mesh]
        for mesh in primitives
    ]
    meshes = list(_instances(gltf, scene.graph, parts))
    for name in gltf.textures.lost:
        note_loss(losses, "unreadable textures, with grey in their place,", name)
    cameras = [read_camera(node) for node in _cameras(gltf, scene.graph)]
    lights = [read_light(node) for node in _lights(gltf, scene.graph)]
    return Scene(meshes, lights, cameras[0] if cameras else None, path.stem, cameras)


def _split_glb(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON chunk of a GLB file, and its BIN chunk if there is one."""
    if data[:4] != b"glTF":
        raise InputError("is not a GLB file; name one that begins with 'glTF'", path)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(f"is glTF {version}; export it as glTF 2.0", path)
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= min(length, len(data)):
        size, kind = struct.unpack_from("<I4s", data, at)
        chunks.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if at > len(data) or length > len(data) or b"JSON" not in chunks:
        raise InputError(f"is truncated: {len(data)} of {length} bytes; export it again", path)
    return chunks[b"JSON"], chunks.get(b"BIN\0")


def _check_gltf(gltf: _Gltf) -> None:
    """Refuse other versions, unsupported requirements, and nodes that do not form a forest."""
    version = str(gltf.tree.get("asset", {}).get("version", ""))
    if not version.startswith("2."):
        raise gltf.error(f"is glTF {shown(version)}; export it as glTF 2.0")
    required = gltf.tree.get("extensionsRequired", [])
    if unknown := [name for name in required if not _HARMLESS.match(name)]:
        raise gltf.error(f"needs {listed(unknown)}, which is not supported; export it without")
    seen = set()
    for index in [*_children(gltf), *_roots(gltf)]:
        gltf.item("nodes", index)
        if index in seen:
            raise gltf.error(f"node {index} has two parents; export it again")
        seen.add(index)


def _children(gltf: _Gltf) -> list[int]:
    return [index for node in gltf.tree.get("nodes", []) for index in node.get("children", [])]


def _roots(gltf: _Gltf) -> list[int]:
    """Return the nodes at the top of the scene; without a scene, all that have no parent."""
    if gltf.tree.get("scenes"):
        roots: list[int] = gltf.item("scenes", gltf.tree.get("scene", 0)).get("nodes", [])
        return roots
    children = set(_children(gltf))
    return [index for index in range(len(gltf.tree.get("nodes", []))) if index not in children]


def _plain_node(index: int, node: dict[str, Any]) -> dict[str, Any]:
    return {"name": str(index), **{key: node[key] for key in _MOVES if key in node}}


def _plain_primitives(
    gltf: _Gltf, mesh: dict[str, Any]
) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return the primitives of a mesh that have triangles, and plain copies of them.

    trimesh passes attributes that begin with an underscore through unchanged.
    """
    pairs = []
    for primitive in mesh["primitives"]:
        mode, attributes = primitive.get("mode", _TRIANGLES), primitive["attributes"]
        if mode == _FAN:
            raise gltf.error("has triangle fans, which are not supported; export triangles")
        if mode not in (_TRIANGLES, _STRIP):
            note_loss(gltf.losses, "points and lines")
            continue
        names = {"POSITION": "POSITION", "NORMAL": "_NORMAL", "TEXCOORD_0": "_TEXCOORD_0"}
        copies = {
            plain: gltf.copy("accessors", attributes[name])
            for name, plain in names.items()
            if name in attributes
        }
        plain = {"attributes": copies, "mode": mode}
        if "indices" in primitive:
            plain["indices"] = gltf.copy("accessors", primitive["indices"])
        pairs.append((primitive, plain))
        if any(name.startswith("COLOR_") for name in attributes):
            note_loss(gltf.losses, "vertex colours")
        if primitive.get("targets"):
            note_loss(gltf.losses, "morph targets")
    return pairs


def _gltf_part(gltf: _Gltf, decoded: Any, primitive: dict[str, Any]) -> Part:
    """Return what trimesh decoded as a part; v increases upwards, as in OBJ."""

    def rows(name: str, columns: int) -> NDArray[np.float64] | None:
        if name not in primitive["attributes"]:
            return None
        values = decoded.vertices if name == "POSITION" else decoded.vertex_attributes["_" + name]
        values = np.array(values, np.float64)
        if values.shape != (len(decoded.vertices), columns):
            raise ValueError(f"{name} has the wrong shape")
        accessor = gltf.item("accessors", primitive["attributes"][name])
        if accessor.get("normalized"):
            largest = _LARGEST_INTEGER.get(accessor["componentType"], 1)
            values = np.maximum(values / largest, -1.0)
        return values

    vertices, normals, uv = rows("POSITION", 3), rows("NORMAL", 3), rows("TEXCOORD_0", 2)
    if vertices is None:
        raise ValueError("a mesh has no POSITION")
    if uv is not None:
        uv[:, 1] = 1.0 - uv[:, 1]
    return Part(vertices, np.array(decoded.faces, np.int64).reshape(-1, 3), normals, uv)


def _instances(
    gltf: _Gltf, graph: Any, parts: list[list[tuple[Part, dict[str, Any]]]]
) -> Iterator[Mesh]:
    """Return the meshes of each node in the scene's coordinates, under a name of its own."""
    names: set[str] = set()
    for index, node in _placed(gltf, graph):
        if "mesh" not in node:
            continue
        mesh = gltf.item("meshes", node["mesh"])
        wanted = node.get("name") or mesh.get("name") or "node"
        name = unused_name(str(wanted), index, names)
        matrix = graph.get(str(index))[0]
        for part, primitive in parts[node["mesh"]]:
            if len(part.faces):
                material = gltf.material(primitive.get("material"))
                yield build_mesh(gltf.path, move(part, matrix), material, name)


def _cameras(gltf: _Gltf, graph: Any) -> Iterator[NodeItem]:
    for index, node in _placed(gltf, graph):
        if "camera" in node:
            yield gltf.node_item(index, gltf.item("cameras", node["camera"]), graph)


def _lights(gltf: _Gltf, graph: Any) -> Iterator[NodeItem]:
    known = (gltf.tree.get("extensions", {}).get(_LIGHTS) or {}).get("lights", [])
    for index, node in _placed(gltf, graph):
        light = (node.get("extensions", {}).get(_LIGHTS) or {}).get("light")
        if light is None:
            continue
        if type(light) is not int or not 0 <= light < len(known):
            raise gltf.error(f"names light {shown(light)}, but has {len(known)}; export it again")
        yield gltf.node_item(index, known[light], graph)


def _placed(gltf: _Gltf, graph: Any) -> Iterator[tuple[int, dict[str, Any]]]:
    """Return the nodes that belong to the scene, and their numbers."""
    for index, node in enumerate(gltf.tree.get("nodes", [])):
        if str(index) in graph.nodes:
            yield index, node


def _note_gltf(gltf: _Gltf) -> None:
    for kind in ("animations", "skins"):
        if gltf.tree.get(kind):
            note_loss(gltf.losses, kind)
    for node in gltf.tree.get("nodes", []):
        for name in node.get("extensions", ()):
            if name != _LIGHTS:
                note_loss(gltf.losses, name)
