"""The keys of all random streams: one name for each use of random numbers.

A key made here from another key and a name is unique: `split(key, NAME)` for a stream of a whole
kernel, `stream(split(key, NAME), a, b)` for one of an item in it.
"""

from enum import IntEnum, auto

from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.rng import stream


class Domain(IntEnum):
    """What a family of streams is for; the host makes one key for each, and for each pass."""

    PREPASS = 0
    PHOTONS = auto()
    CAMERA = auto()
    LIGHT_VISIBILITY = auto()
    CAUSTIC_PILOT = auto()
    CAUSTICS = auto()
    PHOTON_HITS = auto()
    TRUNCATION = auto()
    LIT_SIDES = auto()
    EXPOSURE = auto()
    CAUSTIC_CHECK = auto()
    LINGERING = auto()
    WAVELENGTHS = auto()
    SEEN_AFAR = auto()
    SEEN_AFAR_AGAIN = auto()


(
    FILM, LIGHT, GATHER, PATH, GATHER_CHAIN, CHAIN_WALK, CHAIN_LIGHT, CHAIN_GATHER, CHAIN_PATH,
    CHAIN_GATHER_CHAIN, EMIT_POSITION, EMIT_DIRECTION, SURVIVAL, BOUNCE, LOBE, VIEW_POINT,
    VIEW_PATH, EXPOSURE_POINT, EXPOSURE_RAY, EXPOSURE_COUNT, GLOSSY_PATH, CHAIN_GLOSSY_PATH, LENS,
    CHAIN_LOBE, CHAIN_FACET, CHAIN_ROUGH_LIGHT, CHAIN_ROUGH, CHAIN_REFLECTED, DISK,
) = range(1, 30)  # fmt: skip
"""Uses of random numbers within a kernel; no two of them are the same number."""


@jit
def split(key, use):
    """Return the key of one use of random numbers below a kernel's key."""
    return stream(key, use, 0)
