"""Images on surfaces: texture coordinates, and texels looked up where they lie in memory.

Images are neither copied nor joined, so that hundreds of them fit: kernels get their addresses,
and their caller keeps the arrays alive.
"""

import ctypes
import math

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from photonmap.kernels.core.color import LUMINANCE
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.records import CLAMP_U, CLAMP_V, FLOATS, NEAREST

if config.DISABLE_JIT:

    def load_byte(address):
        """Return the byte at an address."""
        return ctypes.c_uint8.from_address(int(address)).value

    def load_real(address):
        """Return the float32 at an address."""
        return ctypes.c_float.from_address(int(address)).value

    def load_index(address):
        """Return the int32 at an address."""
        return ctypes.c_int32.from_address(int(address)).value

else:

    def _loader(kind, number):
        @intrinsic
        def load(typing, address):
            def generate(context, builder, signature, arguments):
                pointer = builder.inttoptr(arguments[0], kind.as_pointer())
                return builder.load(pointer)

            return number(types.int64), generate

        return load

    load_byte = _loader(ir.IntType(8), types.uint8)
    load_real = _loader(ir.FloatType(), types.float32)
    load_index = _loader(ir.IntType(32), types.int32)


@jit
def coordinates(uv, triangles, triangle, u, v):
    """Return the texture coordinates at barycentrics (u, v)."""
    a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
    w = 1.0 - u - v
    return (w * uv[a, 0] + u * uv[b, 0] + v * uv[c, 0], w * uv[a, 1] + u * uv[b, 1] + v * uv[c, 1])


@jit
def coordinates_at(geometry, hit):
    """Return the texture coordinates where a ray meets a surface."""
    return coordinates(geometry.uv, geometry.triangles, hit.triangle, hit.u, hit.v)


@jit
def _inside(index, size, clamp):
    """Bring the index of a row or column back into an image: to its edge, or round."""
    if clamp:
        return min(max(index, 0), size - 1)
    return index % size


@jit
def _texel(maps, image, row, column):
    """Return the linear RGB of a texel; of a single channel three times the same."""
    channels, kind = maps.shape[image, 2], maps.kind[image]
    at = (np.int64(row) * maps.shape[image, 1] + column) * channels
    far = 1 if channels == 3 else 0
    if kind == FLOATS:
        at = maps.address[image] + 4 * at
        return (
            float(load_real(at)),
            float(load_real(at + 4 * far)),
            float(load_real(at + 8 * far)),
        )
    at += maps.address[image]
    return (
        float(maps.tables[kind, load_byte(at)]),
        float(maps.tables[kind, load_byte(at + far)]),
        float(maps.tables[kind, load_byte(at + 2 * far)]),
    )


@jit
def _place(maps, image, s, t):
    """Return the rows and columns of the four texels around (s, t), and where it lies between."""
    height, width = np.int64(maps.shape[image, 0]), np.int64(maps.shape[image, 1])
    s = maps.placement[image, 0] * s + maps.placement[image, 2]
    t = maps.placement[image, 1] * t + maps.placement[image, 3]
    flags = maps.flags[image]
    along, up = flags & CLAMP_U != 0, flags & CLAMP_V != 0
    s = min(max(s, 0.0), 1.0) if along else s - math.floor(s)
    t = min(max(t, 0.0), 1.0) if up else t - math.floor(t)
    x, y = s * width - 0.5, (1.0 - t) * height - 0.5
    left, top = math.floor(x), math.floor(y)
    x, y = x - left, y - top
    if flags & NEAREST != 0:
        x, y = math.floor(x + 0.5), math.floor(y + 0.5)
    columns = _inside(np.int64(left), width, along), _inside(np.int64(left) + 1, width, along)
    rows = _inside(np.int64(top), height, up), _inside(np.int64(top) + 1, height, up)
    return rows, columns, x, y


@outlined
def look_up(maps, image, s, t):
    """Return linear RGB of row `image` at (s, t), bilinear or nearest; t rises from the bottom."""
    rows, columns, x, y = _place(maps, image, s, t)
    a, b = _texel(maps, image, rows[0], columns[0]), _texel(maps, image, rows[0], columns[1])
    c, d = _texel(maps, image, rows[1], columns[0]), _texel(maps, image, rows[1], columns[1])
    p, q, r, w = (1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y
    return (
        maps.factor[image, 0] * (p * a[0] + q * b[0] + r * c[0] + w * d[0]),
        maps.factor[image, 1] * (p * a[1] + q * b[1] + r * c[1] + w * d[1]),
        maps.factor[image, 2] * (p * a[2] + q * b[2] + r * c[2] + w * d[2]),
    )


@outlined
def look_up_indices(maps, palettes, image, s, t):
    """Return four rows of `palettes.spectra` and their weights; like `look_up` otherwise."""
    rows, columns, x, y = _place(maps, image, s, t)
    start, width = palettes.address[image], np.int64(maps.shape[image, 1])
    return (
        (
            np.int64(load_index(start + 4 * (rows[0] * width + columns[0]))),
            np.int64(load_index(start + 4 * (rows[0] * width + columns[1]))),
            np.int64(load_index(start + 4 * (rows[1] * width + columns[0]))),
            np.int64(load_index(start + 4 * (rows[1] * width + columns[1]))),
        ),
        ((1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y),
    )


@jit
def look_up_number(maps, image, s, t):
    """Return the luminance of row `image` of `maps` at texture coordinates (s, t)."""
    r, g, b = look_up(maps, image, s, t)
    # This order of operations returns a grey exactly.
    return g + LUMINANCE[0] * (r - g) + LUMINANCE[2] * (b - g)


@jit
def fraction_at(geometry, maps, image, hit):
    """Return `look_up_number` where a ray meets a surface, 1 at most."""
    s, t = coordinates_at(geometry, hit)
    return min(look_up_number(maps, image, s, t), 1.0)


@jit
def reflectance_at(maps, image, s, t):
    """Return the linear RGB of `look_up`, each 1 at most."""
    r, g, b = look_up(maps, image, s, t)
    return min(r, 1.0), min(g, 1.0), min(b, 1.0)
