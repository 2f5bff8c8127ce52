"""Three loops that cast the same rays: bare in Numba, bare in C, and with the renderer's call."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from photonmap.kernels.core.jit import kernel
from photonmap.kernels.geometry.embree import LIBRARY
from photonmap.kernels.geometry.ray import (
    GEOMETRY,
    MASK,
    MISS,
    PRIMITIVE,
    TFAR,
    WORDS,
    U,
    V,
    closest_hit,
)

Loop = Callable[[int, int, int], None]
RECORD = 4 * WORDS
INTERSECT = types.ExternalFunction("rtcIntersect1", types.void(*[types.intp] * 3))
C_SOURCE = """
typedef void (*Cast)(void *, void *, void *);
void loop(Cast cast, void *scene, char *records, long first, long last) {
    for (long i = first; i < last; i++) cast(scene, records + 96 * i, 0);
}
"""


@njit(nogil=True)
def bare_loop(scene, records, first, last):
    """Call rtcIntersect1 on records first..last and do nothing else."""
    for i in range(first, last):
        INTERSECT(scene, records + RECORD * i, 0)


@kernel
def renderer_loop(scene, rays, first, last, triangles, places):
    """Cast rays first..last of (n, 6) float32 as kernels do; store (n,) triangles, (n, 2) u, v."""
    for i in range(first, last):
        origin = (rays[i, 0], rays[i, 1], rays[i, 2])
        direction = (rays[i, 3], rays[i, 4], rays[i, 5])
        hit = closest_hit(scene, origin, direction)
        triangles[i], places[i, 0], places[i, 1] = hit.triangle, hit.u, hit.v


def make_records(rays: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return RTCRayHit records of rays, (n, 24) words aligned to 64 bytes."""
    memory = np.zeros(len(rays) * WORDS + 16, np.uint32)
    start = (-memory.ctypes.data % 64) // 4
    records = memory[start : start + len(rays) * WORDS].reshape(-1, WORDS)
    reals = records.view(np.float32)
    reals[:, 0:3], reals[:, 4:7], reals[:, TFAR] = rays[:, :3], rays[:, 3:], np.inf
    records[:, MASK] = MISS
    records[:, GEOMETRY : GEOMETRY + 3] = MISS
    return records


def c_loop(scene: int, records: NDArray[np.uint32]) -> Loop | None:
    """Return the bare loop in C, or None without a C compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder) / "loop.c", Path(folder) / "loop.so"
        source.write_text(C_SOURCE)
        command = [compiler, "-O3", "-shared", "-fPIC", str(source), "-o", str(library)]
        subprocess.run(command, check=True)
        loop = ctypes.CDLL(str(library)).loop
    pointer = ctypes.c_void_p
    loop.restype, loop.argtypes = None, [pointer] * 3 + [ctypes.c_long] * 2
    cast = ctypes.cast(LIBRARY.rtcIntersect1, pointer)
    return lambda first, last: loop(cast, scene, records.ctypes.data, first, last)


def check_same(
    records: NDArray[np.uint32], triangles: NDArray[np.int32], places: NDArray[np.float32]
) -> None:
    """Assert that a bare loop and the renderer's have the same hits, bit for bit."""
    hit = records[:, GEOMETRY] != MISS
    assert (hit == (triangles >= 0)).all()
    assert (records[hit, PRIMITIVE] == triangles[hit]).all()
    assert (records.view(np.float32)[:, [U, V]][hit] == places[hit]).all()
