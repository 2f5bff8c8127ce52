"""The lines of OBJ and MTL files; those of OBJ as arrays, whole blocks of numbers at once."""

from __future__ import annotations

import codecs
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, warn
from photonmap.io.readers.decoding import Ints, begins, decode_colors, parse_floats, parse_integers
from photonmap.io.readers.meshes import LARGEST_FACE
from photonmap.runtime.wording import shown
from photonmap.scene.mesh import LARGEST_COORDINATE
from photonmap.spectra.curves import Floats
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
        return int(np.searchsorted(self._ends, offset))

    @cached_property
    def _ends(self) -> Ints:
        """Where the lines of the file end, whose numbers may be asked for often."""
        text = np.frombuffer(self.text, np.uint8)
        return np.flatnonzero((text == _NEWLINE) | (text == _JOINED))

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


def read_source(path: Path, kind: str) -> Source:
    """Read a text file whole.

    kind : what it should be, for messages: "OBJ" or "MTL"
    """
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


_SPACE, _NEWLINE, _SLASH = b" \n/"
_OUTSIDE = np.iinfo(np.int32).max
_IN_FACES = np.isin(np.arange(256), list(b"0123456789+-/ \v\n"))
_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_CORNER = re.compile(rb"[+-]?\d+(/([+-]?\d+)?){0,2}")
_WEIGHTED = "v with a weight, or with more than an opaque colour"
_OPAQUE = (1.0, 255.0)
_STATES = ("o", "g", "s", "usemtl", "mtllib")


@dataclass(frozen=True)
class _Table:
    """A kind of line with numbers: its keyword, its name, and how many numbers it has.

    A line of `most` numbers or more has a colour behind the first `width`.
    """

    keyword: bytes
    name: str
    least: int
    width: int
    most: int


_TABLES = (
    _Table(b"v", "vertex", 3, 3, 6),
    _Table(b"vt", "texture coordinate", 1, 2, 2),
    _Table(b"vn", "normal", 3, 3, 3),
)


@dataclass(frozen=True)
class ObjLines:
    """What the lines of an OBJ file say, in file order."""

    vertices: Floats  # (V, 3), (T, 2), (N, 3) float64
    uv: Floats
    normals: Floats
    colors: Floats | None  # (V, 3) linear, NaN where there is none
    corners: NDArray[np.int32]  # (C, 3) vertex, uv and normal, from 1; 0 for none
    sizes: Ints  # (F,) int64, corners of each face
    offsets: Ints  # (F,) int64, where each face stands in the source
    states: list[tuple[int, str, str]]  # o, g, s, usemtl, mtllib: (offset, keyword, name)
    others: Mapping[str, int]  # the number of lines of every other keyword


@dataclass(frozen=True)
class _Lines:
    """The lines of one kind in a block, their keywords blanked."""

    text: NDArray[np.uint8]  # (B,) uint8
    starts: Ints  # (L,) where each line starts in `text`
    offsets: Ints  # (L,) where it starts in the source

    def count(self, positions: Ints) -> Ints:
        """Count ascending positions in `text` by line."""
        return np.diff(np.searchsorted(positions, np.append(self.starts, len(self.text))))


def parse_lines(source: Source) -> ObjLines:
    """Parse every line."""
    tables: list[list[Floats]] = [[], [], []]
    faces: list[tuple[NDArray[Any], ...]] = []
    states: list[tuple[int, str, str]] = []
    others: Counter[str] = Counter()
    known = np.zeros(3, np.int64)
    for begin, end in source.blocks():
        lines, rest = _sort_block(source, begin, end)
        for table, kind in zip(tables, _TABLES, strict=True):
            table.append(_parse_table(source, lines[kind.keyword], kind, others))
        before = [lines[kind.keyword].offsets for kind in _TABLES]
        faces.append(_parse_faces(source, lines[b"f"], before, known))
        if small := len(lines[b"f"].starts) - len(faces[-1][1]):
            others["f of fewer than three corners"] += small
        known += [len(table[-1]) for table in tables]
        for offset in rest:
            keyword, name = split_statement(source.line(offset))
            if keyword in _STATES:
                states.append((offset, keyword, name))
            else:
                others[keyword] += 1
    vertices, colors = _split_colors(source.path, tables[0])
    uv, normals = (np.concatenate(table) for table in tables[1:])
    corners, sizes, offsets = (np.concatenate(part) for part in zip(*faces, strict=True))
    obj = ObjLines(vertices, uv, normals, colors, corners, sizes, offsets, states, others)
    _check_indices(source, obj)
    return obj


