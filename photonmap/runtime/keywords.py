"""Misspelt keywords are refused with the one that was meant, which Python does from 3.13 on."""

from __future__ import annotations

from collections.abc import Collection

from photonmap.runtime.wording import suggest


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
