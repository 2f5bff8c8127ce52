"""WebDataset: tar files of samples, with an index by which single members are read."""

from __future__ import annotations

import hashlib
import io
import json
import tarfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from photonmap.dataset.files.reader import Image
from photonmap.dataset.publication.samples import Samples, key_of, members_of

INDEX, SHARDS = "index.jsonl", "shards.json"
FORMAT = "photonmap shards 1"


def write_shards(folder: Path, samples: Samples) -> None:
    """Write PART-000000.tar … for each split, index.jsonl and shards.json.

    A line of the index has the name, key, split and shard of a sample; its `offset` and `length`,
    bytes; and `members`, those of the contents of each file by its ending.

    Raises
    ------
    InputError : an image has no such array, or is damaged
    OSError : a file cannot be written
    """
    shards: list[dict[str, Any]] = []
    names, halves = list(samples.names), samples.halves()
    with (folder / INDEX).open("w", encoding="utf-8") as index:
        for part, images in samples.parts.items():
            writer = _Writer(folder, part, samples.most)
            for image in images:
                line = writer.add(image, members_of(image, names, halves))
                index.write(json.dumps(line, ensure_ascii=False) + "\n")
            writer.close()
            shards += [_describe(path, part) for path in writer.paths]
            samples.log(f"{part}: images {len(images)}, shards {len(writer.paths)}")
    head = {"format": FORMAT, "arrays": names, "halves": sorted(halves), "shards": shards}
    text = json.dumps(head, indent=2)
    (folder / SHARDS).write_text(text + "\n", encoding="utf-8")


class _Writer:
    """Writes samples to the shards of a split; begins another where one would be too large."""

    def __init__(self, folder: Path, part: str, most: float) -> None:
        self._folder, self._part, self._most = folder, part, most
        self._tar: tarfile.TarFile | None = None
        self.paths: list[Path] = []

    def add(self, image: Image, members: dict[str, bytes]) -> dict[str, Any]:
        """Write a sample; return its line of the index."""
        key = key_of(image)
        tar = self._open(_tar_size(members.values()))
        begin, places = tar.offset, {}
        for ending, data in members.items():
            info = tarfile.TarInfo(f"{key}.{ending}")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
            places[ending] = [tar.offset - _padded(len(data)), len(data)]
        return {
            "name": image.name,
            "key": key,
            "split": self._part,
            "shard": self.paths[-1].name,
            "offset": begin,
            "length": tar.offset - begin,
            "members": places,
        }

    def _open(self, more: int) -> tarfile.TarFile:
        """Return the shard that takes so many bytes more."""
        if self._tar is not None and self._tar.offset + more <= self._most:
            return self._tar
        self.close()
        path = self._folder / f"{self._part}-{len(self.paths):06}.tar"
        self.paths.append(path)
        self._tar = tarfile.open(path, "w", format=tarfile.GNU_FORMAT)  # noqa: SIM115
        return self._tar

    def close(self) -> None:
        """End the shard."""
        if self._tar is not None:
            self._tar.close()
            self._tar = None


def _padded(size: int) -> int:
    return -(-size // tarfile.BLOCKSIZE) * tarfile.BLOCKSIZE


def _tar_size(members: Iterable[bytes]) -> int:
    """Return the bytes of a sample and of what ends a tar file."""
    files = sum(tarfile.BLOCKSIZE + _padded(len(data)) for data in members)
    return files + 2 * tarfile.BLOCKSIZE


def _describe(path: Path, part: str) -> dict[str, Any]:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return {"name": path.name, "split": part, "bytes": path.stat().st_size, "sha256": digest}
