"""Misspelt keywords are refused with the one that was meant, which Python does from 3.13 on."""

from __future__ import annotations

import functools
from collections.abc import Collection
from dataclasses import fields
from typing import Any, TypeVar

from photonmap.runtime.wording import suggest

T = TypeVar("T")


def refuse_unknown(owner: str, given: Collection[str], known: Collection[str]) -> None:
    """Refuse keywords that a function or a class does not know.

    Raises
    ------
    TypeError : there is one, as Python has it
    """
    for name in given:
        if name not in known:
            meant = suggest(name, known)
            raise TypeError(f"{owner} got an unexpected keyword argument {name!r}; {meant}")


def suggesting_keywords(kind: type[T]) -> type[T]:
    """Decorate a dataclass, whose constructor then suggests the nearest of its keywords."""
    construct = kind.__init__
    known = tuple(each.name for each in fields(kind) if each.init)  # type: ignore[arg-type]

    @functools.wraps(construct)
    def checked(self: T, *args: Any, **given: Any) -> None:
        refuse_unknown(kind.__name__, given, known)
        construct(self, *args, **given)

    kind.__init__ = checked  # type: ignore[method-assign, assignment]
    return kind
