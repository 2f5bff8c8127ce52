"""Read XML as elements that know their lines, and the numbers and transformations they hold."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.surfaces import side_axes
from photonmap.runtime.wording import shown
from photonmap.scene.parameters import Vector, unit

DEEPEST = 100  # Levels of elements within each other, at most
_SEPARATORS = re.compile(r"[\s,]+")
Matrix = NDArray[np.float64]
_FLATTEST = 1e-30  # Least determinant of the linear part


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
        """Return an attribute."""
        if name not in self.attributes:
            raise self.error(f'<{shown(self.tag)[1:-1]}> lacks {name}; add {name}="..."')
        return self.attributes[name]

    def number(self, text: str) -> float:
        """Return a finite number."""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or "_" in text:
            raise self.error(f"{shown(text)} is not a number; correct it")
        return value

    def numbers(self, text: str) -> list[float]:
        """Return numbers separated by spaces or commas."""
        return [self.number(word) for word in _SEPARATORS.split(text.strip()) if word]

    def triple(self, name: str) -> Vector:
        """Return the three numbers of an attribute; one counts three times."""
        values = self.numbers(self.attribute(name))
        if len(values) not in (1, 3):
            text = shown(self.attributes[name])
            raise self.error(f"{name} {text} is not one number or three; correct it")
        x, y, z = values * (3 // len(values))
        return x, y, z

    def vector(self, default: float) -> Vector:
        """Return x, y and z, or the value: one number for all of them, or three."""
        if "value" in self.attributes:
            return self.triple("value")
        x, y, z = (self.number(self.attributes.get(axis, str(default))) for axis in "xyz")
        return x, y, z


def parse_xml(path: Path, data: bytes) -> Element:
    """Return the root element."""
    parser = expat.ParserCreate()
    top = Element("", {}, path, 0)
    stack = [top]

    def error(message: str) -> InputError:
        return InputError(message, path, parser.CurrentLineNumber)

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            raise error(f"more than {DEEPEST} elements are nested; export it again")
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


def read_transform(element: Element) -> Matrix:
    """Return the 4×4 matrix of a `<transform>`, whose steps are applied in their order."""
    matrix = np.eye(4)
    for step in element.children:
        if step.tag not in _STEPS:
            known = ", ".join(_STEPS)
            raise step.error(f"<{shown(step.tag)[1:-1]}> is not a transformation; give {known}")
        with np.errstate(over="ignore", invalid="ignore"):
            matrix = _STEPS[step.tag](step) @ matrix
    if not np.isfinite(matrix).all() or (matrix[3] != [0.0, 0.0, 0.0, 1.0]).any():
        raise element.error("the transformation is not affine; correct its matrix")
    if abs(np.linalg.det(matrix[:3, :3])) < _FLATTEST:
        raise element.error("the transformation flattens everything; correct its scale")
    return matrix


def _translate(step: Element) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = step.vector(0.0)
    return matrix


def _scale(step: Element) -> Matrix:
    return np.diag([*step.vector(1.0), 1.0])


def _rotate(step: Element) -> Matrix:
    """Return a turn about an axis by degrees: Rodrigues' formula."""
    axis = unit(np.array(step.vector(0.0)))
    if axis is None:
        raise step.error("the axis of a rotation is 0; give its x, y or z")
    angle = math.radians(step.number(step.attribute("angle")))
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return matrix


def _look_at(step: Element) -> Matrix:
    """Return a frame at the origin whose z leads to the target, and whose y is nearest to up."""
    origin, target = np.array(step.triple("origin")), np.array(step.triple("target"))
    view = unit(target / 2 - origin / 2)
    if view is None:
        raise step.error("target and origin are the same; move one of them")
    up = np.array(step.triple("up")) if "up" in step.attributes else np.zeros(3)
    if not up.any():
        up, _ = side_axes(view)
    left = unit(np.cross(up, view))
    if left is None:
        raise step.error("up is parallel to the view; choose another direction")
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(view, left), view, origin], axis=1)
    return matrix


def _matrix(step: Element) -> Matrix:
    """Return a matrix, row by row: all 16 numbers, or the 9 of its linear part."""
    values = step.numbers(step.attribute("value"))
    if len(values) not in (9, 16):
        raise step.error(f"a matrix has {len(values)} numbers; give 9 or 16")
    size = 3 if len(values) == 9 else 4
    matrix = np.eye(4)
    matrix[:size, :size] = np.reshape(values, (size, size))
    return matrix


_STEPS: dict[str, Callable[[Element], Matrix]] = {
    "translate": _translate,
    "rotate": _rotate,
    "scale": _scale,
    "lookat": _look_at,
    "matrix": _matrix,
}
