"""The nodes of a scene in XML: files included, parameters put in and references resolved."""

from __future__ import annotations

import math
import os.path
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar
from xml.parsers import expat

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss, unused_name
from photonmap.io.readers.meshes import side_axes
from photonmap.io.readers.registry import MissingTextures
from photonmap.runtime.bounds import Budget
from photonmap.runtime.files import is_below, outside
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.parameters import Vector, unit
from photonmap.spectra.curves import Floats
from photonmap.spectra.tables import read_bytes

DEEPEST = 100  # Levels of elements within each other, at most
_SEPARATORS = re.compile(r"[\s,]+")
T = TypeVar("T")
_FLATTEST = 1e-30  # Least determinant of the linear part
_NEAR = 1e-3  # By how much the length of a unit vector may differ from 1


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


def read_transform(element: Element) -> Floats:
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


def _translate(step: Element) -> Floats:
    matrix = np.eye(4)
    matrix[:3, 3] = step.vector(0.0)
    return matrix


def _scale(step: Element) -> Floats:
    return np.diag([*step.vector(1.0), 1.0])


def _rotate(step: Element) -> Floats:
    """Return a turn about an axis by degrees: Rodrigues' formula."""
    axis = unit(np.array(step.vector(0.0)))
    if not axis.any():
        raise step.error("the axis of a rotation is 0; give its x, y or z")
    angle = math.radians(step.number(step.attribute("angle")))
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return matrix


def _is_distorted(step: Element) -> bool:
    """Return whether Mitsuba 2 and 3, which do not normalise axes, make no turn of a rotation."""
    if step.tag != "rotate":
        return False
    return not math.isclose(np.linalg.norm(step.vector(0.0)), 1.0, rel_tol=_NEAR)


def _look_at(step: Element) -> Floats:
    """Return a frame at the origin whose z leads to the target, and whose y is nearest to up."""
    origin, target = np.array(step.triple("origin")), np.array(step.triple("target"))
    view = unit(target / 2 - origin / 2)
    if not view.any():
        raise step.error("target and origin are the same; move one of them")
    up = np.array(step.triple("up")) if "up" in step.attributes else np.zeros(3)
    if not up.any():
        up, _ = side_axes(view)
    left = unit(np.cross(up, view))
    if not left.any():
        raise step.error("up is parallel to the view; choose another direction")
    matrix = np.eye(4)
    matrix[:3] = np.stack([left, np.cross(view, left), view, origin], axis=1)
    return matrix


def _matrix(step: Element) -> Floats:
    """Return a matrix, row by row: all 16 numbers, or the 9 of its linear part."""
    values = step.numbers(step.attribute("value"))
    if len(values) not in (9, 16):
        raise step.error(f"a matrix has {len(values)} numbers; give 9 or 16")
    size = 3 if len(values) == 9 else 4
    matrix = np.eye(4)
    matrix[:size, :size] = np.reshape(values, (size, size))
    return matrix


_STEPS: dict[str, Callable[[Element], Floats]] = {
    "translate": _translate,
    "rotate": _rotate,
    "scale": _scale,
    "lookat": _look_at,
    "matrix": _matrix,
}


_CAMEL = re.compile("(?<=[a-z])[A-Z]+")
_TAGS = {"lookAt": "lookat", "luminaire": "emitter", "camera": "sensor"}
MOST_FILES = 1000  # Files included, at most
LONGEST = 4096  # Characters of an attribute with parameters put in, at most
_PARAMETER = re.compile(r"(?<!\\)\$(\w+)")
_OBJECTS = (
    "scene", "shape", "bsdf", "emitter", "sensor", "film", "sampler",
    "rfilter", "integrator", "texture", "medium", "phase", "volume", "subsurface",
)  # fmt: skip
_PLAIN = (
    "float", "integer", "boolean", "string", "point", "vector", "rgb", "srgb", "spectrum",
    "blackbody", "transform",
)  # fmt: skip


