"""Splits of a data set: each scene belongs to its part for ever, however the set grows."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from photonmap.errors import InputError
from photonmap.runtime.wording import suggest

PARTS = ("train", "val", "test")
FRACTIONS = (0.8, 0.1, 0.1)
"""Of the parts, unless others are asked for."""
LAYOUT, TYPE = "layout", "type"
WAYS = (LAYOUT, TYPE)
"""What the parts do not share: scenes of one name and seed, or scenes of one name."""

_DRAWN = {
    LAYOUT: ("scenes (names with seeds, such as study-3)", "add scenes with --count and --resume"),
    TYPE: ("types of scenes (names alone, such as study)",
           'make a set of more types, split by "layout"'),
}  # fmt: skip
"""What is drawn for the parts by each way, and how to get more of it."""


def identity(geometry: str, by: str) -> str:
    """Return what a scene's part follows from: "study-3" by layout, "study" by type."""
    if by not in WAYS:
        raise InputError(
            f"data sets are not split by {by!r}, but by {LAYOUT!r}, so that no scene (name with "
            f"seed) is in two parts, or by {TYPE!r}, so that no type (name) is; "
            f"{suggest(str(by), WAYS)}"
        )
    return geometry if by == LAYOUT else geometry.rpartition("-")[0]


def part_of(
    geometry: str,
    fractions: tuple[float, float, float] = FRACTIONS,
    seed: int = 0,
    by: str = LAYOUT,
) -> str:
    """Return the part that a scene belongs to, by a hash of its name.

    Examples
    --------
    >>> part_of("study-3")
    'train'
    """
    digest = hashlib.sha256(f"{seed} {identity(geometry, by)}".encode()).digest()
    place = int.from_bytes(digest[:7], "big") / 2.0**56
    ends = fractions[0], fractions[0] + fractions[1]
    if place < ends[0]:
        return PARTS[0]
    return PARTS[1] if place < ends[1] or fractions[2] == 0.0 else PARTS[2]


def split_scenes(
    geometries: Sequence[str], fractions: tuple[float, float, float], seed: int, by: str
) -> dict[str, list[int]]:
    """Return the places of images in each part, by their scenes.

    Fractions must not be negative, and add up to 1; no part that was asked for may be empty.
    """
    if not all(each >= 0.0 for each in fractions) or not abs(sum(fractions) - 1.0) <= 1e-6:
        given = ", ".join(map(str, fractions))
        raise InputError(f"splits {given} must not be negative and must add up to 1")
    parts: dict[str, list[int]] = {part: [] for part in PARTS}
    for place, geometry in enumerate(geometries):
        parts[part_of(geometry, fractions, seed, by)].append(place)
    for part, fraction in zip(PARTS, fractions, strict=True):
        if fraction > 0.0 and not parts[part]:
            total, (what, more) = len({identity(each, by) for each in geometries}), _DRAWN[by]
            raise InputError(
                f"the split {part!r} of {fraction:g} would be empty: by hash, none of the set's "
                f"{total} {what} belongs to it; {more}, or choose other fractions or another seed"
            )
    return parts
