"""Meshes of files: what they enclose, and files written by hand."""

import base64
import json
import struct

import numpy as np

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")


def corners(mesh):
    """Corner positions of a mesh, (F, 3, 3)."""
    return mesh.vertices[mesh.faces]


def areas(mesh):
    """Vector areas of triangles, (F, 3)."""
    a, b, c = corners(mesh).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def volume(mesh):
    """Enclosed volume: positive where faces look outwards."""
    return np.linalg.det(corners(mesh)).sum() / 6


def ply(vertices, faces, properties="x y z", kind="ascii", lists="", more=""):
    """Write a PLY file by hand."""
    vertices = np.asarray(vertices, "<f4")
    head = f"ply\nformat {kind} 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property float {name}\n" for name in properties.split())
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{lists}{more}"
    head += "end_header\n"
    if kind == "ascii":
        rows = [" ".join(map(repr, row)) for row in vertices.tolist()]
        rows += [f"{len(face)} {' '.join(map(str, face))}" if face else "0" for face in faces]
        return "\n".join([head + rows[0], *rows[1:], ""]) if rows else head
    order = ">" if "big" in kind else "<"
    body = vertices.astype(f"{order}f4").tobytes()
    for face in faces:
        body += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return head.encode() + body


def facets(name, z=0):
    """One facet in ASCII."""
    rows = "".join(f"      vertex {x} {y} {z}\n" for x, y in ((0, 0), (1, 0), (0, 1)))
    text = f"  facet normal 0 0 1\n    outer loop\n{rows}    endloop\n  endfacet\n"
    return f"solid {name}\n{text}endsolid {name}\n"


class GltfBuilder:
    """A glTF file by hand."""

    def __init__(self):
        self.blob = b""
        self.tree = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "part"}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
        }

    def add(self, rows, **more):
        """Append an accessor."""
        rows = np.asarray(rows)
        rows = rows.astype("<f4") if rows.dtype == np.float64 else rows
        kinds = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": rows.nbytes}
        self.blob += rows.tobytes() + b"\0" * (-rows.nbytes % 4)
        self.tree["bufferViews"].append(view)
        shape = "SCALAR" if rows.ndim == 1 else f"VEC{rows.shape[1]}"
        accessor = {"bufferView": len(self.tree["accessors"]), "count": len(rows), "type": shape}
        accessor["componentType"] = kinds[rows.dtype.str[1:]]
        self.tree["accessors"].append(accessor | more)
        return len(self.tree["accessors"]) - 1

    def primitive(self, mesh=0, indices=None, more=(), **attributes):
        """Append a primitive to a mesh; attributes are rows, or accessors."""
        item = {
            "attributes": {
                name: rows if isinstance(rows, int) else self.add(rows)
                for name, rows in ({"POSITION": TRIANGLE} | attributes).items()
            }
        } | dict(more)
        if indices is not None:
            item["indices"] = self.add(np.asarray(indices, "<u2"))
        self.tree["meshes"][mesh]["primitives"].append(item)
        return self

    def gltf(self, uri=None):
        """Return the JSON; the buffer is in it, or in a file."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        tree = {**self.tree, "buffers": [{"uri": uri, "byteLength": len(self.blob)}]}
        return json.dumps(tree).encode()

    def glb(self):
        """Return the binary form."""
        tree = json.dumps({**self.tree, "buffers": [{"byteLength": len(self.blob)}]}).encode()
        tree += b" " * (-len(tree) % 4)
        chunks = struct.pack("<I4s", len(tree), b"JSON") + tree
        chunks += struct.pack("<I4s", len(self.blob), b"BIN\0") + self.blob
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
