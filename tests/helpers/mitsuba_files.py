"""Files that the scenes of the comparison name."""

import struct
import zlib

import numpy as np
import trimesh

from photonmap.scene.images import write_image


def write_files(folder):
    """Write meshes, an image and an environment map."""
    body = trimesh.creation.icosphere(subdivisions=2)
    body.vertices *= [1.0, 0.8, 0.9]
    uv = 0.4 * body.vertices[:, :2] + 0.5
    _write_obj(folder / "body.obj", body, uv)
    _write_ply(folder / "body.ply", body, uv)
    cube = trimesh.creation.box((1, 1, 1))
    _write_serialized(folder / "body.serialized", [(cube, None), (body, uv)])
    rng = np.random.default_rng(3)
    blocks = np.kron(rng.random((8, 16, 3)) ** 2, np.ones((32, 32, 1)))
    write_image(blocks.astype(np.float32), folder / "sky.exr")
    pattern = np.kron(rng.random((4, 6, 3)), np.ones((16, 16, 1)))
    _write_png(folder / "paint.png", (255 * pattern).astype(np.uint8))
    _write_png(folder / "small.png", (255 * pattern[::16, ::16]).astype(np.uint8))
    (folder / "plate.obj").write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n")


def _write_obj(path, body, uv):
    lines = [f"v {x} {y} {z}" for x, y, z in body.vertices]
    lines += [f"vt {u} {v}" for u, v in uv]
    lines += ["f " + " ".join(f"{i}/{i}" for i in face) for face in body.faces + 1]
    path.write_text("mtllib missing.mtl\n" + "\n".join(lines) + "\n")


def _write_ply(path, body, uv):
    """Write vertices with normals and texture coordinates."""
    names = ("x", "y", "z", "nx", "ny", "nz", "u", "v")
    rows = np.column_stack([body.vertices, body.vertex_normals, uv])
    path.write_text(
        f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n"
        + "".join(f"property float {name}\n" for name in names)
        + f"element face {len(body.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        + "".join(" ".join(map(str, row)) + "\n" for row in rows.tolist())
        + "".join("3 {} {} {}\n".format(*face) for face in body.faces)
    )


def _write_serialized(path, meshes):
    path.write_bytes(serialized(meshes))


def serialized(meshes, version=4, double=False):
    """Return a file of Mitsuba's binary format; uv are None or one for each vertex."""
    real = "<f8" if double else "<f4"
    data, starts = b"", []
    for body, uv in meshes:
        starts.append(len(data))
        flags = (0x2000 if double else 0x1000) | (0 if uv is None else 2)
        packed = struct.pack("<I", flags) + (b"body\0" if version == 4 else b"")
        packed += struct.pack("<QQ", len(body.vertices), len(body.faces))
        packed += body.vertices.astype(real).tobytes()
        packed += b"" if uv is None else uv.astype(real).tobytes()
        packed += body.faces.astype("<u4").tobytes()
        data += struct.pack("<HH", 0x041C, version) + zlib.compress(packed)
    kind = "Q" if version == 4 else "I"
    return data + struct.pack(f"<{len(starts)}{kind}I", *starts, len(starts))


def _write_png(path, pixels):
    import OpenImageIO

    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], 3, "uint8")
    file = OpenImageIO.ImageOutput.create(str(path))
    file.open(str(path), spec)
    file.write_image(pixels)
    file.close()
