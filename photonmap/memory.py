"""Estimate the memory of a render before it starts; refuse what cannot fit, or use the disk."""

from __future__ import annotations

import shutil
from collections.abc import Collection
from dataclasses import dataclass

import psutil

from photonmap.accumulate import BYTES_PER_VALUE
from photonmap.errors import InputError
from photonmap.output import BANDED, OF_SMOOTH
from photonmap.passes import CELLS_PER_PHOTON, bundle_count
from photonmap.storage import RAM, Storage, is_in_ram, scratch_folder

PASS_BUFFERS = 7
SMOOTH_BYTES_PER_VALUE = 44
"""Moments and passes of caustics and of what mirrors and glass show."""
BYTES_PER_PIXEL = 128
BYTES_PER_TRIANGLE = 300
"""Arrays, Embree's tree, and what its construction needs for a moment."""
BASE = 250e6
PASSING_BYTES_PER_PIXEL = 32
"""What stays in RAM of an image whose arrays are on disk, for moments: luminances, masks."""
PASSING_BYTES_PER_SPLIT_VALUE = 32
"""The same of each value of a pass that is split by groups of lights."""
PASSING_BYTES_PER_CAUSTIC = 3 * 40
"""The same of caustic photons, one a pixel, while they are sorted."""


@dataclass(frozen=True)
class Work:
    """What decides how much memory a render needs.

    Parameters
    ----------
    pixels, photons, triangles : their numbers
    bands : those of the whole, and of each group of lights that is split off
    smooth : there are mirrors or glass
    split : light is split by groups of lights
    buffers : names of those that are kept
    """

    pixels: int
    bands: int
    photons: int
    triangles: int
    smooth: bool = False
    split: bool = False
    buffers: Collection[str] = BANDED

    @property
    def images(self) -> int:
        """How many images with bands are kept: buffers, and errors of most."""
        absent = () if self.smooth else OF_SMOOTH
        names = [name for name in BANDED if name in self.buffers and name not in absent]
        return 2 * len(names) - ("covariance" in names)

    @property
    def always(self) -> float:
        """Bytes of the interpreter, the scene and all that is never on disk."""
        passing = PASSING_BYTES_PER_PIXEL + PASSING_BYTES_PER_CAUSTIC * self.smooth
        passing += PASSING_BYTES_PER_SPLIT_VALUE * self.bands * self.split
        return BASE + BYTES_PER_TRIANGLE * self.triangles + passing * self.pixels

    @property
    def arrays(self) -> float:
        """Bytes of the arrays that may be on disk."""
        each = BYTES_PER_VALUE + 4 * (PASS_BUFFERS + self.images)
        each += SMOOTH_BYTES_PER_VALUE * self.smooth
        cells = 2.0 * self.photons * CELLS_PER_PHOTON
        stores = cells * self.bands * 4 * (bundle_count(self.photons) + 2)
        return self.pixels * (self.bands * each + BYTES_PER_PIXEL) + stores


def free_memory() -> int:
    """Return the bytes that this process may still take: of the machine, and of its own limits."""
    free = int(psutil.virtual_memory().available)
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return free
    memory = psutil.Process().memory_info()
    private = getattr(memory, "data", memory.rss)
    for kind, taken in ((resource.RLIMIT_AS, memory.vms), (resource.RLIMIT_DATA, private)):
        limit = resource.getrlimit(kind)[0]
        if limit != resource.RLIM_INFINITY:
            free = min(free, max(limit - int(taken), 0))
    return free


def check_memory(work: Work, limit: float | None = None) -> Storage:
    """Return where the arrays of a render are to lie.

    Parameters
    ----------
    limit : bytes that it may need in RAM before its arrays go to disk; None for any number

    Raises
    ------
    InputError
        with the numbers, where it needs more RAM, or more room on disk, than is free
    """
    need, free = work.always + work.arrays, free_memory()
    if limit is None or need <= limit:
        if need > free:
            raise InputError(
                f"this render needs about {need / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
                f"take a smaller size, fewer bands or fewer photons, or keep arrays on disk "
                f"(--memory 2G)"
            )
        return RAM
    folder = scratch_folder()
    room = shutil.disk_usage(folder).free
    in_ram = work.always + (work.arrays if is_in_ram(folder) else 0.0)
    for what, wanted, there in (("of RAM", in_ram, free), (f"in {folder}", work.arrays, room)):
        if wanted > there:
            raise InputError(
                f"this render needs about {wanted / 1e9:.1f} GB {what} and {there / 1e9:.1f} GB "
                f"are free: take a smaller size, fewer bands, fewer photons or fewer buffers"
            )
    return Storage(mapped=True)
