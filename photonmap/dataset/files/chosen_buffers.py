"""Which buffers the files of a data set hold, where not all are asked for."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from photonmap.buffers import ADDED, BUFFERS, DEFAULT, split_name
from photonmap.errors import InputError
from photonmap.runtime.wording import suggest

if TYPE_CHECKING:
    from photonmap.results.result import Result

ALWAYS = ("radiance", "reflectance", "shading", "valid")
"""Buffers that every image holds, as readers, scores and `verify` need them."""
_KEPT = "pure"
"""Mask that every image holds besides: without it nobody can tell where light is exact."""
_NEEDED_BY = {
    "hdf5": ("distance", "normal", "object_id"),
    "sensor": ("emission",),
}
"""Buffers that Hypersim's files, and photos, are made from beside those."""
_KNOWN = (*BUFFERS, *(row.name for row in ADDED))


def check_chosen(
    names: Sequence[str] | None, formats: Collection[str], has_sensor: bool = False
) -> tuple[str, ...] | None:
    """Return the buffers that files are to hold in the usual order, `pure` included; None for all.

    Raises
    ------
    InputError : there is no such buffer, or one is missing that is always needed, or that a format
        or a sensor needs
    """
    if names is None:
        return None
    for name in names:
        if name not in _KNOWN:
            raise InputError(f"there is no buffer {name!r}; {suggest(name, _KNOWN)}")
    _refuse_without(names, ALWAYS, "reading and verify")
    if "hdf5" in formats:
        _refuse_without(names, _NEEDED_BY["hdf5"], "Hypersim's files of the format hdf5")
    if has_sensor:
        _refuse_without(names, _NEEDED_BY["sensor"], "a photo by --sensor")
    return tuple(name for name in _KNOWN if name in (*names, _KEPT))


def _refuse_without(names: Sequence[str], needed: Sequence[str], what: str) -> None:
    if missing := [name for name in needed if name not in names]:
        raise InputError(f"buffers lack {', '.join(missing)}, which {what} need; add to --buffers")


def rendered_for(chosen: Collection[str] | None) -> list[str]:
    """Return the buffers that a render has to keep for files of these; None for the usual ones.

    Those that renders keep of some scenes alone are not among the usual ones, so that all images of
    a set hold the same.
    """
    further = [name for name in chosen or () if name in BUFFERS and name not in DEFAULT]
    return [*DEFAULT, *further]


def held_in(result: Result, chosen: Collection[str] | None) -> Result:
    """Return what files hold of a result: the chosen buffers, light groups and errors included."""
    if chosen is None:
        return result

    def kept(images: dict[str, Any]) -> dict[str, Any]:
        return {name: image for name, image in images.items() if split_name(name)[0] in chosen}

    arguments = result.record.get("arguments", {}) | {"buffers": sorted(chosen)}
    return replace(
        result,
        buffers=kept(result.buffers),
        errors=kept(result.errors),
        block_errors=kept(result.block_errors),
        record=result.record | {"arguments": arguments},
    )
