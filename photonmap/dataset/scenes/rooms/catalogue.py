"""All rooms by name, generated from their kind and a seed; how places are filled by their kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from photonmap.dataset.models.lamps import ceiling_spot
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.random_lights import MOST_LIGHTS
from photonmap.dataset.scenes.rooms.kinds import CORNER, FREE, FURTHER_KINDS, KINDS, Entry, RoomKind
from photonmap.dataset.scenes.rooms.room_builder import RoomBuilder
from photonmap.dataset.scenes.rooms.shell import TURNS
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.errors import InputError

_ATTEMPTS = 24
"""Places that are furnished until a camera sees enough of one."""
_LAMPS = MOST_LIGHTS - 1
"""Least number of lamps; with the windows or the sky, as many light groups as are drawn."""


Build = Callable[[str, Random, Palette, float], UnlitScene | None]
"""Generates a place; None where no camera sees enough of it, or what matters most has no room."""


def build_until_seen(
    build: Build, name: str, rng: Random, palette: Palette, scale: float = 1.0
) -> UnlitScene:
    """Generate places of a kind until a camera sees enough of one.

    Parameters
    ----------
    scale : factor of the size along all axes; more stands in larger places

    Raises
    ------
    InputError : no camera sees enough of a place of this size
    """
    for _ in range(_ATTEMPTS):
        if made := build(name, rng, palette, scale):
            return made
    raise InputError(
        f"no camera sees enough of any {name} of scale {scale:g} in {_ATTEMPTS} attempts; choose "
        "a scale nearer 1"
    )


def place_entries(
    place: RoomBuilder, entries: Sequence[Entry], rng: Random, palette: Palette, scale: float
) -> bool:
    """Place what stands in a kind of place, more of it in larger ones.

    Returns
    -------
    Whether the first entry, which is the main one, has found room
    """
    for index, entry in enumerate(entries):
        drawn = int(rng.integers(entry.count[0], entry.count[1] + 1))
        count = max(entry.count[0], round(drawn * scale))
        placed = sum(_place(place, entry, rng, palette) for _ in range(count))
        if index == 0 and not placed:
            return False
    return True


def _place(place: RoomBuilder, entry: Entry, rng: Random, palette: Palette) -> bool:
    group = entry.make(rng, palette)
    if entry.where == FREE:
        return place.place_free(group)
    return place.place_at_wall(group, entry.where == CORNER)


def add_lamps(place: RoomBuilder, add: Callable[[], bool]) -> bool:
    """Add lamps until there are enough; return whether they have found room.

    Parameters
    ----------
    add : adds a lamp; returns whether there was room
    """
    while place.lamps < _LAMPS:
        if not add():
            return False
    return True


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
