"""All rooms by name, generated from their kind and a seed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from photonmap.dataset.models.lamps import ceiling_spot
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.rooms.furnishing import (
    add_lamps,
    build_until_seen,
    place_entries,
)
from photonmap.dataset.scenes.rooms.kinds import FURTHER_KINDS, KINDS, RoomKind
from photonmap.dataset.scenes.rooms.room_builder import RoomBuilder
from photonmap.dataset.scenes.rooms.shell import TURNS
from photonmap.dataset.scenes.unlit_scene import UnlitScene

_ALL_KINDS = {**KINDS, **FURTHER_KINDS}
_LOWEST = 2.3
"""Least height of a room, metres."""
_APART = 0.4
"""How far from the middle of the ceiling lamps hang that make up for missing ones, by its size."""


def _build(name: str, rng: Random, palette: Palette, scale: float) -> UnlitScene | None:
    """Generate a room of a kind: its size, openings, furniture, camera and colours."""
    kind = _ALL_KINDS[name]
    room = _furnished(kind, rng, palette, scale)
    floor = kind.floors[int(rng.integers(len(kind.floors)))]
    return room.build(name, kind.main, floor, kind.walls(rng, palette)) if room else None


def _furnished(kind: RoomKind, rng: Random, palette: Palette, scale: float) -> RoomBuilder | None:
    """Return a room with its furniture; None if what matters most has no place in it."""
    size = [float(rng.uniform(*each)) * scale for each in kind.size]
    size[2] = max(size[2], _LOWEST)
    room = RoomBuilder(rng, palette, *size)
    walls = [list(TURNS)[int(i)] for i in rng.permutation(len(TURNS))]
    lamp = kind.lamps[int(rng.integers(len(kind.lamps)))]
    if not (_open(room, rng, walls, size[2]) and room.suspend(lamp(rng, palette))):
        return None
    if not place_entries(room, kind.entries, rng, palette, scale):
        return None
    for make, heights, counts in kind.hung:
        for _ in range(int(rng.integers(counts[0], counts[1] + 1))):
            room.hang(make(rng, palette), heights)
    room.dress(kind.dressing)
    spot = float(rng.uniform(0.09, 0.17))
    lit = add_lamps(room, lambda: room.suspend(ceiling_spot(palette, spot), _APART))
    return room if lit else None


def _open(room: RoomBuilder, rng: Random, walls: list[str], height: float) -> bool:
    """Add a door and two or three windows; return whether both have been added."""
    curtains, count = bool(rng.random() < 0.4), int(rng.integers(2, 4))
    sill = float(rng.uniform(0.75, 1.05))
    tall = min(float(rng.uniform(1.1, 1.7)), height - sill - 0.2)
    added = 0
    for index in range(count):
        wide = float(rng.uniform(1.1, 2.4))
        added += room.add_window(walls[index % 2], (sill, wide, tall), curtains)
    return room.add_door(walls[2]) and added > 0


ROOMS: dict[str, Callable[[Random, Palette, float], UnlitScene]] = {
    name: partial(build_until_seen, _build, name) for name in _ALL_KINDS
}
"""Builders of rooms by name."""
