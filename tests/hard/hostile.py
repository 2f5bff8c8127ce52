"""Small generators of hostile files: names that command a terminal, and work beyond their size."""

import json

import numpy as np

NASTY = "a\x1b]0;owned\x07\x1b[31m\x9b2J\u202egnp\r\x7f\u2028"
"""Sets a terminal's title, rings, colours and clears, and turns the direction of writing"""
LINES = f"{NASTY}\nphotonmap: error: none"
"""Seems to be two lines"""
HIDDEN = [*map(chr, range(32)), "\x7f", "\x9b", "\u202e", "\u2028"]
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()


def gltf(name=LINES, uri=None):
    """A triangle whose names, and perhaps the name of its buffer, are hostile."""
    views = [{"buffer": 0, "byteLength": 36}]
    tree = {
        "asset": {"version": "2.0", "generator": name},
        "extensionsUsed": [name],
        "scenes": [{"nodes": [0], "name": name}],
        "nodes": [{"mesh": 0, "name": name, "extensions": {name: {}}}, {"name": name}],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": name, "alphaMode": "MASK", "extensions": {f"KHR_{name}": {}}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": views,
        "buffers": [{"byteLength": 36, "uri": uri or data_uri(TRIANGLE)}],
    }
    return json.dumps(tree).encode()


def data_uri(data):
    import base64

    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def named(name=NASTY):
    """Files whose names, as they can stand in each format, are hostile: by file name."""
    bare = name.replace("\r", "").replace("\n", " ")  # ends a line in formats of lines
    text = bare.replace("\x07", "").replace("\x1b", "").replace("\x7f", "")  # of OBJ: no controls
    quoted = json.dumps(name).replace("\\ud", "\\uD")
    url = "".join(f"%{byte:02x}" for byte in name.encode())
    obj = f"mtllib {text}\no {text}\nusemtl {text}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n{text} 1\n"
    xml = "".join(
        f"&#{ord(c)};" if c.isprintable() or c in "\x9b\u202e\x7f\u2028" else "" for c in name
    )
    return {
        "names.gltf": gltf(),
        "uri.gltf": gltf(uri=url),
        "extension.gltf": gltf().replace(b'"extensionsUsed"', b'"extensionsRequired"'),
        "names.obj": obj.encode(),
        "names.ply": (
            f"ply\nformat ascii 1.0\ncomment TextureFile {bare}\nelement vertex 3\n"
            f"property float x\nproperty float y\nproperty float z\nproperty float q{bare}\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"
        ).encode(),
        "names.stl": f"solid {bare}\nfacet normal 0 0 1\n{bare}".encode(),
        "names.off": f"OFF\n3 1 0\n{bare} 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".encode(),
        "names.xml": (
            f'<scene version="3.0.0"><shape type="rectangle" id="{xml}"><bsdf type="{xml}"/>'
            "</shape></scene>"
        ).encode(),
        "material.toml": f'mesh = "names.ply"\n[material.{quoted}]\nreflectance = 1\n'.encode(),
        "mesh.toml": f"mesh = {quoted}\n".encode(),
        "light.toml": f'mesh = "names.ply"\n[[light]]\ntype = {quoted}\n'.encode(),
    }
