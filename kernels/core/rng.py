"""Random numbers keyed by index, never by thread, and scrambled low-discrepancy points.

A stream is a 64-bit state. `stream(seed, a, b)` makes one for pass a, item b; `draw` returns the
next number in [0, 1) and the next state (SplitMix64, Steele et al. 2014). `sobol_2d` gives points
of Sobol's (0, 2)-sequence, shuffled and Owen-scrambled by hashing (Burley 2020): any aligned
block of 2^k indices is stratified, and different scrambles are independent. Russian roulette is
played with streams.
"""

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
MIX_2 = np.uint64(0x94D049BB133111EB)
LOW_32 = np.uint64(0xFFFFFFFF)
S11, S27, S30, S31, S32 = (np.uint64(s) for s in (11, 27, 30, 31, 32))
INV_2_53 = 1.0 / (1 << 53)
INV_2_32 = 1.0 / (1 << 32)


@jit
def mix(x):
    """Scramble 64 bits so that each depends on all (SplitMix64's finaliser)."""
    x = (x ^ (x >> S30)) * MIX_1
    x = (x ^ (x >> S27)) * MIX_2
    return x ^ (x >> S31)


@jit
def stream(seed, a, b):
    """Return the state of an independent stream for the integers (seed, a, b)."""
    state = mix(np.uint64(seed) + GOLDEN)
    state = mix((state ^ np.uint64(a)) + GOLDEN)
    return mix((state ^ np.uint64(b)) + GOLDEN)


@jit
def draw(state):
    """Return a uniform number in [0, 1) and the stream's next state."""
    state = state + GOLDEN
    return float(mix(state) >> S11) * INV_2_53, state


@jit
def draw_three(state):
    """Return three uniform numbers in [0, 1) and the stream's next state."""
    x, state = draw(state)
    y, state = draw(state)
    z, state = draw(state)
    return (x, y, z), state


if config.DISABLE_JIT:

    def reverse_bits(x):
        """Reverse the lowest 32 bits."""
        return np.uint64(int(f"{int(x) & 0xFFFFFFFF:032b}"[::-1], 2))

else:

    @intrinsic
    def _bitreverse(typing, x):
        def generate(context, builder, signature, arguments):
            return builder.bitreverse(arguments[0])

        return types.uint32(types.uint32), generate

    @jit
    def reverse_bits(x):
        """Reverse the lowest 32 bits."""
        return np.uint64(_bitreverse(np.uint32(x)))


@jit
def _permute(x, key):
    """Permute the lowest 32 bits so that each depends on itself and the lower ones."""
    # Laine and Karras 2011, with the constants of Vegdahl 2021. Bits above are left to be dropped.
    x = x ^ (x * np.uint64(0x3D20ADEA))
    x = x + key
    x = x * ((key >> np.uint64(16)) | np.uint64(1))
    x = x ^ (x * np.uint64(0x05526C56))
    return x ^ (x * np.uint64(0x53A22864))


@jit
def _sobol_second(index):
    """Return the second Sobol coordinate of a 32-bit index, as 32 bits, lowest first."""
    # Its generator matrix is Pascal's triangle modulo 2, which factors by bits of the position.
    x = index ^ ((index & np.uint64(0xAAAAAAAA)) >> np.uint64(1))
    x = x ^ ((x & np.uint64(0xCCCCCCCC)) >> np.uint64(2))
    x = x ^ ((x & np.uint64(0xF0F0F0F0)) >> np.uint64(4))
    x = x ^ ((x & np.uint64(0xFF00FF00)) >> np.uint64(8))
    return x ^ ((x & np.uint64(0xFFFF0000)) >> np.uint64(16))


@jit
def block_key(index, key):
    """Return the key of the block of 2^32 indices that holds an index: its own scramble."""
    return key ^ mix(np.uint64(index) >> S32)


@jit
def sobol_point(index, key):
    """Return point `index` modulo 2^32 of the sequence scrambled by the 64-bit `key`."""
    shuffled = reverse_bits(_permute(reverse_bits(np.uint64(index)), key & LOW_32))
    key = mix(key + GOLDEN)
    x = reverse_bits(_permute(shuffled, key & LOW_32))
    y = reverse_bits(_permute(_sobol_second(shuffled), key >> S32))
    return float(x) * INV_2_32, float(y) * INV_2_32


@jit
def sobol_2d(index, key):
    """Return point `index`, of 64 bits, of the sequences scrambled by the 64-bit `key`.

    Each 2^32 points are one sequence; the next ones are of another scramble.
    """
    return sobol_point(index, block_key(index, key))


@jit
def sobol_block(first, key, points):
    """Fill points, (2, n), with those from index `first` on, of its block of 2^32.

    Each instruction of the processor works on several, in a tenth of the time: as long as the
    compiler does not know n, and unrolls the loop instead.
    """
    key = block_key(first, key)
    for lane in range(points.shape[1]):
        points[0, lane], points[1, lane] = sobol_point(first + np.uint64(lane), key)


@jit
def russian_roulette(before, after, state, throughput):
    """End a path with the probability of what it lost, and divide what goes on by its own.

    `before` and `after` are the largest values over bands of `throughput`, (N,), before some loss
    and now. Returns (whether the path goes on, random state).
    """
    if after <= 0.0:
        return False, state
    if after >= before:
        return True, state
    xi, state = draw(state)
    if xi * before >= after:
        return False, state
    divide(throughput, after / before)
    return True, state
