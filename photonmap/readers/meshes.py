"""Read the geometry of PLY, STL and glTF files, which trimesh decodes."""

from __future__ import annotations

import base64
import json
import logging
import re
import struct
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming, warn
from photonmap.messages import listed, shown
from photonmap.readers.obj_lines import LARGEST_COORDINATE, LARGEST_FACE
from photonmap.readers.polygons import triangulate
from photonmap.readers.tables import read_bytes
from photonmap.scene import Material, Mesh
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Color

SUFFIXES = (".ply", ".stl", ".glb", ".gltf")

Losses = dict[str, dict[str, None]]
"""What is read but not simulated, and whose it is, in order of appearance."""

_COLORS = ("red", "green", "blue", "alpha")
_INDICES = ("vertex_indices", "vertex_index")
_UV = (("texture_u", "texture_v"), ("u", "v"), ("s", "t"))
_WEDGES = ("texcoord", "texnumber")

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_HARMLESS = re.compile(
    "KHR_materials_|KHR_texture_|EXT_texture_|MSFT_texture_|KHR_lights_punctual$"
    "|KHR_mesh_quantization$|KHR_xmp"
)
"""glTF extensions that a file may require, for geometry is the same without them."""
_KEPT = {
    "accessors": ("componentType", "type", "count", "byteOffset"),
    "bufferViews": ("byteOffset", "byteLength", "byteStride"),
    "buffers": ("byteLength",),
}
_MOVES = ("matrix", "translation", "rotation", "scale", "children")
_LARGEST_INTEGER = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}


@dataclass(frozen=True)
class _Part:
    """Triangles as `photonmap.scene.Mesh` holds them, not checked yet."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uv: NDArray[np.float64] | None = None


def read_mesh(path: str | PathLike[str]) -> list[Mesh]:
    """Read the triangles of a PLY, STL, GLB or glTF file.

    Polygons are cut into triangles. Normals and texture coordinates are those of the file;
    without normals a mesh is flat. Vertices in no face are left out. The material is grey and
    called "default", unless a glTF file names another, whose reflectance is the base colour
    where there is no texture. Each node of a glTF scene that shows a mesh becomes one or more
    meshes of the node's name, in the scene's coordinates. What is read but not simulated is
    named in one warning.

    Parameters
    ----------
    path : the file; the buffers of a .gltf file are looked up beside it

    Returns
    -------
    list of Mesh, in the order of the file, scene units

    Raises
    ------
    InputError : the file is missing, damaged or of another kind, needs what is not supported,
        or has no triangles
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"is of no known kind; supported: {', '.join(SUFFIXES)}", path)
    data = read_bytes(path)
    losses: Losses = {}
    with _decoding(path):
        meshes = reader(path, data, losses)
    if not meshes:
        raise InputError("has no triangles; export the surfaces as polygons", path)
    if losses:
        told = [
            f"{what} of {listed(owners)}" if owners else what for what, owners in losses.items()
        ]
        warn(f"{path}: not simulated: {'; '.join(told)}")
    return meshes


