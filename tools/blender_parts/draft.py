"""An export under way: the sections of its TOML file, what is lost, and what is to be undone."""

import json
import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import bpy
import numpy as np


class Draft:
    """An export of the current scene to files of a name without suffix."""

    def __init__(self, out: Path) -> None:
        self.scene = bpy.context.scene
        self.out = out
        self.sections: list[str] = []
        self.lost: dict[str, list[str]] = {}
        self.undo: list[Callable[[], Any]] = []

    def lose(self, what: str, owner: str) -> None:
        """Note what is not exported, and whose it is."""
        owners = self.lost.setdefault(what, [])
        if owner not in owners:
            owners.append(owner)

    def section(self, header: str, **values: Any) -> None:
        """Add a section of the TOML file; values that are None are left out."""
        lines = [f"{key} = {toml(value)}" for key, value in values.items() if value is not None]
        self.sections.append("\n".join([header, *lines]))

    def light(self, kind: str, name: str, **values: Any) -> None:
        """Add the section of a light."""
        self.section("[[light]]", type=kind, name=name, **values)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, pixels."""
        render = self.scene.render
        part = render.resolution_percentage / 100.0
        return int(render.resolution_x * part), int(render.resolution_y * part)

    def restore(self) -> None:
        """Undo what the export changed in the scene, the last first."""
        while self.undo:
            with suppress(ReferenceError):  # removed along with something else
                self.undo.pop()()


def toml(value: Any) -> str:
    """Return a value as TOML writes it; floats to 9 digits, as Blender's are of 24 bits."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {toml(each)}' for key, each in value.items())} }}"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(float(f"{value:.9g}"))
    return f"[{', '.join(map(toml, np.asarray(value).tolist()))}]"


def turn(vector: Any) -> list[float]:
    """Return a vector of Blender, whose z is up, with y up."""
    x, y, z = vector
    return [x, z, -y]


def value_of(node: Any, name: str) -> Any:
    """Return the number of an input; None where a node is linked to it, 0 where there is none."""
    socket = node.inputs.get(name)
    if socket is None:
        return 0.0
    return None if socket.is_linked else socket.default_value


def color_of(node: Any, name: str) -> np.ndarray:
    """Return the colour of an input, (3,), linear."""
    return np.array(node.inputs[name].default_value[:3])


def output_of(tree: Any, kind: str = "OUTPUT_MATERIAL") -> Any:
    """Return the active output node of a tree; None if there is none."""
    found = [node for node in (tree.nodes if tree else ()) if node.type == kind]
    return next((node for node in found if node.is_active_output), None)


def upstream(socket: Any) -> set[Any]:
    """Return all nodes that lead to an input."""
    found: set[Any] = set()
    below = [link.from_node for link in socket.links]
    while below:
        node = below.pop()
        if node not in found:
            found.add(node)
            below += [link.from_node for each in node.inputs for link in each.links]
    return found


def is_flat(number: float, wanted: float, within: float = 1e-5) -> bool:
    """Return whether two numbers are the same but for rounding."""
    return math.isclose(number, wanted, rel_tol=within, abs_tol=within)