@dataclass
class Context:
    """What all parts of the reader of a scene share; it finds files by the names given to them."""

    scene: Path  # the file of the scene, in whose folder files are looked for
    allowed: Path  # the folder outside of which nothing is opened
    missing_textures: MissingTextures  # what becomes of an image that cannot be read
    losses: Losses  # takes what is not simulated
    folders: list[Path] = field(default_factory=list)  # others, in which `<path>` has files sought
    names: dict[str, set[str]] = field(default_factory=dict)  # in use, by kind
    contents: dict[tuple[Any, Path], Any] = field(
        default_factory=dict
    )  # of files, by their readers

    @cached_property
    def budget(self) -> Budget:
        """What its shapes take: one in the file may be of many triangles, or shown often."""
        return Budget(self.scene)

    def find(self, element: Element, name: str) -> Path:
        """Return a file beside the one that names it, beside the scene, or in a further folder."""
        places = (element.path.parent, *self.folders, self.scene.parent)
        found = [self.inside(element, place, name) for place in places]
        for path in found:
            try:
                if path.is_file():
                    return path
            except ValueError:  # a null character
                break
        raise element.error(f"file {shown(name)} does not exist; correct its name")

    def inside(self, element: Element, folder: Path, name: str) -> Path:
        """Return what a name, perhaps with Windows' separators, means in a folder."""
        path = Path(os.path.normpath(folder / name.replace("\\", "/")))
        if not is_below(path, self.allowed):
            raise element.error(f"{shown(name)} {outside(self.allowed)}")
        return path


@dataclass(eq=False)
class Node:
    """An object of a scene, or a parameter of one."""

    element: Element  # where it is described
    context: Context  # what all parts of the reader of a scene share
    is_old: bool = False  # of a file of version 0.x
    children: list[tuple[str, Node]] = field(default_factory=list)  # each with its name here
    read: set[str] = field(default_factory=set)  # names of the parameters that were asked for
    known: dict[Any, Any] = field(default_factory=dict)  # what functions made of it, see `once`

    @property
    def tag(self) -> str:
        """Its element's tag: "shape"."""
        return self.element.tag

    @property
    def type(self) -> str:
        """Its plugin: "sphere"; "" for a plain parameter."""
        return self.element.attributes.get("type", "")

    @property
    def id(self) -> str:
        """The name by which others refer to it; "" if it has none."""
        return self.element.attributes.get("id", "")

    def lose(self, what: str) -> None:
        """Note what is not simulated of it; what has no id is called after its place."""
        place = self.element.place(self.context.scene)
        note_loss(self.context.losses, what, self.id or f"{self.type or self.tag} in {place}")

    def lose_unread(self) -> None:
        """Note the parameters that nothing asked for."""
        for name, child in self.children:
            if name not in self.read:
                self.lose(f"{self.tag} parameter {name or child.tag}")

    def unique_name(self, kind: str) -> str:
        """Return a name that no other of this kind has: the id, or else the type."""
        used = self.context.names.setdefault(kind, set())
        return unused_name(self.id or self.type or self.tag, len(used) + 1, used)

    def error(self, message: str) -> InputError:
        """Return an error about this node."""
        return self.element.error(message)

    def unknown(self, known: Iterable[str]) -> InputError:
        """Return the error that its type is none of those that are known."""
        article = "an" if self.tag[0] in "aeiou" else "a"
        problem = f"{article} {self.tag} of type {shown(self.type)} is not simulated"
        return self.error(f"{problem}; give one of {listed(known, 20)}")

    def find(self, name: str) -> Node | None:
        """Return the only parameter of a name; None if there is none."""
        self.read.add(name)
        return self._one(name, [child for known, child in self.children if known == name])

    def only(self, tag: str) -> Node | None:
        """Return the only child of a tag; None if there is none."""
        return self._one(tag, self.parts(tag))

    def _one(self, what: str, found: list[Node]) -> Node | None:
        if len(found) > 1:
            raise found[-1].error(f"{self.tag} has {len(found)} of {shown(what)}; keep one of them")
        return found[0] if found else None

    def parts(self, tag: str) -> list[Node]:
        """Return all children of a tag."""
        self.read.update(name for name, child in self.children if child.tag == tag)
        return [child for _, child in self.children if child.tag == tag]

    def file(self) -> Path:
        """Return the file that its parameter `filename` names."""
        return self.context.find(self.element, self.text("filename"))

    def read_file(self, read: Callable[[Path], T]) -> T:
        """Return what a reader makes of that file; it reads a file once, however many name it."""
        path, contents = self.file(), self.context.contents
        if (read, path) not in contents:
            contents[read, path] = read(path)
        found: T = contents[read, path]
        return found

    def text(self, name: str, default: str | None = None) -> str:
        """Return a text; without a default it is required."""
        found = self.find(name)
        if found is not None:
            return found.element.attribute("value")
        if default is None:
            raise self.error(f"{self.tag} {shown(self.type)} lacks {name}; add it")
        return default

    def number(self, name: str, default: float) -> float:
        """Return a finite number."""
        found = self.find(name)
        if found is None:
            return default
        return found.element.number(found.element.attribute("value"))

    def whole(self, name: str, default: int) -> int:
        """Return a whole number of at least 0."""
        value = self.number(name, default)
        if value % 1 or value < 0:
            raise self.error(f"{name} {value:g} is not a whole number from 0; correct it")
        return int(value)

    def flag(self, name: str, default: bool) -> bool:
        """Return true or false."""
        text = self.text(name, str(default)).lower()
        if text not in ("true", "false"):
            raise self.error(f"{name} {shown(text)} is neither true nor false; correct it")
        return text == "true"

    def vector(self, name: str, default: Vector) -> Vector:
        """Return three numbers, of a point or a vector."""
        found = self.find(name)
        return default if found is None else found.element.vector(0.0)

    def transform(self, name: str = "to_world") -> Floats:
        """Return a 4×4 matrix, the identity if it is not given."""
        found = self.find(name)
        if found is None:
            return np.eye(4)
        matrix = read_transform(found.element)
        if not found.is_old and any(map(_is_distorted, found.element.children)):
            self.lose("the distortion by a <rotate> about an axis that is not of unit length")
        return matrix


