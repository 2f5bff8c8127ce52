"""Estimate the memory of a render before it starts, and refuse one that cannot fit."""

import psutil

from photonmap.accumulate import BYTES_PER_VALUE
from photonmap.errors import InputError
from photonmap.passes import CELLS_PER_PHOTON, bundle_count

BUFFERS = 12
"""Float32 buffers of N bands in a result: six, and their errors."""
PASS_BUFFERS = 7
BYTES_PER_PIXEL = 120
BYTES_PER_TRIANGLE = 300
"""Arrays, Embree's tree, and what its construction needs for a moment."""
BASE = 250e6


def estimate_memory(pixels: int, bands: int, photons: int, triangles: int) -> float:
    """Return the bytes that a render needs at its peak, the interpreter included."""
    values = pixels * bands * (BYTES_PER_VALUE + 4 * max(PASS_BUFFERS, BUFFERS))
    cells = 2.0 * photons * CELLS_PER_PHOTON * bands * 4 * (bundle_count(photons) + 2)
    return BASE + values + cells + BYTES_PER_PIXEL * pixels + BYTES_PER_TRIANGLE * triangles


def check_memory(pixels: int, bands: int, photons: int, triangles: int) -> None:
    """Raise InputError, with the numbers, where a render needs more than is free."""
    need = estimate_memory(pixels, bands, photons, triangles)
    free = psutil.virtual_memory().available
    if need > free:
        raise InputError(
            f"this render needs about {need / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
            f"take a smaller size, fewer bands or fewer photons"
        )