@contextmanager
def _decoding(path: Path) -> Iterator[None]:
    """Turn whatever damaged data raises into an `InputError`, and keep trimesh quiet."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except Exception as error:
        text = " ".join(str(error).split())
        reason = f" ({text[:80]})" if text else ""
        kind = path.suffix[1:].upper()
        raise InputError(f"is damaged, or no {kind} file{reason}; export it again", path) from None
    finally:
        log.setLevel(level)


def _note(losses: Losses, what: str, owner: str = "") -> None:
    owners = losses.setdefault(what, {})
    if owner:
        owners[owner] = None


def _build_mesh(path: Path, part: _Part, material: Material, name: str) -> Mesh:
    """Check triangles and leave out the vertices they do not use."""
    with naming(f"mesh {shown(name)}", path):
        for kind, rows in (
            ("vertex", part.vertices),
            ("normal", part.normals),
            ("texture coordinate", part.uv),
        ):
            if rows is not None:
                _check_rows(kind, rows)
        _check_indices(part.faces, len(part.vertices))
    used = np.zeros(len(part.vertices), np.bool_)
    used[part.faces] = True
    faces = (np.cumsum(used) - 1)[part.faces]
    normals, uv = (None if rows is None else rows[used] for rows in (part.normals, part.uv))
    return Mesh(part.vertices[used], faces, material, name, normals, uv)


def _check_rows(kind: str, rows: NDArray[np.float64]) -> None:
    bad = ~(np.abs(rows) <= LARGEST_COORDINATE).all(axis=1)
    if bad.any():
        row = int(np.argmax(bad))
        values = ", ".join(f"{value:g}" for value in rows[row])
        limit = f"finite numbers up to {LARGEST_COORDINATE:g}"
        raise InputError(f"{kind} {row} is ({values}); export it with {limit}")


def _check_indices(corners: NDArray[np.int64], count: int) -> None:
    bad = (corners < 0) | (corners >= count)
    if bad.any():
        message = f"a face names vertex {corners[bad][0]}, but there are {count}, counted from 0"
        raise InputError(f"{message}; export it again")


# --- PLY ----------------------------------------------------------------------------------


def _read_ply(path: Path, data: bytes, losses: Losses) -> list[Mesh]:
    from trimesh.exchange.ply import load_ply

    if not data.startswith(b"ply"):
        raise InputError("is no PLY file; name a file that begins with 'ply'", path)
    try:
        loaded = load_ply(BytesIO(data), fix_texture=False, skip_materials=True)
    except ValueError as error:
        if "unexpected length" not in str(error):
            raise
        message = "is damaged, or has polygons of several sizes in binary; export it again"
        raise InputError(f"{message}, triangulated or as ASCII", path) from None
    elements = loaded["metadata"]["_ply_raw"]
    if not all(elements.get(name, {}).get("length") for name in ("vertex", "face")):
        return []
    _note_ply(data, elements, losses)
    part = _ply_part(path, elements["vertex"], elements["face"], losses)
    if not len(part.faces):
        return []
    mesh = _build_mesh(path, part, Material("default"), path.stem)
    if spare := len(part.vertices) - len(mesh.vertices):
        _note(losses, f"{spare} vertices in no face")
    return [mesh]


def _ply_part(path: Path, vertex: dict[str, Any], face: dict[str, Any], losses: Losses) -> _Part:
    """Triangulate the faces; vertices are split where each corner has texture coordinates."""
    vertices, normals = _columns(vertex, tuple("xyz")), _columns(vertex, ("nx", "ny", "nz"))
    if vertices is None:
        raise ValueError("vertices lack x, y or z")
    uv = next((rows for pair in _UV if (rows := _columns(vertex, pair)) is not None), None)
    name = next((name for name in _INDICES if name in face["properties"]), None)
    if name is None:
        raise ValueError(f"faces lack {_INDICES[0]}")
    corners, sizes = _lists(face, name)
    if not (sizes.min() >= 3 and sizes.max() <= LARGEST_FACE):
        row = int(np.argmax((sizes < 3) | (sizes > LARGEST_FACE)))
        message = f"face {row} has {sizes[row]} corners; export it with triangles only"
        raise InputError(message, path)
    with naming(f"mesh {shown(path.stem)}", path):
        _check_indices(corners, len(vertices))
        _check_rows("vertex", vertices)
    if "texcoord" in face["properties"]:
        flat, lengths = _lists(face, "texcoord", np.float64)
        if not np.array_equal(lengths, 2 * sizes):
            raise ValueError("texcoord does not hold two numbers a corner")
        vertices, uv = vertices[corners], flat.reshape(-1, 2)
        normals = None if normals is None else normals[corners]
        corners = np.arange(len(corners))
    if (sizes == 3).all():
        return _Part(vertices, corners.reshape(-1, 3), normals, uv)
    triangles, owners = triangulate(vertices, corners.astype(np.int32), sizes)
    if empty := len(sizes) - np.count_nonzero(np.bincount(owners)):
        _note(losses, f"{empty} faces without area")
    return _Part(vertices, corners[triangles], normals, uv)


def _columns(element: dict[str, Any], names: Iterable[str]) -> NDArray[np.float64] | None:
    """Give properties of an element as columns; None where one is missing."""
    names = tuple(names)
    if not set(names) <= set(element["properties"]):
        return None
    columns = [np.asarray(element["data"][name], np.float64) for name in names]
    table = np.column_stack(columns)
    _check_length(element, len(table))
    return table


def _lists(
    element: dict[str, Any], name: str, kind: type = np.int64
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Give a list property of an element: all its numbers, and how many each row has."""
    column = element["data"][name]
    if isinstance(element["data"], np.ndarray):
        if (column["f0"] != column["f0"][0]).any():
            raise ValueError("lists of several sizes in binary")
        column = column["f1"]
    _check_length(element, len(column))
    if column.dtype == object:
        sizes = np.array([len(row) for row in column], np.int64)
        return np.concatenate(list(column)).astype(kind), sizes
    column = column.reshape(len(column), -1)
    return column.ravel().astype(kind), np.full(len(column), column.shape[1], np.int64)


