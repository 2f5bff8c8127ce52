"""The nodes of a scene: their parameters by name, each of which is asked for or else reported."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.mitsuba_parts.transforms import read_transform
from photonmap.io.readers.mitsuba_parts.values import number_of, vector_of
from photonmap.io.readers.mitsuba_parts.xml import Element
from photonmap.runtime.wording import listed, shown
from photonmap.scene.vectors import Vector


@dataclass(eq=False)
class Node:
    """An object of a scene, or a parameter of one.

    Parameters
    ----------
    element : where it is described
    children : its parameters and parts, each with the name under which the node knows it, or ""
    read : names of the parameters that were asked for
    """

    element: Element
    children: list[tuple[str, Node]] = field(default_factory=list)
    read: set[str] = field(default_factory=set)

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
        return number_of(found.element, found.element.attribute("value"))

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
        return default if found is None else vector_of(found.element, 0.0)

    def transform(self, name: str = "to_world") -> NDArray[np.float64]:
        """Return a 4×4 matrix, the identity if it is not given."""
        found = self.find(name)
        return np.eye(4) if found is None else read_transform(found.element)
