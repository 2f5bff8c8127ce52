"""Read single samples of an exported data set: from a folder, or over HTTP by ranges of bytes."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator, Mapping
from http import HTTPStatus
from http.client import HTTPException
from os import PathLike
from pathlib import Path
from typing import Any
from urllib.error import URLError
from urllib.parse import quote, urlsplit
from urllib.request import Request, url2pathname, urlopen
from urllib.response import addinfourl

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.inside import check_inside, inside
from photonmap.dataset.files.schema import TEXT, Table, misfits, whole
from photonmap.errors import InputError
from photonmap.runtime.wording import listed, suggest

_INDEX = "index.jsonl"
_AGAIN = "export the set again"
_CHUNK = 2**20  # bytes that are read at once
_PLACE = [whole(), whole(1)]
_LINE = {"name": TEXT, "shard": TEXT, "members": Table(_PLACE)}
"""What is read of a line of the index, whose places are offsets and lengths in bytes."""
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
        address = _address(self._where, self.line["shard"])
        data = _read(address, *members[name])
        try:
            if name.endswith(".npy"):
                return _read_array(data)
            return json.loads(data) if name.endswith("json") else data
        except (ValueError, RecursionError) as error:
            problem = f"{self!r}: {name} is damaged ({error}); export the set again"
            raise InputError(problem, address) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.line["members"])

    def __len__(self) -> int:
        return len(self.line["members"])


class Shards(dict[str, Sample]):
    """The samples of an exported data set by the names of their images.

    Parameters
    ----------
    where : folder, or address that begins with http:// or https://
    """

    def __init__(self, where: str | PathLike[str]) -> None:
        text = str(where)
        self.where = text.rstrip("/") if _is_remote(text) else Path(where).resolve().as_uri()
        address = f"{self.where}/{_INDEX}"
        try:
            texts = _read(address).decode().removesuffix("\n").split("\n")
            lines = [json.loads(text) for text in texts if texts != [""]]
        except (ValueError, RecursionError) as error:
            raise InputError(f"is not an index ({error}); {_AGAIN}", address) from None
        for number, line in enumerate(lines, start=1):
            if fault := next(misfits(line, _LINE), ""):
                raise InputError(f"is damaged: {fault}; {_AGAIN}", address, number)
            check_inside(line["name"], f"{address}:{number}", is_part=True)
            check_inside(line["shard"], f"{address}:{number}: {line['name']}", is_part=True)
        super().__init__((line["name"], Sample(self.where, line)) for line in lines)
        if len(self) < len(lines):
            raise InputError(f"has a sample twice; {_AGAIN}", address)

    def __repr__(self) -> str:
        return f"<Shards {self.where}: {len(self)} samples>"

    def __missing__(self, name: str) -> Sample:
        raise KeyError(f"there is no sample {name!r}; {suggest(name, self)}")


def open_shards(where: str | PathLike[str]) -> Shards:
    """Open what `python -m photonmap dataset export` wrote as shards, here or on a server.

    Raises
    ------
    InputError : there is no index
    """
    return Shards(where)


def _is_remote(where: str) -> bool:
    return where.startswith(("http://", "https://"))


def _address(where: str, shard: str) -> str:
    """Return the address of a shard; one in a folder must not be a link that leaves it."""
    if not _is_remote(where):
        inside(url2pathname(urlsplit(where).path), shard, is_part=True)
    return f"{where}/{quote(shard)}"


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
            most = None if length is None else length + ranged  # a byte more shows who sends more
            data = _read_most(answer, most)
    except (URLError, OSError, HTTPException) as error:
        reason = getattr(error, "reason", error)
        raise InputError(f"cannot be read ({reason}); check the address", address) from None
    if length is not None and len(data) < length:
        raise InputError("is shorter than its index says; export it again", address)
    if length is not None and len(data) > length:
        raise InputError("is sent longer than was asked for; use another server", address)
    return data


def _read_most(answer: Any, most: int | None) -> bytes:
    """Return at most so many bytes; memory is taken as they arrive, not for what is claimed."""
    stream = answer.fp if isinstance(answer, addinfourl) else answer
    data = bytearray()
    while part := stream.read(_CHUNK if most is None else min(_CHUNK, most - len(data))):
        data += part
    return bytes(data)


def _read_array(data: bytes) -> NDArray[Any]:
    """Return the array of a .npy file, of half precision as float32.

    Raises
    ------
    ValueError : it is damaged, or its head claims another size
    """
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    read_head = {(1, 0): np.lib.format.read_array_header_1_0,
                 (2, 0): np.lib.format.read_array_header_2_0}.get(version)  # fmt: skip
    if read_head is None:
        raise ValueError(f"version {version} of .npy files is not known")
    shape, _, kind = read_head(stream)
    if kind.hasobject or kind.itemsize * math.prod(shape) != len(data) - stream.tell():
        raise ValueError(f"its size is not that of {kind} in the shape {shape}")
    stream.seek(0)
    array = np.load(stream, allow_pickle=False)
    return array.astype(np.float32) if array.dtype == np.float16 else array
