"""Small generators of hostile files: names that command a terminal, and work beyond their size."""

import base64
import io
import json
import struct
import zipfile
import zlib

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


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
SCENE = 'mesh = "a.obj"\n'
PLY = "ply\nformat {} 1.0\n{}end_header\n"
VERTEX = "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face {}\nproperty list uchar int vertex_indices\n"
FACET = (
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
)


def repeated(text, count):
    """A text count times, with {} as the number of each."""
    return "".join(text.format(i) for i in range(count))


def lit(obj, more=""):
    return {"a.obj": obj, "a.toml": SCENE + more}


def shared_primitives(count):
    """Primitives of one triangle each that share the vertices of all."""
    data = np.arange(9 * count, dtype="<f4").tobytes() + np.arange(3 * count, dtype="<u4").tobytes()
    of_vertices = {"bufferView": 0, "componentType": 5126, "count": 3 * count, "type": "VEC3"}
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1 + number} for number in range(count)]
    accessors = [
        {"bufferView": 1, "byteOffset": 12 * i, "componentType": 5125, "count": 3, "type": "SCALAR"}
        for i in range(count)
    ]
    return tree(data, [of_vertices, *accessors], primitives, [{"mesh": 0}], 36 * count)


def nodes(count):
    """Nodes that show one triangle."""
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    return tree(TRIANGLE, [accessor], [{"attributes": {"POSITION": 0}}], [{"mesh": 0}] * count, 36)


def same_file(count):
    """Buffers that are all of one file, and sparse accessors without data of their own."""
    accessors = [
        {"componentType": 5126, "count": 3, "type": "VEC3",
         "sparse": {"count": 3, "indices": {"bufferView": i, "componentType": 5125},
                    "values": {"bufferView": i, "byteOffset": 12}}}
        for i in range(count)
    ]  # fmt: skip
    primitives = [{"attributes": {"POSITION": i}} for i in range(count)]
    files = tree(b"", accessors, primitives, [{"mesh": 0}], 0)
    described = json.loads(files["a.gltf"])
    described["buffers"] = [{"uri": "a.bin", "byteLength": 48}] * count
    described["bufferViews"] = [{"buffer": i, "byteLength": 48} for i in range(count)]
    data = np.arange(3, dtype="<u4").tobytes() + TRIANGLE + bytes(64 * count)
    return {"a.gltf": json.dumps(described), "a.bin": data}


def tree(data, accessors, primitives, nodes, cut):
    """A glTF file whose buffer has two views, cut after so many bytes."""
    return {
        "a.gltf": json.dumps(
            {
                "asset": {"version": "2.0"},
                "scenes": [{"nodes": list(range(len(nodes)))}],
                "nodes": nodes,
                "meshes": [{"primitives": primitives}],
                "accessors": accessors,
                "bufferViews": [
                    {"buffer": 0, "byteLength": cut},
                    {"buffer": 0, "byteOffset": cut, "byteLength": len(data) - cut},
                ],
                "buffers": [{"byteLength": len(data), "uri": data_uri(data)}],
            }
        )
    }


def ply(kind, count):
    """Quads and triangles in turn, in text or binary, or with as many properties as faces."""
    square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
    head, corners = VERTEX.format(4) + FACE.format(2 * count), b"\x03" + struct.pack("<3i", 0, 1, 2)
    if kind == "ascii":
        body = (square + "3 0 1 2\n4 0 1 2 3\n" * count).encode()
    elif kind == "properties":
        head = VERTEX.format(4) + repeated("property float p{}\n", count) + FACE.format(2)
        row = b" 0" * count + b"\n"
        body = row.join(f"{each}".encode() for each in [*square.splitlines(), ""])
        return {"a.ply": PLY.format("ascii", head).encode() + body + b"3 0 1 2\n" * 2}
    else:
        points = np.array([float(word) for word in square.split()], "<f4").tobytes()
        body = points + (corners + b"\x04" + struct.pack("<4i", 0, 1, 2, 3)) * count
    return {"a.ply": PLY.format(kind, head).encode() + body}


