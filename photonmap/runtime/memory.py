"""How much memory is free, and whether a render fits into it or goes to disk."""

from __future__ import annotations

import shutil
from typing import NamedTuple

import psutil

from photonmap.errors import InputError
from photonmap.runtime.storage import RAM, Storage, is_in_ram, scratch_folder


class Need(NamedTuple):
    """Bytes that a render needs."""

    always: float
    """of RAM: the interpreter, the scene and all that is never on disk"""
    arrays: float
    """of the large arrays, which may be on disk"""


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


def check_memory(need: Need, limit: float | None = None) -> Storage:
    """Return where the arrays of a render are to lie.

    Parameters
    ----------
    need : bytes that it is estimated to take
    limit : bytes of RAM above which its arrays go to disk; None for any number

    Raises
    ------
    InputError
        with the numbers, where it needs more RAM, or more space on disk, than is free
    """
    whole, free = need.always + need.arrays, free_memory()
    if limit is None or whole <= limit:
        if whole > free:
            raise InputError(
                f"this render needs about {whole / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
                f"use a smaller size, fewer bands or fewer photons, or keep arrays on disk "
                f"(--memory 2G, memory=2 << 30)"
            )
        return RAM
    folder = scratch_folder()
    space = shutil.disk_usage(folder).free
    in_ram = need.always + (need.arrays if is_in_ram(folder) else 0.0)
    for what, wanted, there in (("of RAM", in_ram, free), (f"in {folder}", need.arrays, space)):
        if wanted > there:
            raise InputError(
                f"this render needs about {wanted / 1e9:.1f} GB {what} and {there / 1e9:.1f} GB "
                f"are free: use a smaller size, fewer bands, fewer photons or fewer buffers"
            )
    return Storage(mapped=True)
