"""The one decorator of all kernels, and the folder that keeps their machine code.

Numba notices an edit of a kernel's own file, not of the files it calls into (numba #1833), so
the cache folder is named by a hash over all kernel sources.
"""

import hashlib
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path

import numba
import platformdirs
from numba import config


def source_hash(folder: Path) -> str:
    """Hash of every Python source in `folder` and of Numba's version, 16 hex digits."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR, or the user's cache folder."""
    base = Path(config.CACHE_DIR or platformdirs.user_cache_dir("photonmap"))
    return base / f"kernels-{source_hash(Path(__file__).parent)}"


CACHE_FOLDER = cache_folder()


@contextmanager
def _cached_in(folder: Path):
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before


def jit(function: Callable) -> Callable:
    """Compile into the callers' machine code: releases the GIL, divides as NumPy does, is cached.

    Kernels allocate nothing: without Numba's reference counts, whose atomic increments took half
    of the camera pass, arrays cost nothing to pass on.
    """
    return _compile(function, forceinline=True)


def outlined(function: Callable) -> Callable:
    """Compile a function that is large and rare: it is called, not inlined."""
    return _compile(function)


def _compile(function: Callable, **options: bool) -> Callable:
    with _cached_in(CACHE_FOLDER):
        return numba.njit(nogil=True, cache=True, error_model="numpy", _nrt=False, **options)(
            function
        )
