"""The one decorator of all kernels, and the folder that keeps their machine code.

Numba notices an edit of a kernel's own file, not of the files it calls into (numba #1833), so
the cache folder is named by a hash over all kernel sources.
"""

import hashlib
from collections.abc import Callable
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numba
import platformdirs
from llvmlite.binding import Linkage, ModuleRef
from numba import config
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types import unliteral


def source_hash(folder: Path) -> str:
    """Hash of every Python source below `folder` and of Numba's version, 16 hex digits."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(folder.rglob("*.py")):
        name = source.relative_to(folder).as_posix()
        digest.update(name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR, or the user's cache folder."""
    base = Path(config.CACHE_DIR or platformdirs.user_cache_dir("photonmap"))
    return base / f"kernels-{source_hash(Path(__file__).parents[1])}"


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
    return _of_class(_Kernel, _compile(function, cache=True, forceinline=True))


def jit(function: Callable) -> Callable:
    """Compile a function of kernels into its callers' machine code."""
    return _of_class(_Inner, _compile(function, forceinline=True, **_NO_WRAPPERS))


def outlined(function: Callable) -> Callable:
    """Compile a function of kernels that is large and rare: it is called, not inlined."""
    return _of_class(_Inner, _compile(function, **_NO_WRAPPERS))


# Turning Python's objects into a scene's arrays takes more code than many a function itself.
_NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Kernel(CPUDispatcher):
    """A function that Python calls: it brings the code of all that it calls together."""

    def compile(self, signature: object) -> object:
        """Compile, or load from the cache."""
        with _libraries_of(self.targetctx.codegen(), _WholeLibrary):
            return super().compile(signature)


class _Inner(CPUDispatcher):
    """A function of kernels; one that Python calls after all, as tests do, gets a wrapper then."""

    def __call__(self, *arguments: object) -> object:
        return _wrapped(self)(*arguments)

    def get_call_template(self, args: tuple, kws: dict) -> object:
        """Return the one version for all constants of a type, which inlining makes constant again.

        Numba's own would be a version for each number that a caller writes.
        """
        kinds = {name: unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template(tuple(map(unliteral, args)), kinds)

    def compile(self, signature: object) -> object:
        """Compile for linking alone: kernels optimise what they inline, and emit machine code.

        Numba's own would look for a file and start two timers for every function on the way in,
        each of which hears of every step further in.
        """
        if not _IS_KNOWN:
            return super().compile(signature)
        arguments, result = normalize_signature(signature)
        known = self.overloads.get(tuple(arguments))
        if known is not None:
            return known.entry_point
        with _libraries_of(self.targetctx.codegen(), _PartLibrary), self._compiling_counter:
            compiled = self._compiler.compile(arguments, result)
            self.add_overload(compiled)
        return compiled.entry_point


class _PartLibrary(JITCodeLibrary):
    """Code that is only linked into kernels: compiling it further took half of all time."""

    def finalize(self) -> None:
        """Close the library."""
        self._raise_if_finalized()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalize_dynamic_globals()
        self._finalized = True

    @property
    def own_module(self) -> ModuleRef:
        """The code without what it calls."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = "linkonce_odr"
        return self._final_module

    def _get_module_for_linking(self) -> ModuleRef:
        """Return the code with all that it calls, for code that is not a kernel's.

        Numba's own functions are here too, as `max`, which anyone's code may call later.
        """
        if self._shared_module is None:
            self._shared_module = self.own_module.clone()
            for library in _callers_first(self._linking_libraries):
                module = library._get_module_for_linking()
                self._shared_module.link_in(module, preserve=True)
        return self._shared_module

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> "_NoEnvironments":
        return _NoEnvironments(self._codegen)


class _WholeLibrary(JITCodeLibrary):
    """Code that links all parts in, each once: parts within parts were copied at every level."""

    def finalize(self) -> None:
        """Link, optimise, and emit machine code."""
        self._linking_libraries = _callers_first(self._linking_libraries)
        super().finalize()


class _Alone(NamedTuple):
    """A part, to be linked without what it calls."""

    part: _PartLibrary

    @property
    def _reload_init(self) -> set:
        return self.part._reload_init

    def _get_module_for_linking(self) -> ModuleRef:
        return self.part.own_module


def _callers_first(libraries: list) -> list:
    """Return libraries and all parts that they call, alone, each before what it calls.

    LLVM leaves out a function that nothing calls yet when it is linked.
    """
    order: dict = {}

    def visit(library: JITCodeLibrary) -> None:
        if library in order:
            return
        is_part = isinstance(library, _PartLibrary)
        for called in library._linking_libraries if is_part else ():
            visit(called)
        order[library] = _Alone(library) if is_part else library

    for library in libraries:
        visit(library)
    return list(order.values())[::-1]


@contextmanager
def _libraries_of(codegen: JITCPUCodegen, kind: type):
    """Let what is compiled be put into libraries of a kind, while no other thread compiles."""
    with global_compiler_lock:
        before = codegen._library_class
        codegen._library_class = kind if _IS_KNOWN else before
        try:
            yield
        finally:
            codegen._library_class = before


_IS_KNOWN = all(
    hasattr(kind, name)
    for kind, names in (
        (JITCodeLibrary, ("_get_module_for_linking", "_finalize_dynamic_globals")),
        (JITCPUCodegen, ("_library_class",)),
        (CPUDispatcher, ("_can_compile", "add_overload")),
    )
    for name in names
)
"""Whether Numba's inside is as it was: else functions are compiled in full, which takes longer."""


class _NoEnvironments:
    """A code generator for code that has no address: its Python environment is not set."""

    def __init__(self, codegen: object) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> object:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: object) -> None:
        pass


@cache
def _wrapped(function: Callable) -> Callable:
    def call(*arguments):
        return function(*arguments)

    return _of_class(_Kernel, numba.njit(error_model="numpy", _nrt=False)(call))


def _of_class(kind: type, compiled: Callable) -> Callable:
    if isinstance(compiled, CPUDispatcher):  # else this runs as plain Python
        compiled.__class__ = kind
    return compiled


def _compile(function: Callable, **options: bool) -> Callable:
    with _cached_in(CACHE_FOLDER):
        return numba.njit(nogil=True, error_model="numpy", _nrt=False, **options)(function)