GROWING = {
    "OBJ: materials that no file has": lambda n: {
        "a.obj": SQUARE + repeated("usemtl m{}\nf 1 2 3\n", n)
    },
    "OBJ: files of materials that are not there": lambda n: {
        "a.obj": SQUARE + repeated("mtllib {}.mtl\n", n) + "f 1 2 3\n"
    },
    "OBJ: objects of the last vertex": lambda n: {
        "a.obj": SQUARE + repeated("v 0 0 {}\n", n) + repeated("o a{}\nf 1 2 -1\n", n)
    },
    "OBJ: smoothing groups": lambda n: {"a.obj": SQUARE + repeated("s {}\nf 1 2 3 4\n", n)},
    "OBJ: keywords": lambda n: {"a.obj": SQUARE + repeated("x{} 1\n", n) + "f 1 2 3\n"},
    "MTL: colours of spectra": lambda n: {
        "a.obj": "mtllib a.mtl\n" + SQUARE + "usemtl m0\nf 1 2 3\n",
        "a.mtl": "newmtl m0\n" + "Kd xyz .1 .1 .1\n" * n,
    },
    "MTL: materials": lambda n: {
        "a.obj": "mtllib a.mtl\n" + SQUARE + repeated("usemtl m{}\nf 1 2 3\n", n),
        "a.mtl": repeated("newmtl m{}\nPs 1\nfoo 1\n", n),
    },
    "TOML: lights": lambda n: lit(
        SQUARE + "f 1 2 3\n",
        repeated('[[light]]\ntype = "point"\nname = "l{}"\nposition = [0, 0, 1]\n', n),
    ),
    "TOML: cameras": lambda n: lit(
        SQUARE + "f 1 2 3\n",
        repeated('[[camera]]\nname = "c{}"\norigin = [0, 0, 1]\ntarget = [0, 0, 0]\n', n),
    ),
    "TOML: materials": lambda n: lit(
        SQUARE + repeated("usemtl m{}\nf 1 2 3\n", n),
        repeated("[material.m{}]\nreflectance = 0.1\nglossy_edge = 0.5\n", n),
    ),
    "TOML: parts of a key": lambda n: lit(SQUARE, "a." * n + "a = 1\n"),
    "TOML: sections": lambda n: lit(SQUARE, repeated("[a{}]\n", n) + "[a0]\n"),
    "TOML: comments": lambda n: lit(SQUARE, "material = 1 # " + "material = " * n),
    "glTF: primitives that share vertices": shared_primitives,
    "glTF: nodes": nodes,
    "glTF: buffers of one file": same_file,
    "PLY: text": lambda n: ply("ascii", n),
    "PLY: binary": lambda n: ply("binary_little_endian", n),
    "PLY: properties": lambda n: ply("properties", n),
    "OFF: faces": lambda n: {"a.off": f"OFF\n3 {n} 0\n0 0 0\n1 0 0\n0 1 0\n" + "3 0 1 2\n" * n},
    "OFF: blank lines": lambda n: {
        "a.off": "OFF\n" + "\n" * n + "3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"
    },
    "STL: solids": lambda n: {"a.stl": repeated("solid a{}\n" + FACET + "endsolid\n", n)},
    "XML: shapes": lambda n: {
        "a.xml": '<scene version="3.0.0">' + '<shape type="rectangle"/>' * n + "</scene>"
    },
    "XML: parameters": lambda n: {
        "a.xml": '<scene version="3.0.0">'
        + repeated('<default name="p{}" value="1"/>', n)
        + '<shape type="rectangle"/></scene>'
    },
}
"""Files that grow with a number: their contents by name, the scene first"""


def write(folder, files):
    """Write files, some as text; return the scene: the TOML file, or else the first."""
    for name, data in files.items():
        (folder / name).write_bytes(
            data if isinstance(data, bytes) else data.encode("utf-8", "replace")
        )
    return folder / ("a.toml" if "a.toml" in files else next(iter(files)))


def instances(count, prims=0):
    """A USD stage with copies of a cube, and spheres of their own: few bytes each."""
    places = ", ".join(["(0, 0, 0)"] * count)
    text = f"""#usda 1.0
def PointInstancer "a" {{
    int[] protoIndices = [{", ".join("0" * count)}]
    point3f[] positions = [{places}]
    rel prototypes = </a/b>
    def Cube "b" {{}}
}}
"""
    return {"a.usda": text + repeated('def Sphere "s{}" {{}}\n', prims)}


def nothing(rows=300_000_000):
    """A PLY file that announces rows of an element without properties."""
    head = VERTEX.format(3) + FACE.format(1) + f"element nothing {rows}\n"
    return {"a.ply": PLY.format("ascii", head) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}


def npz(arrays, heads=()):
    """An NPZ file with arrays, and with others that only announce their shape."""
    packed = io.BytesIO()
    np.savez_compressed(packed, **arrays)
    with zipfile.ZipFile(packed, "a") as archive:
        for name, shape in dict(heads).items():
            head = io.BytesIO()
            described = {"descr": "<f8", "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(head, described)
            archive.writestr(f"{name}.npy", head.getvalue())
    return packed.getvalue()


def png(width, height, texels=b""):
    """A PNG image in RGB whose checksums are right, whatever it says."""
    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", texels or zlib.compress(b"")), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
