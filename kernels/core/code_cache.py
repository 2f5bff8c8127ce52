"""Where machine code of kernels is kept, and which of it runs on this processor.

A file of code is named by a hash of the sources that its kernel reaches by imports: Numba notices
an edit of a kernel's own file alone (numba #1833), and an edit elsewhere costs nothing. Code comes
with the package, for levels of processors (x86-64-v3, …), or is compiled for this very one and kept
in the user's cache folder. The bits of pictures are the same.
"""

import hashlib
import pickle
import re
import sys
import warnings
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Event
from typing import Any

import llvmlite.binding as llvm
import numba
import platformdirs
from numba import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.registry import cpu_target

SOURCES = Path(__file__).parents[1]
USER_FOLDER = Path(config.CACHE_DIR or platformdirs.user_cache_dir("photonmap"))
CODE_FOLDER = USER_FOLDER / "code"  # Of what was compiled on this machine
SHIPPED_FOLDER = SOURCES / "compiled"  # Of what was compiled when the package was built
_X86 = "cx16 sahf popcnt sse4.2 ssse3 avx avx2 bmi bmi2 f16c fma lzcnt movbe xsave"
_LEVELS = {
    "x86_64": {
        "x86-64-v4": f"{_X86} avx512f avx512bw avx512cd avx512dq avx512vl",
        "x86-64-v3": _X86,
    },
    "aarch64": {"generic": ""},
}
"""Levels of processors, the best first, with the features that each asks for"""
_IMPORTS = re.compile(r"from photonmap\.kernels([\w.]*) import (\([^)]*\)|[^\n]*)")


def source_hash(folder: Path) -> str:
    """Hash of every Python source below `folder` and of Numba's version, 16 hex digits."""
    return _hash_of(sorted(folder.rglob("*.py")), folder)


def _hash_of(sources: list[Path], folder: Path) -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sources:
        name = source.relative_to(folder).as_posix() if folder in source.parents else source.name
        digest.update(name.encode() + b"\0" + _content(source) + b"\0")
    return digest.hexdigest()[:16]


@cache
def _content(source: Path) -> bytes:
    return source.read_bytes()


@cache
def reached_hash(source: Path) -> str:
    """Hash of a source and of all kernels' sources that it imports, at any distance."""
    reached, ahead = {source}, [source]
    while ahead:
        new = _imported(ahead.pop()) - reached
        reached |= new
        ahead += new
    return _hash_of(sorted(reached), SOURCES)


@cache
def _imported(source: Path) -> frozenset[Path]:
    found = set()
    for module, names in _IMPORTS.findall(_content(source).decode()):
        folder = SOURCES.joinpath(*module.split("."))
        found |= {
            folder.with_suffix(".py"),
            *(folder / f"{each}.py" for each in re.findall(r"\w+", names)),
        }
    return frozenset(path for path in found if path.is_file())


