"""The nodes of a scene: loaded with files included, parameters put in and references resolved."""

from __future__ import annotations

import os.path
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss, unused_name
from photonmap.io.readers.mitsuba_parts.xml import DEEPEST, Element, parse_xml, read_transform
from photonmap.io.readers.registry import MissingTextures
from photonmap.runtime.named_files import is_below, outside
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.parameters import Vector
from photonmap.spectra.tables import read_bytes

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


@dataclass(eq=False)
class Node:
    """An object of a scene, or a parameter of one."""

    element: Element  # where it is described
    # its parameters and parts, each with the name under which the node knows it, or ""
    children: list[tuple[str, Node]] = field(default_factory=list)
    read: set[str] = field(default_factory=set)  # names of the parameters that were asked for

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

    def label(self, file: Path) -> str:
        """Return what it is called in warnings about a file, which may include its own."""
        return self.id or f"{self.type or self.tag} in {self.element.place(file)}"

    def error(self, message: str) -> InputError:
        """Return an error about this node."""
        return self.element.error(message)

    def unknown(self, known: Iterable[str]) -> InputError:
        """Return the error that its type is none of those that are known."""
        article = "an" if self.tag[0] in "aeiou" else "a"
        problem = f"{article} {self.tag} of type {shown(self.type)} is not simulated"
        return self.error(f"{problem}; give one of {listed(known, 20)}")

    def find(self, name: str) -> Node | None:
        """Return the parameter of a name, the last if there are several; None if there is none."""
        self.read.add(name)
        return next((child for known, child in reversed(self.children) if known == name), None)

    def parts(self, tag: str) -> list[Node]:
        """Return all children of a tag."""
        self.read.update(name for name, child in self.children if child.tag == tag)
        return [child for _, child in self.children if child.tag == tag]

    def unread(self) -> Iterator[str]:
        """Yield names, or tags, of children that nothing asked for."""
        for name, child in self.children:
            if name not in self.read:
                yield name or child.tag

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

    def transform(self, name: str = "to_world") -> NDArray[np.float64]:
        """Return a 4×4 matrix, the identity if it is not given."""
        found = self.find(name)
        return np.eye(4) if found is None else read_transform(found.element)


@dataclass
class Files:
    """Finds files by the names that a scene gives them."""

    scene: Path  # the file of the scene, in whose folder files are looked for
    allowed: Path  # the folder outside of which nothing is opened
    # further ones, in which `<path>` has files looked up
    folders: list[Path] = field(default_factory=list)

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


@dataclass
class Context:
    """What all parts of the reader of a scene share."""

    files: Files  # finds the files that it names
    missing_textures: MissingTextures  # what becomes of an image that cannot be read
    losses: Losses  # takes what is not simulated
    # those in use, of meshes, and of materials, lights and cameras
    names: dict[str, set[str]] = field(default_factory=dict)

    def lose(self, what: str, node: Node) -> None:
        """Note what is not simulated of a node."""
        note_loss(self.losses, what, node.label(self.files.scene))

    def lose_unread(self, node: Node) -> None:
        """Note the parameters that nothing asked for."""
        for name in node.unread():
            self.lose(f"{node.tag} parameter {name}", node)

    def name(self, kind: str, node: Node) -> str:
        """Return a name that no other of this kind has: the id, or else the type."""
        used = self.names.setdefault(kind, set())
        return unused_name(node.id or node.type or node.tag, len(used) + 1, used)


def _is_old(root: Element) -> bool:
    """Return whether a file's root has a version below 2."""
    version = root.attributes.get("version", "3.0.0")
    major = version.partition(".")[0]
    if not (major.isascii() and major.isdigit()):
        raise root.error(f'{shown(version)} is not a version of Mitsuba; write version="3.0.0"')
    return int(major[:9]) < 2


def _upgraded(element: Element) -> Element:
    """Return an element with the names of Mitsuba 3: `to_world` for `toWorld`."""
    attributes = dict(element.attributes)
    if "name" in attributes and element.tag != "default":
        attributes["name"] = _CAMEL.sub(lambda word: f"_{word[0].lower()}", attributes["name"])
    return replace(element, tag=_TAGS.get(element.tag, element.tag), attributes=attributes)


@dataclass
class _Loader:
    """What is known while a scene is loaded."""

    files: Files  # finds included files
    parameters: dict[str, str] = field(default_factory=dict)  # values of `$name`
    named: dict[str, Node] = field(default_factory=dict)  # nodes by their ids
    # children that are yet to be replaced: their parents, and their numbers
    references: list[tuple[Node, int]] = field(default_factory=list)
    depth: int = 0  # of the files that are being included
    count: int = 0  # of the files included


def load_nodes(path: Path, data: bytes, files: Files) -> Node:
    """Return the scene's node; references are resolved, so a node may have several parents."""
    loader = _Loader(files)
    root = parse_xml(path, data)
    if root.tag != "scene":
        raise root.error(f"<{shown(root.tag)[1:-1]}> is not a scene of Mitsuba; name another file")
    scene = Node(root)
    _add_all(loader, scene, root)
    for parent, index in loader.references:
        name, reference = parent.children[index]
        wanted = reference.element.attribute("id")
        if wanted not in loader.named:
            remedy = suggest(wanted, loader.named)
            raise reference.error(f"nothing has the id {shown(wanted)}; {remedy}")
        parent.children[index] = name, loader.named[wanted]
    _check_depth(scene)
    return scene


