"""The text of OBJ and MTL files: comments, continued lines, encodings, line numbers."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError
from photonmap.spectra.tables import read_bytes

BLOCK = 1 << 22  # Bytes parsed at a time, so that temporary arrays do not grow with the file

_JOINED = 0x0B
_TEXT = bytes([9, 10, 11, 12, 13, *range(32, 127), *range(128, 256)])
_SPACES = bytes(32 if byte in (9, 11, 12) else byte for byte in range(256))
_NAMED = re.compile(rb"\s*(?:o|g|usemtl|newmtl|mtllib|map_\w+)\s")
_COMMENT = re.compile(rb"\s#")


@dataclass(frozen=True)
class Source:
    """A file as lines that start with a keyword, and their numbers in the file."""

    path: Path  # the file
    # a newline, then lines that end with one; comments are gone, indentation is moved to the line
    # before, and a newline behind a backslash is a vertical tab
    text: bytes

    def line_number(self, offset: int) -> int:
        """Return the line of the file, from 1, at a byte offset of `text`."""
        return self.text.count(b"\n", 0, offset) + self.text.count(_JOINED, 0, offset)

    def error(self, message: str, offset: int) -> InputError:
        """Return an error about what stands at a byte offset of `text`."""
        return InputError(message, self.path, self.line_number(offset))

    def line(self, offset: int) -> bytes:
        """Return the line that starts at a byte offset."""
        return self.text[offset : self.text.index(b"\n", offset)]

    def blocks(self) -> Iterator[tuple[int, int]]:
        """Yield ranges of whole lines, about `BLOCK` bytes each."""
        begin, size = 0, len(self.text)
        while begin < size:
            end = self.text.find(b"\n", min(begin + BLOCK, size) - 1) + 1
            yield begin, end
            begin = end

    def statements(self) -> Iterator[tuple[int, str, str]]:
        """Yield every line that is not blank as (offset, keyword, the rest)."""
        offset = 0
        while offset < len(self.text):
            line = self.line(offset)
            if line.strip():
                yield offset, *split_statement(line)
            offset += len(line) + 1


def read_source(path: str | PathLike[str], kind: str) -> Source:
    """Read a text file whole.

    Parameters
    ----------
    path : the file
    kind : what it should be, for messages: "OBJ" or "MTL"
    """
    path = Path(path)
    data = read_bytes(path)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode()
    if junk := data.translate(None, _TEXT):
        line = data.count(b"\n", 0, data.index(junk[0])) + 1
        message = f"is not a text file (byte 0x{junk[0]:02x}); save it as an {kind} file in UTF-8"
        raise InputError(message, path, line)
    return Source(path, _normalise(data))


def _normalise(data: bytes) -> bytes:
    """Bring any text to the form `Source.text` documents."""
    text = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    text = _strip_comments(text)
    if any(space in text for space in b"\t\v\f"):
        text = text.translate(_SPACES)
    if b"\\" in text:
        text = re.sub(rb"\\( *)\n", rb"\1\v", text)
        text = text if text.endswith(b"\n") else text + b"\n"
    if b"\n " in text or b"\n\v" in text:
        text = re.sub(rb"\n([ \v]+)", rb"\1\n", text)
    return text


def _strip_comments(text: bytes) -> bytes:
    """Remove comments and put a newline at either end.

    A # inside a name, such as Material_#25, does not begin a comment.
    """
    kept: list[bytes | memoryview] = [b"\n"]
    begin, at = 0, text.find(b"#")
    while at >= 0:
        line, end = text.rfind(b"\n", begin, at) + 1, text.find(b"\n", at)
        end = len(text) if end < 0 else end
        if _NAMED.match(text, line, at):
            found = _COMMENT.search(text, line, end)
            at = found.start() if found else end
        kept.append(memoryview(text)[begin:at])
        begin, at = end, text.find(b"#", end)
    return b"".join([*kept, memoryview(text)[begin:], b"\n"])


def split_statement(line: bytes) -> tuple[str, str]:
    """Split a line at its keyword; the rest keeps its inner spaces."""
    keyword, _, rest = line.replace(b"\v", b" ").partition(b" ")
    return _decode(keyword), _decode(rest).strip()


def _decode(raw: bytes) -> str:
    """Read bytes as UTF-8, or as Latin-1 where they are not."""
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("latin-1")
