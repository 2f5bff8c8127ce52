"""Read single samples of an exported data set: from a folder, or over HTTP by ranges of bytes."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from functools import cached_property
from http import HTTPStatus
from os import PathLike
from pathlib import Path
from typing import Any
from urllib.error import URLError
from urllib.parse import quote
from urllib.request import Request, urlopen

import numpy as np

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, suggest

_INDEX = "index.jsonl"
_PATIENCE = 60.0  # seconds to wait for an answer


class Sample(Mapping[str, Any]):
    """One sample: members by their endings, each read when it is asked for, and no other.

    "rgb.shading.npy" is an array, of half precision as float32, "json" what the manifest says,
    "radiance.png" the bytes of a file. The ending .npy may be left out.
    """

    def __init__(self, where: str, line: dict[str, Any]) -> None:
        self._where, self.line = where, line

    def __repr__(self) -> str:
        return f"<Sample {self.line['name']}>"

    def __getitem__(self, name: str) -> Any:
        members = self.line["members"]
        name = name if name in members else f"{name}.npy"
        if name not in members:
            raise KeyError(f"{name.removesuffix('.npy')!r} is not one of {listed(members, 99)}")
        data = _read(f"{self._where}/{quote(self.line['shard'])}", *members[name])
        if name.endswith(".npy"):
            array = np.load(io.BytesIO(data), allow_pickle=False)
            return array.astype(np.float32) if array.dtype == np.float16 else array
        return json.loads(data) if name.endswith("json") else data

    def __iter__(self) -> Iterator[str]:
        return iter(self.line["members"])

    def __len__(self) -> int:
        return len(self.line["members"])


class Shards(Mapping[str, Sample]):
    """The samples of an exported data set by the names of their images.

    Parameters
    ----------
    where : folder, or address that begins with http:// or https://
    """

    def __init__(self, where: str | PathLike[str]) -> None:
        text = str(where)
        self.where = text.rstrip("/") if _is_remote(text) else Path(where).resolve().as_uri()

    def __repr__(self) -> str:
        return f"<Shards {self.where}: {len(self)} samples>"

    @cached_property
    def _lines(self) -> dict[str, dict[str, Any]]:
        try:
            lines = _read(f"{self.where}/{_INDEX}").decode().splitlines()
            return {line["name"]: line for line in map(json.loads, lines)}
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"is not an index ({error})", f"{self.where}/{_INDEX}") from None

    def __getitem__(self, name: str) -> Sample:
        if name not in self._lines:
            raise KeyError(f"there is no sample {name!r}; {suggest(name, self._lines)}")
        return Sample(self.where, self._lines[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)


def open_shards(where: str | PathLike[str]) -> Shards:
    """Open what `python -m photonmap dataset export` wrote as shards, here or on a server.

    Raises
    ------
    InputError : there is no index
    """
    shards = Shards(where)
    len(shards)
    return shards


def _is_remote(where: str) -> bool:
    return where.startswith(("http://", "https://"))


def _read(address: str, offset: int = 0, length: int | None = None) -> bytes:
    """Return bytes of a file; a server has to send these alone."""
    request = Request(address)
    ranged = length is not None and _is_remote(address)
    if length is not None and ranged:
        request.add_header("Range", f"bytes={offset}-{offset + length - 1}")
    try:
        with urlopen(request, timeout=_PATIENCE) as answer:
            if ranged and answer.status != HTTPStatus.PARTIAL_CONTENT:
                raise InputError("is sent whole only; use a server that knows ranges", address)
            if not ranged and length is not None:
                answer.fp.seek(offset)
            data = answer.fp.read(length) if not ranged and length is not None else answer.read()
    except (URLError, OSError) as error:
        reason = getattr(error, "reason", error)
        raise InputError(f"cannot be read ({reason}); check the address", address) from None
    if length is not None and len(data) != length:
        raise InputError("is shorter than its index says; export it again", address)
    return bytes(data)
