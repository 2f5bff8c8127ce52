"""Read XML as elements that know their lines; entities and document types are refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from photonmap.errors import InputError
from photonmap.runtime.wording import shown

DEEPEST = 100
"""Levels of elements within each other, at most."""


@dataclass(eq=False)
class Element:
    """An element; `line` is that of its opening tag in the file `path`."""

    tag: str
    attributes: Mapping[str, str]
    path: Path
    line: int
    children: list[Element] = field(default_factory=list)

    def error(self, message: str) -> InputError:
        """Return an error about this element."""
        return InputError(message, self.path, self.line)

    def place(self, file: Path) -> str:
        """Return its line, and its file where a message about `file` has to name it."""
        return f"line {self.line}" + f" of {self.path.name}" * (self.path != file)

    def attribute(self, name: str) -> str:
        """Return an attribute.

        Raises
        ------
        InputError : there is none of this name
        """
        if name not in self.attributes:
            raise self.error(f'<{shown(self.tag)[1:-1]}> lacks {name}; add {name}="..."')
        return self.attributes[name]


def parse_xml(path: Path, data: bytes) -> Element:
    """Return the root element.

    Raises
    ------
    InputError : the data are not well-formed, declare a document type, and with it entities, or
        nest more than 100 elements
    """
    parser = expat.ParserCreate()
    top = Element("", {}, path, 0)
    stack = [top]

    def error(message: str) -> InputError:
        return InputError(message, path, parser.CurrentLineNumber)

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            raise error(f"more than {DEEPEST} elements lie within each other; export it again")
        element = Element(tag, attributes, path, parser.CurrentLineNumber)
        stack[-1].children.append(element)
        stack.append(element)

    def refuse(*declared: object) -> None:
        raise error("<!DOCTYPE> is not read, because of the entities that it may hold; remove it")

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda tag: stack.pop()
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(_without_comments(data), True)
    except expat.ExpatError as broken:
        reason = expat.ErrorString(broken.code)
        raise InputError(f"is not XML ({reason}); export it again", path, broken.lineno) from None
    return top.children[0]


def _without_comments(data: bytes) -> bytes:
    """Blank comments, but for their line breaks: many files have comments with -- inside."""
    kept: list[bytes] = []
    begin = 0
    while (at := data.find(b"<!--", begin)) >= 0 and (end := data.find(b"-->", at + 4)) >= 0:
        kept += [data[begin:at], b"\n" * data.count(b"\n", at, end)]
        begin = end + 3
    return b"".join([*kept, data[begin:]])