def _check_length(element: dict[str, Any], length: int) -> None:
    if length != element["length"]:
        raise ValueError(f"{element['length']} rows are announced, {length} are there")


def _note_ply(data: bytes, elements: dict[str, Any], losses: Losses) -> None:
    header = data[: data.find(b"end_header")]
    for texture in re.findall(rb"(?im)^\s*comment\s+texturefile\s+(.*?)\s*$", header):
        _note(losses, "texture", texture.decode("utf-8", "replace"))
    known = {
        "vertex": {"x", "y", "z", "nx", "ny", "nz", *_COLORS}.union(*_UV),
        "face": {*_INDICES, *_WEDGES, *_COLORS},
    }
    for name, element in elements.items():
        if name in known:
            if not {"red", "green", "blue"}.isdisjoint(element["properties"]):
                _note(losses, f"{name} colours")
            for other in element["properties"]:
                if other not in known[name]:
                    _note(losses, f"{name} property", other)
        elif element["length"]:
            _note(losses, "element", name)


# --- STL ----------------------------------------------------------------------------------


def _read_stl(path: Path, data: bytes, losses: Losses) -> list[Mesh]:
    from trimesh.exchange.stl import load_stl

    count = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + 50 * count:
        if not re.search(rb"(?i)\b(facet|endsolid)\b", data[:4096]):
            message = f"is damaged: binary of {count} triangles would have {84 + 50 * count} bytes"
            raise InputError(f"{message}, not {len(data)}; export it again", path)
        data = data.decode(errors="replace").encode()
    loaded: dict[str, Any] = load_stl(BytesIO(data))
    attributes = loaded.get("face_attributes", {}).get("stl")
    solids = loaded.get("geometry", {"": loaded})
    if attributes is None:
        _check_ascii_stl(path, data, sum(len(solid["faces"]) for solid in solids.values()))
    elif attributes.any():
        _note(losses, "colours in attribute bytes")
    names = re.findall(rb"(?im)^[ \t]*solid\b[ \t]*(.*?)\s*$", data) if attributes is None else []
    if len(names) != len(solids):
        names = [b""] * len(solids)
    default = Material("default")
    return [
        _build_mesh(
            path,
            _Part(np.asarray(solid["vertices"], np.float64), np.asarray(solid["faces"], np.int64)),
            default,
            name.decode() or path.stem,
        )
        for name, solid in zip(names, solids.values(), strict=True)
    ]


def _check_ascii_stl(path: Path, data: bytes, faces: int) -> None:
    """Refuse a text of which some facets were passed over."""
    facets = len(re.findall(rb"(?i)\bfacet\s+normal\b", data))
    vertices = len(re.findall(rb"(?i)\bvertex[ \t]+[-+.\dni]", data))
    if (facets, vertices) != (faces, 3 * faces):
        message = f"is damaged: of {facets} facets and {vertices} vertices {faces} facets are whole"
        raise InputError(f"{message}; export it again", path)


# --- glTF ---------------------------------------------------------------------------------


