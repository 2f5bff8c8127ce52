"""Load a scene as nodes: parameters put in, other files included, references resolved."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from photonmap.io.readers.mitsuba_parts.context import Files
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.upgrade import is_old, upgraded
from photonmap.io.readers.mitsuba_parts.xml import DEEPEST, Element, parse_xml
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.spectra.tables import read_bytes

MOST_FILES = 1000
"""Files included, at most."""
LONGEST = 4096
"""Characters of an attribute with parameters put in, at most."""
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
class _Loader:
    """What is known while a scene is loaded.

    Parameters
    ----------
    files : finds included files
    parameters : values of `$name`
    named : nodes by their ids
    references : children that are yet to be replaced: their parents, and their numbers
    depth : of the files that are being included
    count : of the files included
    """

    files: Files
    parameters: dict[str, str] = field(default_factory=dict)
    named: dict[str, Node] = field(default_factory=dict)
    references: list[tuple[Node, int]] = field(default_factory=list)
    depth: int = 0
    count: int = 0


def load_nodes(path: Path, data: bytes, files: Files) -> Node:
    """Return the scene's node; references are resolved, so a node may have several parents.

    Raises
    ------
    InputError : a file is not XML or not a scene, an element is unknown, a parameter or an id is
        not defined, or files or nodes include each other without end
    """
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
    """Add the children of a file's root."""
    if "version" not in root.attributes:
        raise root.error('its version is missing; add version="3.0.0" for Mitsuba 3')
    old = is_old(root)
    for child in root.children:
        _add(loader, parent, child, old)


def _add(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    """Add an element to its parent, or do what it says."""
    filled = {name: _fill(loader, element, value) for name, value in element.attributes.items()}
    element = replace(element, attributes=filled)
    if old:
        element = upgraded(element)
    if element.tag in _ACTIONS:
        _ACTIONS[element.tag](loader, parent, element, old)
    elif element.tag not in (*_OBJECTS, *_PLAIN, "ref"):
        known = listed((*_OBJECTS, *_PLAIN), 30).replace("'", "")
        raise element.error(f"<{shown(element.tag)[1:-1]}> is not known; known are {known}")
    else:
        _add_node(loader, parent, element, old)


def _add_node(loader: _Loader, parent: Node, element: Element, old: bool) -> None:
    """Add an object, a parameter or a reference."""
    node = Node(element)
    parent.children.append((element.attributes.get("name", ""), node))
    if element.tag == "ref":
        loader.references.append((parent, len(parent.children) - 1))
    elif element.tag == "transform":
        element.children = [_step(loader, step, old) for step in element.children]
    else:
        _enter(loader, node)
        for child in element.children:
            _add(loader, node, child, old)


def _step(loader: _Loader, step: Element, old: bool) -> Element:
    filled = {name: _fill(loader, step, value) for name, value in step.attributes.items()}
    step = replace(step, attributes=filled)
    return upgraded(step) if old else step


def _enter(loader: _Loader, node: Node) -> None:
    """Enter a node under its id."""
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
        raise element.error(f"a text with parameters is longer than {LONGEST} letters; shorten it")
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
        _add(loader, parent, root, is_old(root))
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