def _sort_block(source: Source, begin: int, end: int) -> tuple[dict[bytes, _Lines], list[int]]:
    """Sort the lines of a block by keyword; return also the offsets of those without numbers."""
    block = np.frombuffer(source.text, np.uint8, end - begin, begin)
    ends = np.flatnonzero(block == _NEWLINE) + 1
    starts = np.append(0, ends[:-1])
    first, second, third = (block[np.minimum(starts + i, len(block) - 1)] for i in range(3))
    rest = first > _SPACE
    lines = {}
    for keyword in (b"f", *(kind.keyword for kind in _TABLES)):
        chosen = first == keyword[0]
        if len(keyword) == 1:
            chosen &= second <= _SPACE
        else:
            chosen &= (second == keyword[1]) & (third <= _SPACE)
        rest &= ~chosen
        lengths = (ends - starts)[chosen]
        text = block[np.repeat(chosen, ends - starts)]
        begins_at = np.cumsum(lengths) - lengths
        for i in range(len(keyword)):
            text[begins_at + i] = _SPACE
        lines[keyword] = _Lines(text, begins_at, starts[chosen] + begin)
    return lines, (starts[rest] + begin).tolist()


def _parse_table(source: Source, lines: _Lines, kind: _Table, others: Counter[str]) -> Floats:
    """Parse vertices, normals or texture coordinates, in rows of `kind.width` numbers.

    Where a line has `kind.most`, rows have so many, NaN in lines with fewer. Vertices with weights
    other than 1, and with more behind their colour than that it is opaque, count among others.
    """
    if not len(lines.starts):
        return np.zeros((0, kind.width))
    counts = lines.count(begins(lines.text > _SPACE))
    values = parse_floats(lines.text)
    if values is None or counts.min() < kind.least:
        raise _table_error(source, lines, kind)
    width = kind.most if counts.max() >= kind.most else kind.width
    if (counts == width).all():
        table = values.reshape(-1, width)
    else:
        table = np.zeros((len(counts), width))
        firsts = np.cumsum(counts) - counts
        for column in range(width):
            has = counts > column
            table[has, column] = values[firsts[has] + column]
        table[counts < kind.most, kind.width :] = np.nan
        if kind.most > kind.width:
            weighted = np.flatnonzero((counts > kind.width) & (counts < kind.most))
            more = np.flatnonzero(counts > kind.most)
            odd = np.count_nonzero(values[firsts[weighted] + kind.width] != 1.0)
            odd += np.count_nonzero(~np.isin(values[firsts[more] + kind.most], _OPAQUE))
            odd += np.count_nonzero(counts[more] > kind.most + 1)
            others.update([_WEIGHTED] * odd)
    if not (np.abs(table[:, : kind.width]) <= LARGEST_COORDINATE).all():
        raise _table_error(source, lines, kind)
    return table


def _split_colors(path: Path, tables: list[Floats]) -> tuple[Floats, Floats | None]:
    """Return the coordinates of vertices, and their colours as `ObjLines` has them."""
    vertices = np.concatenate([table[:, :3] for table in tables])
    if all(table.shape[1] == 3 for table in tables):
        return vertices, None
    none = np.full((1, 3), np.nan)
    colors = [
        table[:, 3:] if table.shape[1] > 3 else none.repeat(len(table), axis=0) for table in tables
    ]

    def note(what: str) -> None:
        warn(f"{path}: not simulated: {what}")

    return vertices, decode_colors(np.concatenate(colors), note, "vertices")


