"""Embree's C library: found in the embreex wheel, declared once, scenes built through it."""

import ctypes
import sys
import weakref
from pathlib import Path

import embreex
import llvmlite.binding
import numpy as np

TRIANGLES = 0
INDEX_BUFFER, VERTEX_BUFFER = 0, 1
FORMAT_UINT3, FORMAT_FLOAT3 = 0x5003, 0x9003
ROBUST = 4
BUILD_QUALITY_HIGH = 2


def _library_file() -> Path:
    package = Path(embreex.__file__).parent
    folders = [package.parent / "embreex.libs", package / ".dylibs", package]
    patterns = {"win32": "embree4*.dll", "darwin": "libembree4*.dylib"}
    pattern = patterns.get(sys.platform, "libembree4*.so*")
    for folder in folders:
        for file in sorted(folder.glob(pattern)):
            return file
    raise ImportError(f"no Embree 4 library in {', '.join(map(str, folders))}: reinstall embreex")


def _load() -> ctypes.CDLL:
    library = ctypes.CDLL(str(_library_file()))
    pointer, unsigned, size = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [ctypes.c_char_p]),
        ("rtcReleaseDevice", None, [pointer]),
        ("rtcGetDeviceError", ctypes.c_int, [pointer]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcReleaseScene", None, [pointer]),
        ("rtcSetSceneFlags", None, [pointer, ctypes.c_int]),
        ("rtcSetSceneBuildQuality", None, [pointer, ctypes.c_int]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
        ("rtcReleaseGeometry", None, [pointer]),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", unsigned, [pointer, pointer]),
        (
            "rtcSetSharedGeometryBuffer",
            None,
            [pointer, ctypes.c_int, unsigned, ctypes.c_int, pointer, size, size, size],
        ),
        ("rtcIntersect1", None, [pointer, pointer, pointer]),
        ("rtcOccluded1", None, [pointer, pointer, pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    for name in ("rtcIntersect1", "rtcOccluded1"):
        address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
        llvmlite.binding.add_symbol(name, address)
    return library


LIBRARY = _load()


class EmbreeScene:
    """A committed scene of triangles; `address` is what kernels cast rays into.

    Parameters
    ----------
    vertices : (V, 3) float32
    triangles : (T, 3) uint32

    Raises
    ------
    MemoryError : when Embree refuses the geometry
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        # Embree reads 16 bytes at the last vertex.
        self._vertices = np.zeros((len(vertices) + 1, 3), np.float32)
        self._vertices[:-1] = vertices
        self._triangles = np.ascontiguousarray(triangles, np.uint32)
        self._device = LIBRARY.rtcNewDevice(b"")
        self.address: int = LIBRARY.rtcNewScene(self._device)
        weakref.finalize(self, _release, self.address, self._device)
        LIBRARY.rtcSetSceneFlags(self.address, ROBUST)
        LIBRARY.rtcSetSceneBuildQuality(self.address, BUILD_QUALITY_HIGH)
        if len(triangles):
            self._attach(len(vertices))
        LIBRARY.rtcCommitScene(self.address)
        if code := LIBRARY.rtcGetDeviceError(self._device):
            raise MemoryError(f"Embree could not build the scene (error {code})")

    def _attach(self, vertex_count: int) -> None:
        geometry = LIBRARY.rtcNewGeometry(self._device, TRIANGLES)
        for kind, form, array, count in (
            (VERTEX_BUFFER, FORMAT_FLOAT3, self._vertices, vertex_count),
            (INDEX_BUFFER, FORMAT_UINT3, self._triangles, len(self._triangles)),
        ):
            LIBRARY.rtcSetSharedGeometryBuffer(
                geometry, kind, 0, form, array.ctypes.data, 0, 12, count
            )
        LIBRARY.rtcCommitGeometry(geometry)
        LIBRARY.rtcAttachGeometry(self.address, geometry)
        LIBRARY.rtcReleaseGeometry(geometry)


def _release(scene: int, device: int) -> None:
    LIBRARY.rtcReleaseScene(scene)
    LIBRARY.rtcReleaseDevice(device)
