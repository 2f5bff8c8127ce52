"""Fingerprints: hashes of nested arrays, and in what two of them differ."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

ADDRESSES = ("scene", "address")
"""Fields of the kernels' records that differ from process to process."""
DIGESTS = ("band curves", "camera", "geometry", "materials", "lights", "kernels")
"""Entries that are recorded only as hashes."""


def difference(
    there: dict[str, Any], here: dict[str, Any], owners: tuple[str, str] = ("there", "here")
) -> str:
    """Say in which entries two fingerprints differ, "seed 0 there, 1 here"; "" if in none.

    Hashes are named only where no argument explains why they differ. Owners are what the two are
    called.
    """
    names = [name for name in {**here, **there} if there.get(name) != here.get(name)]
    arguments = [name for name in names if name not in DIGESTS]
    if arguments:
        return ", ".join(
            f"{name} {there.get(name)} {owners[0]}, {here.get(name)} {owners[1]}"
            for name in arguments
        )
    return f"other {' and '.join(names)}" if names else ""


def digest(value: Any) -> str:
    """Return the hash of nested records, lists and arrays, 16 hex digits."""
    state = hashlib.blake2b(digest_size=8)
    _feed(state, value)
    return state.hexdigest()


def _feed(digest: hashlib.blake2b, value: Any) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif hasattr(value, "_asdict"):
        _feed(digest, [part for name, part in value._asdict().items() if name not in ADDRESSES])
    elif isinstance(value, list | tuple):
        digest.update(f"{len(value)}(".encode())
        for part in value:
            _feed(digest, part)
    else:
        digest.update(f"{value!r};".encode())
