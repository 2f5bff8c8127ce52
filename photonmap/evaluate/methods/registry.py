"""All methods by name: those of this folder, and those that installed packages add.

A package adds a method by an entry point of the group `photonmap.methods`, whose name is the
method's and which refers to a `photonmap.evaluate.methods.method.Method`.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from photonmap.errors import InputError
from photonmap.evaluate.methods.method import Method
from photonmap.runtime.wording import suggest

GROUP = "photonmap.methods"
"""The group of entry points."""
BUILT_IN = (
    "constant-reflectance",
    "constant-shading",
    "retinex",
    "color-retinex",
    "weiss",
    "shen",
    "gehler",
    "serra",
    "sirfs",
    "bell",
    "grey-world",
    "white-patch",
    "shades-of-grey",
    "grey-edge",
)
"""Methods of this folder; each has the file of its name."""


def method_names() -> tuple[str, ...]:
    """Return the names of all methods, those of this folder first."""
    return (*BUILT_IN, *sorted(_added()))


def find_method(name: str) -> Method:
    """Return a method by name.

    Raises
    ------
    InputError : there is none, it cannot be imported, or it has the name of another
    """
    added = _added()
    if name in BUILT_IN:
        if name in added:
            raise InputError(f"{added[name].value} adds a method {name!r}, which exists; rename it")
        return import_module(f"photonmap.evaluate.methods.{name.replace('-', '_')}").METHOD
    if name not in added:
        raise InputError(f"there is no method {name!r}; {suggest(name, method_names())}")
    try:
        method = added[name].load()
    except Exception as error:  # whatever another package's import raises
        raise InputError(
            f"method {name!r} cannot be imported from {added[name].value} ({error})"
        ) from None
    if not isinstance(method, Method):
        raise InputError(f"{added[name].value}, method {name!r}, is not a Method")
    return method


def _added() -> dict[str, EntryPoint]:
    """Return the entry points of installed packages by name."""
    return {point.name: point for point in entry_points(group=GROUP)}