class KernelCache(FunctionCache):
    """The machine code of a kernel in files: the user's, else that of the package.

    A damaged file is warned of, and written anew. Where nothing can be written, as on a full disk,
    one warning says so, and kernels stay in memory.
    """

    def __init__(self, function: Any) -> None:
        stamp = reached_hash(Path(function.__code__.co_filename))
        self._name, self._py_func, self._impl = repr(function), function, _Layout(function, stamp)
        self._cache_path = str(CODE_FOLDER)
        self._cache_file, self._shipped = (
            _CheckedFile(str(folder), self._impl.filename_base, stamp)
            for folder in (CODE_FOLDER, SHIPPED_FOLDER)
        )
        self.enable()

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the compiled kernel or None, without Numba's preparing of the compiler, 0.3 s."""
        with self._guard_against_spurious_io_errors():
            signature, (triple, *_), code = self._index_key(signature, context.codegen())
            for processor in processors():
                key = signature, (triple, *processor), code
                data = self._cache_file.load(key) or self._shipped.load(key)
                if data is not None:
                    return self._impl.rebuild(context, data)
        return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep a compiled kernel in files, if these can be written."""
        try:
            super().save_overload(signature, data)
        except OSError as error:
            _warn_of_lost(error.strerror or str(error))


@cache
def _warn_of_lost(reason: str) -> None:
    text = (
        f"compiled kernels cannot be kept in {CODE_FOLDER} ({reason}) and will be made anew by the "
        "next run: make room there, or set NUMBA_CACHE_DIR to another folder"
    )
    is_lost.set()
    warnings.warn(text, RuntimeWarning, stacklevel=2)


is_lost = Event()
"""Set where a kernel that this process compiled could not be kept"""


class _CheckedFile(IndexDataCacheFile):
    """Files that begin with a hash of what follows."""

    def load(self, key: Any) -> Any:
        """Return what was saved under a key; None if nothing was, or it cannot be read."""
        try:
            return super().load(key)
        except OSError:
            return None
        except _DAMAGE:
            text = f"compiled kernels in {self._index_path} are damaged and will be made anew"
            warnings.warn(text, RuntimeWarning, stacklevel=2)
            with suppress(OSError):  # the package may be for reading alone
                Path(self._index_path).unlink()
            return None

    def _dump(self, obj: Any) -> bytes:
        data = super()._dump(obj)
        return hashlib.sha256(data).digest() + data

    def _load_index(self) -> Any:
        try:
            version, _, data = Path(self._index_path).read_bytes().partition(b"\n")
        except FileNotFoundError:
            return {}
        return _unpacked(data)[1] if version.decode() == self._version else {}

    def _save_index(self, overloads: Any) -> None:
        with self._open_for_write(self._index_path) as file:
            file.write(self._version.encode() + b"\n" + self._dump((None, overloads)))

    def _load_data(self, name: str) -> Any:
        return _unpacked(Path(self._data_path(name)).read_bytes())


_DAMAGE = (pickle.UnpicklingError, UnicodeDecodeError)


def _unpacked(data: bytes) -> Any:
    digest, data = data[:32], data[32:]
    if hashlib.sha256(data).digest() != digest:
        raise pickle.UnpicklingError("damaged")
    return pickle.loads(data)


class _Layout(CompileResultCacheImpl):
    """Names of a kernel's files."""

    def __init__(self, function: Any, stamp: str) -> None:
        self._locator, self._lineno = _Place(function), function.__code__.co_firstlineno
        module, (major, minor, *_) = function.__module__.rpartition(".")[2], sys.version_info
        self._filename_base = f"{module}.{function.__qualname__}-{stamp}.py{major}{minor}"

    def reduce(self, data: Any) -> Any:
        """Return what is saved: machine code without the bitcode from which others would link."""
        (name, kind, (code, _)), *rest = super().reduce(data)
        return (name, kind, (code, _symbols_of(data.library))), *rest

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Return the compiled kernel; Python calls it, and no other kernel."""
        compiled = super().rebuild(target_context, payload)
        compiled.library._get_module_for_linking = _refuse
        return compiled


def _symbols_of(library: Any) -> bytes:
    """Return the bitcode of a module that has the symbols of a library, and nothing in them."""
    module = library._final_module
    functions = [each.name for each in module.functions if not each.is_declaration]
    variables = [each.name for each in module.global_variables if not each.is_declaration]
    lines = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    lines += [f'@"{name}" = global i8 0' for name in variables]
    return bytes(llvm.parse_assembly("\n".join(lines)).as_bitcode())


def _refuse() -> Any:
    raise TypeError("a kernel from a file has no bitcode to be linked into another; call a @jit")


class _Place:
    """The folder of machine code, as Numba asks for it."""

    def __init__(self, function: Any) -> None:
        self._py_file = function.__code__.co_filename

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        CODE_FOLDER.mkdir(parents=True, exist_ok=True)


def levels() -> list[str]:
    """Return the levels of processors that this one has, the best first."""
    has = {name for name, there in llvm.get_host_cpu_features().items() if there}
    known = _LEVELS.get(llvm.get_process_triple().partition("-")[0], {})
    return [level for level, needed in known.items() if has >= set(needed.split())]


@cache
def processors() -> list[tuple[str, str]]:
    """Return names and features of the processors whose code runs here, the best first.

    This very one, for which kernels are compiled, then its levels; or Numba's `NUMBA_CPU_NAME`
    alone, if it is set.
    """
    codegen = cpu_target.target_context.codegen()
    _, *own = codegen.magic_tuple()
    return [tuple(own), *((level, "") for level in levels() if config.CPU_NAME is None)]
