"""The file from which a render is resumed: moments, counters, and what decides them.

A line of magic, lengths and a checksum, a JSON head, the arrays as they lie in memory, and a
checksum of these. It is written beside the old one and then takes its place, so that whatever
happens one of them is whole.
"""

from __future__ import annotations

import json
import os
import struct
import time
import zlib
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, warn
from photonmap.runtime.fingerprint import difference
from photonmap.runtime.wording import shown
from photonmap.runtime.writing import check_length, check_writable, naming_written

EVERY = 60.0
"""Seconds between saves, at least."""
MOST_SHARE = 0.02
"""Of the time that saving may take."""
MAGIC = b"photonmap checkpoint 3\n"
_LENGTHS = struct.Struct("<QI")

Arrays = dict[str, NDArray[Any]]


def check_checkpoint(path: str | PathLike[str]) -> Path:
    """Check before a render that a checkpoint can be written; return its path.

    An `InputError` says that it is no name of a file, a folder, in a folder that is not writable,
    or another kind of file.
    """
    if not isinstance(path, str | PathLike):
        raise InputError(f"checkpoint {shown(path)} is not the name of a file")
    path = Path(path)
    check_length(_part_of(path))
    if path.is_dir():
        raise InputError("the checkpoint is a folder; choose another name", path)
    check_writable(path.parent, path)
    try:
        if path.exists() and path.stat().st_size and not is_checkpoint(path):
            raise InputError("this is not a checkpoint; choose another name", path)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"cannot read the checkpoint ({reason}); choose another", path) from None
    return path


def is_checkpoint(path: Path) -> bool:
    """Return whether a file is there, and begins as checkpoints do."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def _part_of(path: Path) -> Path:
    """Return the file that is written beside a checkpoint, and then takes its place."""
    return path.with_name(f".{path.name}.part")


class Checkpoint:
    """Saves the state of a render, known by its fingerprint, from time to time; brings it back."""

    def __init__(self, path: Path, fingerprint: dict[str, Any]) -> None:
        self.path, self._fingerprint = path, fingerprint
        self.seconds = 0.0
        self._next = time.monotonic() + EVERY
        self._saved: int | None = None
        self._failed = False

    def load(self, arrays: Callable[[dict[str, Any]], Arrays]) -> dict[str, Any]:
        """Fill arrays with those of the file; return the rest of the state, which says of which.

        A file that is damaged or of a different render is an `InputError`.
        """
        try:
            with self.path.open("rb") as file:
                head = _read_head(file)
                if reason := difference(head["fingerprint"], self._fingerprint):
                    raise InputError(
                        f"this checkpoint is of a different render: {reason}; repeat its "
                        f"arguments, or start from scratch without resuming",
                        self.path,
                    )
                _read_arrays(file, head["arrays"], arrays(head["state"]))
        except (EOFError, KeyError) as error:
            raise InputError(
                f"this checkpoint is damaged ({error}); remove it to start from scratch", self.path
            ) from None
        self._saved = head["state"]["passes"]
        return head["state"]

    def save_if_due(self, arrays: Arrays, state: dict[str, Any]) -> None:
        """Save if the last time is long enough ago for what saving takes."""
        if time.monotonic() >= self._next:
            self.save(arrays, state)

    def save(self, arrays: Arrays, state: dict[str, Any]) -> None:
        """Save unless these passes were; the first failure is a warning with the reason.

        The state is JSON-able; its `passes` are their number.
        """
        if self._saved == state["passes"]:
            return
        start = time.monotonic()
        try:
            self._write(arrays, state)
            self._saved, self._failed = state["passes"], False
        except (OSError, KeyboardInterrupt) as error:
            if not self._failed:
                reason = error if isinstance(error, OSError) else "interrupted"
                warn(f"{self.path}: pass {state['passes']} was not saved: {reason}")
            self._failed = True
        spent = time.monotonic() - start
        self.seconds += spent
        self._next = time.monotonic() + max(EVERY, spent / MOST_SHARE)

    def _write(self, arrays: Arrays, state: dict[str, Any]) -> None:
        part, size = _part_of(self.path), sum(array.nbytes for array in arrays.values())
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with naming_written(self.path, size, part), part.open("wb") as file:
                _write_all(file, self._fingerprint, arrays, state)
                file.flush()
                os.fsync(file.fileno())
            part.replace(self.path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise


def _write_all(
    file: BinaryIO, fingerprint: dict[str, Any], arrays: Arrays, state: dict[str, Any]
) -> None:
    shapes = {name: [array.dtype.str, array.shape] for name, array in arrays.items()}
    head = json.dumps({"fingerprint": fingerprint, "state": state, "arrays": shapes}).encode()
    file.write(MAGIC + _LENGTHS.pack(len(head), zlib.crc32(head)) + head)
    checksum = 0
    for piece in _pieces(arrays):
        checksum = zlib.crc32(piece, checksum)
        file.write(piece)
    file.write(struct.pack("<I", checksum))


def _read_head(file: BinaryIO) -> dict[str, Any]:
    """Return the JSON head, or raise EOFError."""
    start = file.read(len(MAGIC) + _LENGTHS.size)
    if len(start) < len(MAGIC) + _LENGTHS.size or not start.startswith(MAGIC):
        raise EOFError("it has no head")
    length, checksum = _LENGTHS.unpack(start[len(MAGIC) :])
    if length > os.fstat(file.fileno()).st_size:
        raise EOFError("its head is cut off")
    head = file.read(length)
    if zlib.crc32(head) != checksum:
        raise EOFError("its head is not what was written")
    return json.loads(head)


def _read_arrays(file: BinaryIO, shapes: dict[str, Any], arrays: Arrays) -> None:
    """Fill arrays in place, or raise EOFError."""
    if shapes != {name: [array.dtype.str, [*array.shape]] for name, array in arrays.items()}:
        raise EOFError("it has other arrays")
    checksum = 0
    for piece in _pieces(arrays):
        if file.readinto(piece) != len(piece):  # type: ignore[attr-defined]
            raise EOFError("it is cut off")
        checksum = zlib.crc32(piece, checksum)
    if file.read() != struct.pack("<I", checksum):
        raise EOFError("its arrays are not what was written")


def _pieces(arrays: Arrays) -> Iterator[memoryview]:
    """Give the bytes of all arrays, in pieces that stay in the processor's cache."""
    for array in arrays.values():
        flat = array.reshape(-1).view(np.uint8)
        for first in range(0, flat.size, 1 << 20):
            yield flat[first : first + (1 << 20)].data
