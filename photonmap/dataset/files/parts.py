"""The arrays of an OpenEXR file by name, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from photonmap.buffers import row_of
from photonmap.dataset.files.lean import derive, derived_names, exact_halves, source_of
from photonmap.io.exr import list_parts, name_errors, read_exr
from photonmap.runtime.wording import listed

Array = NDArray[Any]


def lacking(name: str, held: Iterable[str], remedy: str = "") -> KeyError:
    """Return the error that there is no array of a name: which there are, and a remedy."""
    row = row_of(name)
    if not remedy and row is not None and not row.is_banded:
        remedy = f"it has no bands, so it is among the image's own: image[{name!r}]"
    return KeyError(f"{name!r} is not one of {listed(held, 99)}{remedy and '; '}{remedy}")


class Arrays(dict[str, Array]):
    """Arrays by name; a missing one raises an error that says how to get it."""

    def __missing__(self, name: str) -> Array:
        raise lacking(name, self)


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
                raise lacking(name, self)
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
