"""The arrays of an OpenEXR file by name, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from photonmap.dataset.files.lean import derive, derived_names, exact_halves, source_of
from photonmap.io.exr import list_parts, name_errors, read_exr

Array = NDArray[Any]


class Parts(Mapping[str, Array]):
    """The arrays of a file, and those that follow from them where lean files do not hold them.

    Parameters
    ----------
    path : of the file
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read: dict[str, Array] = {}

    @cached_property
    def _held(self) -> list[str]:
        return list_parts(self._path)

    @cached_property
    def _names(self) -> list[str]:
        record = read_exr(self._path, ()).record
        return [*self._held, *derived_names(self._held, record)]

    @property
    def halves(self) -> set[str]:
        """Names of the arrays that the file has in half precision."""
        return exact_halves(self._names, self._held, list_parts(self._path, half=True))

    def __getitem__(self, name: str) -> Array:
        """Return an array, read from its part alone.

        Raises
        ------
        KeyError : there is none of this name
        InputError : the file is damaged
        """
        if name not in self._read:
            source = source_of(name, self._held) if name in self._names else None
            if source is None:
                raise KeyError(name)
            if source not in self._read:
                found = read_exr(self._path, (source,))
                self._read |= found.buffers | name_errors(found.errors, found.block_errors)
            self._read[name] = (
                derive(name, self._read[source]) if name != source else self._read[name]
            )
        return self._read[name]

    def __contains__(self, name: object) -> bool:
        """Return whether there is such an array; none is read."""
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
