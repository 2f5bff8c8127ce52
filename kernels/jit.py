"""The one decorator of all kernels, and the folder that keeps their machine code.

Numba notices an edit of a kernel's own file, not of the files it calls into (numba #1833), so
the cache folder is named by a hash over all kernel sources.
"""

import hashlib
from collections.abc import Callable
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba
import platformdirs
from numba import config
from numba.core.registry import CPUDispatcher


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


def kernel(function: Callable) -> Callable:
    """Compile a function that Python calls: releases the GIL, divides as NumPy does, is cached.

    Kernels allocate nothing: without Numba's reference counts, whose atomic increments took half
    of the camera pass, arrays cost nothing to pass on. Inlined into their own wrappers they keep
    the scene's arrays at hand: a call that passes them all took a quarter of the camera pass.
    """
    return _compile(function, forceinline=True)


def jit(function: Callable) -> Callable:
    """Compile a function of kernels into its callers' machine code."""
    return _inner(_compile(function, forceinline=True, **_NO_WRAPPERS))


def outlined(function: Callable) -> Callable:
    """Compile a function of kernels that is large and rare: it is called, not inlined."""
    return _inner(_compile(function, **_NO_WRAPPERS))


# Turning Python's objects into a scene's arrays takes more code than many a function itself.
_NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Inner(CPUDispatcher):
    """A function of kernels; one that Python calls after all, as tests do, gets a wrapper then."""

    def __call__(self, *arguments: object) -> object:
        return _wrapped(self)(*arguments)


@cache
def _wrapped(function: Callable) -> Callable:
    @numba.njit(error_model="numpy", _nrt=False)
    def call(*arguments):
        return function(*arguments)

    return call


def _inner(compiled: Callable) -> Callable:
    if isinstance(compiled, CPUDispatcher):
        compiled.__class__ = _Inner
    return compiled


def _compile(function: Callable, **options: bool) -> Callable:
    with _cached_in(CACHE_FOLDER):
        return numba.njit(nogil=True, cache=True, error_model="numpy", _nrt=False, **options)(
            function
        )
