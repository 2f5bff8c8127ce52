"""Where the large arrays of a render lie, and whether they fit: in RAM, or in scratch files.

Scratch files are mapped into memory. A mapped array is a plain array to NumPy and to the kernels.
Its file has no name from the start (on Windows, it goes with the process), so nothing stays behind,
whatever happens. Where the system can, its space is reserved at once, so a full disk is reported
before the work begins.
"""

from __future__ import annotations

import mmap
import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
from numpy.typing import DTypeLike, NDArray

from photonmap.errors import InputError

IN_RAM_ITSELF = ("tmpfs", "ramfs")
STRIP = 1 << 18
"""Items that are worked on at a time where no copy of a whole array may be made."""


@dataclass(frozen=True)
class Storage:
    """Makes arrays."""

    mapped: bool = False
    """in scratch files in the folder for temporary files (TMPDIR), in place of RAM"""

    def zeros(self, shape: int | tuple[int, ...], dtype: DTypeLike = np.float32) -> NDArray[Any]:
        """Make an array of zeros; without room for it on the disk, that is an `InputError`."""
        size = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
        if not self.mapped or size == 0:
            return np.zeros(shape, dtype)
        return np.ndarray(shape, dtype, buffer=_map(size))


RAM = Storage()


def scratch_folder() -> Path:
    """Return where scratch files lie; `InputError` if no such folder can be written to."""
    try:
        return Path(tempfile.gettempdir())
    except OSError as error:
        raise InputError(f"{error.strerror}: set TMPDIR to a folder on a disk") from None


def is_in_ram(folder: Path) -> bool:
    """Return whether a folder's files lie in RAM themselves, as /dev/shm's do."""
    mounts = {part.mountpoint: part.fstype for part in psutil.disk_partitions(all=True)}
    folder = folder.resolve()
    kinds = (mounts[str(at)] for at in (folder, *folder.parents) if str(at) in mounts)
    return next(kinds, "") in IN_RAM_ITSELF


def strips(count: int) -> Iterator[slice]:
    """Cut a number of items into consecutive strips of at most `STRIP`."""
    for first in range(0, count, STRIP):
        yield slice(first, min(first + STRIP, count))


def _map(size: int) -> mmap.mmap:
    """Map a file without a name, of zeros."""
    folder = scratch_folder()
    try:
        with tempfile.TemporaryFile(prefix="photonmap-", dir=folder) as file:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            return mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise InputError(
            f"cannot make a scratch file of {size / 1e9:.2f} GB in {folder} ({error.strerror}): "
            f"make room there, or set TMPDIR to a folder on another disk"
        ) from None


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
    """Return where the arrays of a render, which needs so many bytes, are to lie.

    Above a limit of bytes of RAM they go to disk. More RAM, or more space on disk, than is free is
    an `InputError`.
    """
    total, free = need.always + need.arrays, free_memory()
    if limit is None or total <= limit:
        if total > free:
            raise InputError(
                f"this render needs about {total / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
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