def _add_all(loader: _Loader, parent: Node, root: Element) -> None:
    if "version" not in root.attributes:
        raise root.error('its version is missing; add version="3.0.0" for Mitsuba 3')
    old = _is_old(root)
    for child in root.children:
        _add(loader, parent, child, old)


def _add(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    """Add an element to its parent, or do what it says."""
    element = _filled(loader, element, old)
    if element.tag in _ACTIONS:
        _ACTIONS[element.tag](loader, parent, element, old)
    elif element.tag not in (*_OBJECTS, *_PLAIN, "ref"):
        known = listed((*_OBJECTS, *_PLAIN), 30).replace("'", "")
        raise element.error(f"<{shown(element.tag)[1:-1]}> is not known; known are {known}")
    else:
        _add_node(loader, parent, element, old)


def _add_node(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    node = Node(element)
    parent.children.append((element.attributes.get("name", ""), node))
    if element.tag == "ref":
        loader.references.append((parent, len(parent.children) - 1))
    elif element.tag == "transform":
        element.children = [_filled(loader, step, old) for step in element.children]
    else:
        _enter(loader, node)
        for child in element.children:
            _add(loader, node, child, old)


def _filled(loader: _Loader, element: Element, old: bool) -> Element:
    """Return an element with parameters put in and with the names of Mitsuba 3."""
    filled = {name: _fill(loader, element, value) for name, value in element.attributes.items()}
    element = replace(element, attributes=filled)
    return _upgraded(element) if old else element


def _enter(loader: _Loader, node: Node) -> None:
    if node.id in loader.named:
        place = loader.named[node.id].element.place(node.element.path)
        raise node.error(f"the id {shown(node.id)} is that of {place} too; change one of them")
    if node.id:
        loader.named[node.id] = node


def _fill(loader: _Loader, element: Element, text: str) -> str:
    """Put in the values of parameters."""

    def value(found: re.Match[str]) -> str:
        # A name may be followed by letters that do not belong to it: the longest one counts.
        for end in range(len(found[1]), 0, -1):
            if found[1][:end] in loader.parameters:
                return loader.parameters[found[1][:end]] + found[1][end:]
        raise element.error(_without_value(loader, found[1]))

    if "$" not in text:
        return text
    filled = _PARAMETER.sub(value, text).replace("\\$", "$")
    if len(filled) > LONGEST:
        raise element.error(
            f"with its parameters put in, a text is longer than {LONGEST} letters; shorten it"
        )
    return filled


def _without_value(loader: _Loader, name: str) -> str:
    """Return what to do about a parameter that has no value: which there are, and how to add it."""
    remedy = f'add <default name="{name}" value="..."/>'
    if loader.parameters:
        meant, known = suggest(name, loader.parameters), listed(loader.parameters)
        others = f" Defined are {known}" if "?" in meant else ""
        remedy = f"{meant}{others}; or {remedy}"
    return f"${name} has no value; {remedy}"


def _default(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    loader.parameters.setdefault(element.attribute("name"), element.attribute("value"))


def _alias(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    known, name = element.attribute("id"), element.attribute("as")
    if known not in loader.named:
        raise element.error(f"nothing has the id {shown(known)}; {suggest(known, loader.named)}")
    if name in loader.named:
        raise element.error(f"the id {shown(name)} is used already; choose another")
    loader.named[name] = loader.named[known]


def _path(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    """Look files up in a further folder."""
    files, name = loader.files, element.attribute("value")
    files.folders.insert(0, files.inside(element, element.path.parent, name))


def _include(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    """Add what another file describes: an object, or all of a scene."""
    path = loader.files.find(element, element.attribute("filename"))
    loader.count += 1
    loader.depth += 1
    if loader.depth > DEEPEST or loader.count > MOST_FILES:
        raise element.error("files include each other without end; correct the name of this one")
    root = parse_xml(path, read_bytes(path))
    if root.tag == "scene":
        _add_all(loader, parent, root)
    else:
        if "name" in element.attributes:
            root.attributes = {**root.attributes, "name": element.attributes["name"]}
        _add(loader, parent, root, _is_old(root))
    loader.depth -= 1


Action = Callable[[_Loader, Node, Element, bool], None]
_ACTIONS: Mapping[str, Action] = {
    "default": _default,
    "alias": _alias,
    "path": _path,
    "include": _include,
}


def _check_depth(scene: Node) -> None:
    """Refuse nodes that refer to themselves, or nest too deeply."""
    done: set[int] = set()

    def visit(node: Node, depth: int) -> None:
        if depth > DEEPEST:
            raise node.error(f"refers to itself, or nests deeper than {DEEPEST}; correct its refs")
        if id(node) not in done:
            for _, child in node.children:
                visit(child, depth + 1)
            done.add(id(node))

    visit(scene, 0)
