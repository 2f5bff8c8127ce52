"""Where the large arrays of a render lie: in RAM, or in scratch files mapped into memory.

A mapped array is a plain array to NumPy and to the kernels. Its file has no name from the start
(on Windows, it goes with the process), so nothing stays behind, whatever happens. Where the system
can, its space is reserved at once, so a full disk is reported before the work begins.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import DTypeLike, NDArray

from photonmap.errors import InputError

IN_RAM_ITSELF = ("tmpfs", "ramfs")
STRIP = 1 << 18
"""Items that are worked on at a time where no copy of a whole array may be made."""


@dataclass(frozen=True)
class Storage:
    """Makes arrays.

    Parameters
    ----------
    mapped : in scratch files in the folder for temporary files (TMPDIR), in place of RAM
    """

    mapped: bool = False

    def zeros(self, shape: int | tuple[int, ...], dtype: DTypeLike = np.float32) -> NDArray[Any]:
        """Make an array of zeros.

        Raises
        ------
        InputError
            if the disk has no room for it
        """
        size = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
        if not self.mapped or size == 0:
            return np.zeros(shape, dtype)
        return np.ndarray(shape, dtype, buffer=_map(size))


RAM = Storage()


def scratch_folder() -> Path:
    """Return where scratch files lie.

    Raises
    ------
    InputError
        if no folder for temporary files can be written to
    """
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
