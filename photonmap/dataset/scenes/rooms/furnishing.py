"""How rooms and places outdoors are filled from what belongs to their kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.random_lights import MOST_LIGHTS
from photonmap.dataset.scenes.rooms.kinds import CORNER, FREE, Entry
from photonmap.dataset.scenes.rooms.room_builder import RoomBuilder
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
