"""What reading a file may take of memory: bounds that are checked before anything is allocated.

A reader's arrays are a small multiple of its file, but where a format packs data, or shows things
several times. Packed data may be `TIMES` as large as their file, or `FREELY`; what is shown several
times may take the memory that is free.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from photonmap.errors import InputError

FREELY = 256 << 20
"""Bytes that any file may unpack to, or show in all."""
TIMES = 100
"""Beyond these, by how much a packed file may be smaller than what it holds."""
OF_TRIANGLE = 200
"""Bytes of a triangle in a scene, with its share of vertices and of temporary arrays."""
_ARRAY = ".npy"


def check_unpacked(path: Path, needed: int, packed: int | None = None) -> None:
    """Refuse, before it is unpacked, a file that would take far more memory than it is large.

    Parameters
    ----------
    path : of the file
    needed : bytes of what it holds
    packed : bytes of it, by default of the whole file
    """
    packed = packed or path.stat().st_size
    if needed > max(FREELY, TIMES * packed):
        raise InputError(
            f"needs {needed / 1e9:.1f} GB of memory, {needed // packed} times its size; "
            "save it without compression",
            path,
        )


@dataclass
class Budget:
    """The memory taken by what a file shows, perhaps several times: no more than is free."""

    path: Path  # the file
    spent: int = field(default=0, init=False)  # bytes

    def spend(self, size: int, what: str = "what it shows several times") -> None:
        """Refuse what takes more bytes than are left."""
        self.spent += size
        if self.spent > FREELY and self.spent > self._free:
            raise InputError(
                f"{what} needs more than the {self._free / 1e9:.1f} GB of memory that are free; "
                "leave some of it out",
                self.path,
            )

    @cached_property
    def _free(self) -> int:
        from photonmap.runtime.storage import free_memory

        return free_memory() + FREELY


def lacking(error: MemoryError) -> str:
    """Return how much memory an error asked for, if it says so: "2.5 GB of memory"."""
    shape, kind = getattr(error, "shape", None), getattr(error, "dtype", None)
    if shape is None or kind is None:
        return "more memory than is free"
    return f"{math.prod(shape) * np.dtype(kind).itemsize / 1e9:.1f} GB of memory, more than is free"


def refuse_large(error: MemoryError, path: str | PathLike[str]) -> NoReturn:
    """Raise the `InputError` about a file for which memory did not suffice."""
    message = f"needs {lacking(error)}; close other programs, or make it smaller"
    raise InputError(message, path) from None


@contextmanager
def naming_large(path: str | PathLike[str]) -> Iterator[None]:
    """Have a lack of memory name the file that is read."""
    try:
        yield
    except MemoryError as error:
        refuse_large(error, path)


Shapes = Mapping[str, tuple[int, ...]]


def read_npz(
    path: Path, choose: Callable[[Shapes], Iterable[str]] = tuple
) -> dict[str, NDArray[Any]]:
    """Read arrays of an NPZ file; no other is unpacked.

    Parameters
    ----------
    path : of the file
    choose : from the shapes of all arrays by name to the names of those to read; by default all

    Raises
    ------
    InputError : they would take far more memory than the file is large
    OSError, ValueError : it is no such file
    """
    try:
        with path.open("rb") as file, zipfile.ZipFile(file) as archive:
            members = {
                name.removesuffix(_ARRAY): name
                for name in archive.namelist()
                if name.endswith(_ARRAY)
            }
            heads = {name: _read_head(archive, member) for name, member in members.items()}
            chosen = list(choose({name: shape for name, (shape, _) in heads.items()}))
            sizes = [math.prod(heads[name][0]) * heads[name][1].itemsize for name in chosen]
            check_unpacked(path, sum(sizes))
            for name, size in zip(chosen, sizes, strict=True):
                if size > archive.getinfo(members[name]).file_size:
                    raise ValueError(f"{name} is truncated")
            return {name: _read_array(archive, members[name]) for name in chosen}
    except (EOFError, KeyError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(str(error) or "it is truncated") from None


def _read_head(archive: zipfile.ZipFile, member: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return the shape and the type of an array."""
    with archive.open(member) as stream:
        version = npy.read_magic(stream)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, kind = read(stream)
    if kind.hasobject:
        raise ValueError(f"{member.removesuffix(_ARRAY)} holds objects of Python")
    return shape, kind


def _read_array(archive: zipfile.ZipFile, member: str) -> NDArray[Any]:
    stream: BinaryIO
    with archive.open(member) as stream:  # type: ignore[assignment]
        array: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
    return array