@dataclass
class _Gltf:
    """A glTF file, and a plain copy of it that holds geometry alone, for trimesh to decode.

    Parameters
    ----------
    path : the file
    tree : its JSON
    binary : the BIN chunk of a GLB file
    losses : what is not simulated
    """

    path: Path
    tree: dict[str, Any]
    binary: bytes | None
    losses: Losses
    plain: dict[str, list[Any]] = field(default_factory=lambda: {kind: [] for kind in _KEPT})
    data: dict[str, bytes] = field(default_factory=dict)
    places: dict[tuple[str, int], int] = field(default_factory=dict)
    materials: dict[int | None, Material] = field(default_factory=dict)

    def error(self, message: str) -> InputError:
        """Say what is wrong."""
        return InputError(message, self.path)

    def item(self, kind: str, index: int) -> dict[str, Any]:
        """Give an item of a top-level array."""
        items = self.tree.get(kind, [])
        if type(index) is not int or not 0 <= index < len(items):
            raise self.error(f"names {kind} {shown(index)}, but has {len(items)}; export it again")
        item: dict[str, Any] = items[index]
        return item

    def copy(self, kind: str, index: int) -> int:
        """Copy an item and what it refers to into the plain tree, once; give its place there."""
        if (kind, index) not in self.places:
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
            self.places[kind, index] = len(self.plain[kind])
            self.plain[kind].append(plain)
        return self.places[kind, index]

    def load(self, index: int, buffer: dict[str, Any]) -> bytes:
        """Give the bytes of a buffer."""
        uri = buffer.get("uri")
        if uri is None:
            if index or self.binary is None:
                raise self.error(f"has no data for buffer {index}; export it again")
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2], validate=True)
        return read_bytes(self.path.parent / unquote(uri))

    def material(self, index: int | None) -> Material:
        """Give the material of an index, the same one each time."""
        if index not in self.materials:
            material = Material("default")
            if index is not None:
                material = _read_material(self, index)
            self.materials[index] = material
        return self.materials[index]


def _read_gltf(path: Path, data: bytes, losses: Losses) -> list[Mesh]:
    import trimesh

    is_glb = path.suffix.lower() == ".glb"
    tree, binary = _split_glb(path, data) if is_glb else (data, None)
    gltf = _Gltf(path, json.loads(tree.decode("utf-8-sig")), binary, losses)
    _check_gltf(gltf)
    _note_gltf(gltf)
    meshes = [_plain_primitives(gltf, mesh) for mesh in gltf.tree.get("meshes", [])]
    plain = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": _roots(gltf)}],
        "nodes": [_plain_node(i, node) for i, node in enumerate(gltf.tree.get("nodes", []))],
        "meshes": [{"primitives": [plain]} for mesh in meshes for _, plain in mesh],
        **gltf.plain,
    }
    text = BytesIO(json.dumps(plain).encode())
    resolver: Any = gltf.data
    scene: Any = trimesh.load(text, file_type="gltf", resolver=resolver, process=False)
    decoded = iter(scene.geometry.values())
    parts = [
        [(_gltf_part(gltf, next(decoded), primitive), primitive) for primitive, _ in mesh]
        for mesh in meshes
    ]
    return list(_instances(gltf, scene.graph, parts))


def _split_glb(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """Give the JSON chunk of a GLB file, and its BIN chunk if there is one."""
    if data[:4] != b"glTF":
        raise InputError("is no GLB file; name a file that begins with 'glTF'", path)
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
    """Refuse other versions, what is needed but not supported, and what is no forest."""
    version = str(gltf.tree.get("asset", {}).get("version", ""))
    if not version.startswith("2."):
        raise gltf.error(f"is glTF {shown(version)}; export it as glTF 2.0")
    required = gltf.tree.get("extensionsRequired", [])
    if unknown := [name for name in required if not _HARMLESS.match(name)]:
        raise gltf.error(f"needs {listed(unknown)}, not supported; export it without")
    seen = set()
    for index in [*_children(gltf), *_roots(gltf)]:
        gltf.item("nodes", index)
        if index in seen:
            raise gltf.error(f"node {index} has two parents; export it again")
        seen.add(index)


def _children(gltf: _Gltf) -> list[int]:
    return [index for node in gltf.tree.get("nodes", []) for index in node.get("children", [])]


def _roots(gltf: _Gltf) -> list[int]:
    """Give the nodes at the top of the scene; without a scene, all that have no parent."""
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
    """Give the primitives of a mesh that have triangles, and plain copies of them.

    Attributes with an underscore are handed on by trimesh as they stand in the file.
    """
    pairs = []
    for primitive in mesh["primitives"]:
        mode, attributes = primitive.get("mode", _TRIANGLES), primitive["attributes"]
        if mode == _FAN:
            raise gltf.error("has triangle fans, which are not supported; export triangles")
        if mode not in (_TRIANGLES, _STRIP):
            _note(gltf.losses, "points and lines")
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
            _note(gltf.losses, "vertex colours")
        if primitive.get("targets"):
            _note(gltf.losses, "morph targets")
    return pairs


def _gltf_part(gltf: _Gltf, decoded: Any, primitive: dict[str, Any]) -> _Part:
    """Take what trimesh decoded; v counts upwards, as in OBJ."""

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
    return _Part(vertices, np.array(decoded.faces, np.int64).reshape(-1, 3), normals, uv)


def _instances(
    gltf: _Gltf, graph: Any, parts: list[list[tuple[_Part, dict[str, Any]]]]
) -> Iterator[Mesh]:
    """Give the meshes of each node in the scene's coordinates, under a name of its own."""
    names: set[str] = set()
    for index, node in enumerate(gltf.tree.get("nodes", [])):
        if "mesh" not in node or str(index) not in graph.nodes:
            continue
        mesh = gltf.item("meshes", node["mesh"])
        name = str(node.get("name") or mesh.get("name") or "node")
        while name in names:
            name += f"_{index}"
        names.add(name)
        matrix = graph.get(str(index))[0]
        for part, primitive in parts[node["mesh"]]:
            if len(part.faces):
                material = gltf.material(primitive.get("material"))
                yield _build_mesh(gltf.path, _transform(part, matrix), material, name)


def _transform(part: _Part, matrix: NDArray[np.float64]) -> _Part:
    """Move a part; where the matrix mirrors, faces turn, so that their front stays outside."""
    linear = matrix[:3, :3]
    mirrors = bool(np.linalg.det(linear) < 0)
    vertices = part.vertices @ linear.T + matrix[:3, 3]
    faces = part.faces[:, ::-1] if mirrors else part.faces
    normals = part.normals
    if normals is not None:
        columns = linear.T
        cofactors = np.cross(columns[[1, 2, 0]], columns[[2, 0, 1]])
        normals = normals @ (-cofactors if mirrors else cofactors)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length != 0)
    return _Part(vertices, faces, normals, part.uv)