def once(read: Callable[[Node], T]) -> Callable[[Node], T]:
    """Return a function that reads each node once."""

    def known(node: Node) -> T:
        if read not in node.known:
            node.known[read] = read(node)
        found: T = node.known[read]
        return found

    return known


@dataclass
class _Loader:
    """What is known while a scene is loaded."""

    context: Context
    parameters: dict[str, str] = field(default_factory=dict)  # values of `$name`
    named: dict[str, Node] = field(default_factory=dict)  # nodes by their ids
    references: list[tuple[Node, int]] = field(default_factory=list)  # parents, and numbers
    depth: int = 0  # of the files that are being included
    count: int = 0  # of the files included

    def add_all(self, parent: Node, root: Element) -> None:
        if "version" not in root.attributes:
            raise root.error('its version is missing; add version="3.0.0" for Mitsuba 3')
        old = _is_old(root)
        for child in root.children:
            self.add(parent, child, old)

    def add(self, parent: Node, element: Element, old: bool) -> None:
        """Add an element to its parent, or do what it says."""
        element = self._filled(element, old)
        match element.tag:
            case "default":
                self.parameters.setdefault(element.attribute("name"), element.attribute("value"))
            case "alias":
                node, name = self.find(element), element.attribute("as")
                if name in self.named:
                    raise element.error(f"the id {shown(name)} is used already; choose another")
                self.named[name] = node
            case "path":
                context, name = self.context, element.attribute("value")
                context.folders.insert(0, context.inside(element, element.path.parent, name))
            case "include":
                self._include(parent, element)
            case tag if tag in (*_OBJECTS, *_PLAIN, "ref"):
                self._add_node(parent, element, old)
            case _:
                known = listed((*_OBJECTS, *_PLAIN), 30).replace("'", "")
                raise element.error(f"<{shown(element.tag)[1:-1]}> is not known; known are {known}")

    def _add_node(self, parent: Node, element: Element, old: bool) -> None:
        node = Node(element, self.context, old)
        parent.children.append((element.attributes.get("name", ""), node))
        if element.tag == "ref":
            self.references.append((parent, len(parent.children) - 1))
        elif element.tag == "transform":
            element.children = [self._filled(step, old) for step in element.children]
        else:
            if node.id in self.named:
                place = self.named[node.id].element.place(element.path)
                problem = f"the id {shown(node.id)} is that of {place} too; change one of them"
                raise node.error(problem)
            if node.id:
                self.named[node.id] = node
            for child in element.children:
                self.add(node, child, old)

    def _filled(self, element: Element, old: bool) -> Element:
        """Return an element with parameters put in and with the names of Mitsuba 3."""
        filled = {name: self._fill(element, text) for name, text in element.attributes.items()}
        if not old:
            return replace(element, attributes=filled)
        if "name" in filled and element.tag != "default":  # to_world for toWorld
            filled["name"] = _CAMEL.sub(lambda word: f"_{word[0].lower()}", filled["name"])
        return replace(element, tag=_TAGS.get(element.tag, element.tag), attributes=filled)

    def _fill(self, element: Element, text: str) -> str:

        def value(found: re.Match[str]) -> str:
            # A name may be followed by letters that do not belong to it: the longest one counts.
            for end in range(len(found[1]), 0, -1):
                if found[1][:end] in self.parameters:
                    return self.parameters[found[1][:end]] + found[1][end:]
            raise element.error(self._without_value(found[1]))

        if "$" not in text:
            return text
        filled = _PARAMETER.sub(value, text).replace("\\$", "$")
        if len(filled) > LONGEST:
            problem = f"with its parameters put in, a text is longer than {LONGEST} letters"
            raise element.error(f"{problem}; shorten it")
        return filled

    def _without_value(self, name: str) -> str:
        """Return what to do about a parameter without a value: which there are, how to add it."""
        remedy = f'add <default name="{name}" value="..."/>'
        if self.parameters:
            meant, known = suggest(name, self.parameters), listed(self.parameters)
            others = f" Defined are {known}" if "?" in meant else ""
            remedy = f"{meant}{others}; or {remedy}"
        return f"${name} has no value; {remedy}"

    def find(self, element: Element) -> Node:
        """Return the node whose id an element gives."""
        wanted = element.attribute("id")
        if wanted not in self.named:
            remedy = suggest(wanted, self.named)
            raise element.error(f"nothing has the id {shown(wanted)}; {remedy}")
        return self.named[wanted]

    def _include(self, parent: Node, element: Element) -> None:
        path = self.context.find(element, element.attribute("filename"))
        self.count += 1
        self.depth += 1
        if self.depth > DEEPEST or self.count > MOST_FILES:
            problem = "files include each other without end; correct the name of this one"
            raise element.error(problem)
        root = parse_xml(path, read_bytes(path))
        if root.tag == "scene":
            self.add_all(parent, root)
        else:
            if "name" in element.attributes:
                root.attributes = {**root.attributes, "name": element.attributes["name"]}
            self.add(parent, root, _is_old(root))
        self.depth -= 1


def _is_old(root: Element) -> bool:
    version = root.attributes.get("version", "3.0.0")
    major = version.partition(".")[0]
    if not (major.isascii() and major.isdigit()):
        raise root.error(f'{shown(version)} is not a version of Mitsuba; write version="3.0.0"')
    return int(major[:9]) < 2


def load_nodes(path: Path, data: bytes, context: Context) -> Node:
    """Return the scene's node; references are resolved, so a node may have several parents."""
    loader = _Loader(context)
    root = parse_xml(path, data)
    if root.tag != "scene":
        raise root.error(f"<{shown(root.tag)[1:-1]}> is not a scene of Mitsuba; name another file")
    scene = Node(root, context)
    loader.add_all(scene, root)
    for parent, index in loader.references:
        name, reference = parent.children[index]
        parent.children[index] = name, loader.find(reference.element)
    _check_depth(scene)
    return scene


def _check_depth(scene: Node) -> None:
    done: set[int] = set()

    def visit(node: Node, depth: int) -> None:
        if depth > DEEPEST:
            raise node.error(f"refers to itself, or nests deeper than {DEEPEST}; correct its refs")
        if id(node) not in done:
            for _, child in node.children:
                visit(child, depth + 1)
            done.add(id(node))

    visit(scene, 0)
