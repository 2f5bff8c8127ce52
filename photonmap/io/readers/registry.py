"""The readers by suffix. They are found by what they declare, and imported when one is used."""

from __future__ import annotations

import ast
import pkgutil
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from photonmap.errors import InputError
from photonmap.io import readers
from photonmap.runtime.bounds import naming_large

if TYPE_CHECKING:
    from photonmap.scene.scene import Scene

SCENE_SUFFIX = ".toml"
"""Of files that describe a scene around a mesh file; all other suffixes are those of meshes."""

MissingTextures = Literal["error", "grey"]
GREY = 0.5  # What replaces a missing texture
OR_WITHOUT = "; or render without it, by --missing-textures grey (missing_textures='grey')"
"""How errors about textures end that may be left out."""


@dataclass(frozen=True)
class ReadOptions:
    """What a user may choose about reading."""

    missing_textures: MissingTextures = "error"  # "grey": with a warning, they become grey

    def __post_init__(self) -> None:
        if self.missing_textures not in ("error", "grey"):
            choice = f"missing_textures {self.missing_textures!r}"
            raise InputError(f"{choice} is not a choice; give 'error' or 'grey'")


def extended(error: InputError, more: str) -> InputError:
    """Return an error with more behind its text, which names a file if it did."""
    longer = InputError(f"{error}{more}")
    longer.names_file = error.names_file
    return longer


Reader = Callable[[Path, ReadOptions], "Scene"]


def scene_suffixes() -> tuple[str, ...]:
    """Return the suffixes of all files that can be read, in lower case, sorted."""
    return tuple(sorted(_modules()))


def mesh_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that hold meshes: all but TOML, which names such a file."""
    return tuple(suffix for suffix in scene_suffixes() if suffix != SCENE_SUFFIX)


def find_reader(path: Path) -> Reader:
    """Return the function that reads files of this suffix, in any case."""
    module = _modules().get(path.suffix.lower())
    if module is None:
        known = ", ".join(scene_suffixes())
        raise InputError(f"is of an unknown kind; supported: {known}", path)
    reader: Reader = import_module(module).read
    return reader


def read_file(path: str | PathLike[str], options: ReadOptions | None = None) -> Scene:
    """Read one file with the reader of its suffix; `load_scene` adds what a TOML file describes."""
    path = Path(path)
    read = find_reader(path)
    try:
        with naming_large(path):
            return read(path, options or ReadOptions())
    except ValueError as error:
        if isinstance(error, InputError) and error.names_file:
            raise
        raise InputError(str(error), path, getattr(error, "lineno", None)) from error


@cache
def _modules() -> dict[str, str]:
    """Return the module that reads each suffix; two readers of one suffix are a mistake."""
    modules: dict[str, str] = {}
    for found in pkgutil.iter_modules(readers.__path__, f"{readers.__name__}."):
        for suffix in _declared_suffixes(found.name):
            if suffix in modules:
                raise ImportError(f"both {modules[suffix]} and {found.name} read {suffix}")
            modules[suffix] = found.name
    return modules


def _declared_suffixes(name: str) -> tuple[str, ...]:
    """Return a module's SUFFIXES without importing it; none where it declares none."""
    spec = find_spec(name)
    loader: Any = spec.loader if spec else None
    declared = re.search(r"^SUFFIXES = (.*)$", loader.get_source(name), re.MULTILINE)
    suffixes: tuple[str, ...] = ast.literal_eval(declared[1]) if declared else ()
    return suffixes
