"""Rays cast into an Embree scene from nopython code.

`closest_hit` and `any_hit` call rtcIntersect1 and rtcOccluded1 with a record on the stack. With
the JIT switched off they call the same library through ctypes.
"""

import ctypes

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import Hit
from photonmap.kernels.geometry.embree import LIBRARY

# RTCRayHit as 24 words of 32 bits: origin 0-2, tnear 3, direction 4-6, time 7, tfar 8, mask 9,
# id 10, flags 11, normal 12-14, u 15, v 16, primitive 17, geometry 18, instance 19-20, padding.
TFAR, MASK, U, V, PRIMITIVE, GEOMETRY = 8, 9, 15, 16, 17, 18
WORDS = 24
MISS = 0xFFFFFFFF


def _emit_record(builder, words):
    """Emit code that fills a fresh RTCRayHit from `words`, (ox, oy, oz, dx, dy, dz, tfar)."""
    # Four words at a time, as Embree loads them: loads cannot be served from narrower stores.
    word, real = ir.IntType(32), ir.FloatType()
    record = cgutils.alloca_once(builder, ir.ArrayType(word, WORDS))
    # Embree asks for 16-byte alignment.
    record.align = 16

    def store(first, kind, values):
        four = ir.Constant(ir.VectorType(kind, 4), ir.Undefined)
        for index, value in enumerate(values):
            four = builder.insert_element(four, value, word(index))
        pointer = builder.gep(record, [word(0), word(first)])
        builder.store(four, builder.bitcast(pointer, four.type.as_pointer()), align=16)

    ox, oy, oz, dx, dy, dz, tfar = words
    store(0, real, (ox, oy, oz, real(0.0)))
    store(4, real, (dx, dy, dz, real(0.0)))
    store(TFAR, word, (builder.bitcast(tfar, word), word(MISS), word(0), word(0)))
    store(V, word, (word(0), word(MISS), word(MISS), word(MISS)))
    return record


def _emit_call(builder, name, scene, record):
    byte_pointer = ir.IntType(8).as_pointer()
    signature = ir.FunctionType(ir.VoidType(), [byte_pointer] * 3)
    function = cgutils.get_or_insert_function(builder.module, signature, name)
    builder.call(
        function,
        [
            builder.inttoptr(scene, byte_pointer),
            builder.bitcast(record, byte_pointer),
            ir.Constant(byte_pointer, None),
        ],
    )


def _emit_load(builder, record, field, kind):
    word = ir.IntType(32)
    value = builder.load(builder.gep(record, [word(0), word(field)]))
    return builder.bitcast(value, ir.FloatType()) if kind == types.float32 else value


if config.DISABLE_JIT:

    def _record(origin, direction, tfar):
        words = np.zeros(WORDS + 4, np.uint32)
        words = words[(-words.ctypes.data // 4) % 4 :][:WORDS]
        words.view(np.float32)[[0, 1, 2, 4, 5, 6, TFAR]] = (*origin, *direction, tfar)
        words[[MASK, GEOMETRY]] = MISS
        return words

    def _intersect(scene, *ray):
        words = _record(*ray)
        LIBRARY.rtcIntersect1(scene, ctypes.c_void_p(words.ctypes.data), None)
        reals = words.view(np.float32)
        return reals[TFAR], reals[U], reals[V], words[GEOMETRY], words[PRIMITIVE]

    def _occluded(scene, *ray):
        words = _record(*ray)
        LIBRARY.rtcOccluded1(scene, ctypes.c_void_p(words.ctypes.data), None)
        return words.view(np.float32)[TFAR]

else:
    VECTOR = types.UniTuple(types.float32, 3)
    RAY = (types.int64, VECTOR, VECTOR, types.float32)

    def _words(context, builder, arguments):
        """Return scene, and the seven numbers of a ray, from (scene, origin, direction, tfar)."""
        scene, origin, direction, tfar = arguments
        parts = [cgutils.unpack_tuple(builder, part, 3) for part in (origin, direction)]
        return scene, [*parts[0], *parts[1], tfar]

    @intrinsic
    def _intersect(typing, scene, origin, direction, tfar):
        kinds = (types.float32, types.float32, types.float32, types.uint32, types.uint32)

        def generate(context, builder, signature, arguments):
            scene, words = _words(context, builder, arguments)
            record = _emit_record(builder, words)
            _emit_call(builder, "rtcIntersect1", scene, record)
            fields = (TFAR, U, V, GEOMETRY, PRIMITIVE)
            values = [
                _emit_load(builder, record, *pair) for pair in zip(fields, kinds, strict=True)
            ]
            return context.make_tuple(builder, signature.return_type, values)

        return types.Tuple(kinds)(*RAY), generate

    @intrinsic
    def _occluded(typing, scene, origin, direction, tfar):
        def generate(context, builder, signature, arguments):
            scene, words = _words(context, builder, arguments)
            record = _emit_record(builder, words)
            _emit_call(builder, "rtcOccluded1", scene, record)
            return _emit_load(builder, record, TFAR, types.float32)

        return types.float32(*RAY), generate


@jit
def _single(vector):
    """Round a vector to float32, as Embree takes it."""
    return np.float32(vector[0]), np.float32(vector[1]), np.float32(vector[2])


@jit
def closest_hit(scene, origin, direction):
    """Return the closest `Hit` of a ray; its triangle is -1 where it misses."""
    t, u, v, geometry, primitive = _intersect(
        scene, _single(origin), _single(direction), np.float32(np.inf)
    )
    triangle = np.int64(primitive) if geometry != MISS else np.int64(-1)
    return Hit(triangle, np.float64(u), np.float64(v), np.float64(t))


@jit
def any_hit(scene, origin, direction, length):
    """Return whether anything lies within origin + t direction, 0 < t < length."""
    return _occluded(scene, _single(origin), _single(direction), np.float32(length)) < 0.0


@kernel
def first_hits(scene, origins, directions, triangles, distances):
    """Write the triangle that each ray hits first, -1 for none, and the distance to it."""
    for i in range(len(origins)):
        o, d = origins[i], directions[i]
        hit = closest_hit(scene, (o[0], o[1], o[2]), (d[0], d[1], d[2]))
        triangles[i] = hit.triangle
        distances[i] = hit.distance


@kernel
def find_clear(scene, starts, ends, clear):
    """Write whether nothing lies between starts (P, 3) and ends (M, 3), as (P, M)."""
    for i in range(len(starts)):
        s = starts[i]
        origin = (s[0], s[1], s[2])
        for k in range(len(ends)):
            e = ends[k]
            way = (e[0] - s[0], e[1] - s[1], e[2] - s[2])
            clear[i, k] = not any_hit(scene, origin, way, 0.999)
