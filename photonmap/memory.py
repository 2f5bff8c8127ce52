"""Estimate the memory of a render before it starts, and refuse one that cannot fit."""

import psutil

from photonmap.accumulate import BYTES_PER_VALUE
from photonmap.errors import InputError
from photonmap.passes import CELLS_PER_PHOTON, bundle_count

BUFFERS = 13
"""Float32 buffers of N bands in a result: six, their errors, and a covariance."""
PASS_BUFFERS = 7
SMOOTH_BYTES_PER_VALUE = 60
"""Moments, passes and buffers of caustics and of what mirrors and glass show."""
BYTES_PER_PIXEL = 128
BYTES_PER_TRIANGLE = 300
"""Arrays, Embree's tree, and what its construction needs for a moment."""
BASE = 250e6


def estimate_memory(
    pixels: int, bands: int, photons: int, triangles: int, smooth: bool = False
) -> float:
    """Return the bytes that a render needs at its peak, the interpreter included.

    `bands` counts those of the whole and of each group of lights that is split off; `smooth` tells
    of mirrors or glass.
    """
    each = BYTES_PER_VALUE + 4 * max(PASS_BUFFERS, BUFFERS) + SMOOTH_BYTES_PER_VALUE * smooth
    values = pixels * bands * each
    cells = 2.0 * photons * CELLS_PER_PHOTON * bands * 4 * (bundle_count(photons) + 2)
    return BASE + values + cells + BYTES_PER_PIXEL * pixels + BYTES_PER_TRIANGLE * triangles


def free_memory() -> int:
    """Return the bytes that this process may still take: of the machine, and of its own limit."""
    free = int(psutil.virtual_memory().available)
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return free
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return free
    return min(free, max(limit - int(psutil.Process().memory_info().vms), 0))


def check_memory(
    pixels: int, bands: int, photons: int, triangles: int, smooth: bool = False
) -> None:
    """Raise InputError, with the numbers, where a render needs more than is free."""
    need = estimate_memory(pixels, bands, photons, triangles, smooth)
    free = free_memory()
    if need > free:
        raise InputError(
            f"this render needs about {need / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
            f"take a smaller size, fewer bands or fewer photons"
        )