def _read_material(gltf: _Gltf, index: int) -> Material:
    """Read a material; its reflectance is the base colour where there is no texture."""
    item = gltf.item("materials", index)
    name = str(item.get("name") or f"material_{index}")
    surface = item.get("pbrMetallicRoughness")
    _note_material(gltf.losses, name, item, surface)
    if surface is None or "baseColorTexture" in surface:
        return Material(name)
    color = surface.get("baseColorFactor", [1, 1, 1, 1])[:3]
    if len(color) < 3 or not all(
        type(value) in (int, float) and 0 <= value <= LARGEST_REFLECTANCE for value in color
    ):
        message = f"material {shown(name)}: baseColorFactor {shown(color)} is no reflectance"
        raise gltf.error(f"{message}; keep it within [0, 1]")
    red, green, blue = (min(float(value), 1.0) for value in color)
    reflectance: Color = (red, green, blue)
    return Material(name, reflectance)


def _note_material(
    losses: Losses, name: str, item: dict[str, Any], surface: dict[str, Any] | None
) -> None:
    if any(key.endswith("Texture") for key in (*item, *(surface or ()))):
        _note(losses, "textures", name)
    if surface is not None:
        if surface.get("metallicFactor", 1) != 0:
            _note(losses, "metallicFactor", name)
        if surface.get("roughnessFactor", 1) != 1:
            _note(losses, "roughnessFactor", name)
        if surface.get("baseColorFactor", [1])[-1] != 1:
            _note(losses, "alpha", name)
    if any(item.get("emissiveFactor", ())):
        _note(losses, "emissiveFactor", name)
    if item.get("alphaMode", "OPAQUE") != "OPAQUE":
        _note(losses, "alphaMode", name)
    for extension in item.get("extensions", ()):
        _note(losses, extension, name)


def _note_gltf(gltf: _Gltf) -> None:
    for kind in ("cameras", "animations", "skins"):
        if gltf.tree.get(kind):
            _note(gltf.losses, kind)
    for name in gltf.tree.get("extensions", ()):
        if name == "KHR_lights_punctual":
            _note(gltf.losses, "lights")
    for node in gltf.tree.get("nodes", []):
        for name in node.get("extensions", ()):
            if name != "KHR_lights_punctual":
                _note(gltf.losses, name)


_READERS: dict[str, Callable[[Path, bytes, Losses], list[Mesh]]] = {
    ".ply": _read_ply,
    ".stl": _read_stl,
    ".glb": _read_gltf,
    ".gltf": _read_gltf,
}
