"""Large files are read in little memory: a multiple of their own size."""

import tracemalloc

import numpy as np
import pytest
from helpers.meshes import GltfBuilder

from photonmap.io.readers.registry import read_file

MOST = 6.0
"""Bytes in use at any time, by those of the file"""


def grid(n):
    """Return a wavy surface of 2 (n - 1)² triangles: vertices, unit normals, uv and faces."""
    u, v = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0.0, 1.0, n)] * 2))
    vertices = np.stack([u, v, 0.1 * np.sin(7.0 * u)], axis=1)
    normals = np.stack([-0.7 * np.cos(7.0 * u), 0.0 * u, 0.0 * u + 1.0], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    a = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
    return vertices, normals, np.stack([u, v], axis=1), faces


def peak_of(path):
    tracemalloc.start()
    try:
        scene = read_file(path)
        return scene, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_glb(tmp_path):
    vertices, normals, uv, faces = grid(400)
    build = GltfBuilder()
    more = {"indices": build.add(faces.ravel().astype("<u4"))}
    build.primitive(POSITION=vertices, NORMAL=normals, TEXCOORD_0=uv, more=more)
    path = tmp_path / "a.glb"
    path.write_bytes(build.glb())
    scene, peak = peak_of(path)
    assert len(scene.meshes[0].faces) == len(faces)
    assert peak < MOST * path.stat().st_size


@pytest.mark.slow
@pytest.mark.parametrize("whole", [False, True], ids=["vertices", "normals and uv"])
def test_obj(tmp_path, whole):
    vertices, normals, uv, faces = grid(300)
    path = tmp_path / "a.obj"
    with path.open("w") as file:
        np.savetxt(file, vertices, "v %.6f %.6f %.6f")
        if whole:
            np.savetxt(file, normals, "vn %.4f %.4f %.4f")
            np.savetxt(file, uv, "vt %.6f %.6f")
            np.savetxt(file, np.repeat(faces + 1, 3, axis=1), "f %d/%d/%d %d/%d/%d %d/%d/%d")
        else:
            np.savetxt(file, faces + 1, "f %d %d %d")
    scene, peak = peak_of(path)
    assert len(scene.meshes[0].faces) == len(faces)
    assert peak < MOST * path.stat().st_size + (48 << 20), "blocks of 4 MB are parsed at a time"