def _table_error(source: Source, lines: _Lines, kind: _Table) -> InputError:
    for offset in lines.offsets.tolist():
        words = source.line(offset).split()[1:]
        if len(words) < kind.least:
            message = f"{kind.name} of {len(words)} numbers; write {kind.least} or more"
            return source.error(message, offset)
        for column, word in enumerate(words):
            value = float(word) if _NUMBER.fullmatch(word) else np.nan
            if np.isnan(value) or (column < kind.width and abs(value) > LARGEST_COORDINATE):
                message = f"{kind.name} has {shown(word.decode('latin-1'))}; write finite decimals"
                return source.error(f"{message} up to {LARGEST_COORDINATE:g}", offset)
    return InputError(f"a {kind.name} is malformed; write finite decimals", source.path)


def _parse_faces(
    source: Source, lines: _Lines, before: list[Ints], known: Ints
) -> tuple[NDArray[np.int32], Ints, Ints]:
    """Parse faces as (corners, sizes, offsets), see `ObjLines`; those of two corners are left out.

    source, lines : the text
    before : offsets of the vertices, uv and normals of the block, for relative indices
    known : (3,) how many of them there were before the block
    """
    if not len(lines.starts):
        return np.zeros((0, 3), np.int32), lines.starts, lines.offsets
    solid, slash = lines.text > _SPACE, lines.text == _SLASH
    numbers = begins(solid & ~slash)
    values = parse_integers(np.where(slash, np.uint8(_SPACE), lines.text))
    leads = ~solid[numbers - 1]
    sizes = lines.count(numbers[leads])
    if (
        not _IN_FACES[lines.text].all()
        or len(values) != len(numbers)
        or np.count_nonzero(leads) != len(begins(solid))
        or np.add.reduceat(slash, numbers[leads], dtype=np.int32).max(initial=0) > 2
        or sizes.max() > LARGEST_FACE
    ):
        raise _face_error(source, lines)
    corner_of = np.cumsum(leads) - 1
    columns = _columns(slash, numbers, leads)
    relative = np.flatnonzero(values < 0)
    if len(relative):
        rows = np.repeat(np.arange(len(sizes)), sizes)[corner_of[relative]]
        counts = np.stack([np.searchsorted(b, lines.offsets) for b in before], 1) + known
        values[relative] += counts[rows, columns[relative]] + 1
    values[(values <= 0) | (values > _OUTSIDE)] = _OUTSIDE
    corners = np.zeros((sizes.sum(), 3), np.int32)
    corners[corner_of, columns] = values
    large = sizes >= 3
    if not large.all():
        return corners[np.repeat(large, sizes)], sizes[large], lines.offsets[large]
    return corners, sizes, lines.offsets


def _columns(slash: NDArray[np.bool_], numbers: Ints, leads: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Count the slashes before each number of a corner, two at most.

    slash : (B,) whether a byte is a slash
    numbers : (M,) where the numbers begin
    leads : (M,) whether a number is the first of its corner
    """
    follows = ~leads
    gaps = follows.astype(np.int8) + (follows & slash[numbers - 2])
    gaps[1:] += gaps[:-1] * follows[1:]
    return gaps


def _face_error(source: Source, lines: _Lines) -> InputError:
    for offset in lines.offsets.tolist():
        words = source.line(offset).split()[1:]
        for word in words:
            if not _CORNER.fullmatch(word):
                message = f"face corner {shown(word.decode('latin-1'))} is malformed"
                return source.error(f"{message}; write v, v/vt, v//vn or v/vt/vn", offset)
        if len(words) > LARGEST_FACE:
            return source.error(f"face of {len(words)} corners; divide it", offset)
    return InputError("a face is malformed; write v, v/vt, v//vn or v/vt/vn", source.path)


def _check_indices(source: Source, obj: ObjLines) -> None:
    known = [len(obj.vertices), len(obj.uv), len(obj.normals)]
    outside = np.flatnonzero((obj.corners > known).any(1))
    if len(outside):
        ends = np.cumsum(obj.sizes)
        face = np.searchsorted(ends, outside[0], "right")
        offset = int(obj.offsets[face])
        words = source.line(offset).split()[1:]
        word = words[outside[0] - (ends[face] - obj.sizes[face])].decode()
        counts = f"{known[0]} vertices, {known[1]} texture coordinates, {known[2]} normals"
        remedy = "count from 1, or back from this line with -1"
        message = f"face corner {shown(word)} is outside the file's {counts}; {remedy}"
        raise source.error(message, offset)
