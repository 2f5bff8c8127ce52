"""A room that is furnished group by group: nothing intersects, all rests, ways stay free."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from photonmap.dataset.models import wall_objects
from photonmap.dataset.models.lamps import LAMP, is_lamp, numbered
from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import SceneObject, bounds_of, overlap, with_lightness
from photonmap.dataset.models.shapes import Floats
from photonmap.dataset.models.wall_objects import WINDOW
from photonmap.dataset.scenes.exposure import LightMeter
from photonmap.dataset.scenes.rooms import shell
from photonmap.dataset.scenes.rooms.camera_search import find_camera
from photonmap.dataset.scenes.rooms.shell import TURNS, Opening
from photonmap.dataset.scenes.unlit_scene import OpenSky, UnlitScene

_GAP = 0.03  # distance between walls and furniture, metres
_CLEAR = 0.1
"""How far what is in front of windows, pictures and the like is from the wall at least, metres."""
_EYE_LEVEL, _AROUND_EYES = (1.45, 1.65), 0.3
"""Heights of the middle of pictures, and how far above and below a wall has to be bare, metres."""
_DRESSED_BY, _LEFT_BARE = (1.2, 2.4), 0.06
"""Lengths of a bare wall that one group of pictures is for, metres; how often it stays bare."""
_SHORTEST, _DRESSINGS = 0.5, 3
"""Length of the shortest bare wall that is dressed, metres, and the most things tried for it."""
_ATTEMPTS = 24  # positions tried for a group before it is left out
_CELL = 0.1  # side of a cell, metres
_WALKER = 0.2  # radius of someone who walks about, metres
_STEP, _HEAD = 0.05, 1.9  # what is lower is stepped over, what is higher is passed beneath, metres
_CONNECTED = 0.92  # least share of the free floor that is in one piece
_OPEN = 0.22  # least share of the floor that stays open to walk on
_DOOR_SWING, _WINDOW_REACH = 0.95, 0.4
"""How far the space in front of a door and of a window stays free, metres."""


class FloorPlan:
    """Cells of a floor around the y axis, and which of them a walker can stand in."""

    def __init__(self, width: float, depth: float) -> None:
        self._axes, inside = list[Floats](), list[NDArray[np.bool_]]()
        for side in (width, depth):
            count = max(1, round(side / _CELL))
            axis = (np.arange(count, dtype=np.float64) + 0.5) * (side / count) - 0.5 * side
            self._axes.append(axis)
            inside.append(np.abs(axis) <= 0.5 * side - _WALKER)
        self._free = inside[0][:, None] & inside[1][None, :]

    def leaves_ways(self, boxes: Floats) -> bool:
        """Return whether the floor stays open and in one piece if boxes, (n, 2, 3), stand on it."""
        free = self._without(boxes)
        reached = _largest_piece(free)
        return bool(reached.sum() >= _CONNECTED * free.sum() and reached.sum() >= _OPEN * free.size)

    def occupy(self, boxes: Floats) -> None:
        """Mark the cells that boxes, (n, 2, 3), take up."""
        self._free = self._without(boxes)

    def standing_places(self) -> Floats:
        """Return x and z of the cells that are reached on foot, (n, 2), metres."""
        i, k = np.nonzero(_largest_piece(self._free))
        return np.stack([self._axes[0][i], self._axes[1][k]], axis=1)

    def _without(self, boxes: Floats) -> NDArray[np.bool_]:
        free = self._free.copy()
        x, z = self._axes
        for low, high in boxes[(boxes[:, 1, 1] > _STEP) & (boxes[:, 0, 1] < _HEAD)]:
            i = np.searchsorted(x, (low[0] - _WALKER, high[0] + _WALKER))
            k = np.searchsorted(z, (low[2] - _WALKER, high[2] + _WALKER))
            free[i[0] : i[1], k[0] : k[1]] = False
        return free


def _largest_piece(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    pieces, count = ndimage.label(free)
    if not count:
        return free
    return pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))


@dataclass(frozen=True, eq=False)
class Group:
    """Objects that belong together, such as a desk with its chair and what lies on it.

    Parameters
    ----------
    objects : around the y axis, resting on y = 0 or on each other, fronts towards +z
    access : how far the floor in front of them stays free, metres
    """

    objects: Sequence[SceneObject]
    access: float = 0.0

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates, (2, 3), metres."""
        return bounds_of(self.objects)

    @cached_property
    def turned(self) -> Callable[[float], list[SceneObject]]:
        """Return the objects rotated about the y axis, the same ones when asked again."""
        return cache(lambda degrees: [obj.turned(degrees) for obj in self.objects])


Objects = list[SceneObject]
Dressing = Callable[[Draw, float], Objects]
"""Makes what hangs on a stretch of wall of some length, metres, around x = 0, its back at z = 0."""
_WALLS = list(TURNS)


class RoomBuilder:
    """Builds a room: a box around the y axis with its floor at y = 0.

    The group that is placed first is the main one, which the camera sees.

    Parameters
    ----------
    draw : draws positions and materials
    width, depth, height : along x, z and y, metres
    """

    def __init__(self, draw: Draw, width: float, depth: float, height: float) -> None:
        self.draw = draw
        self.size = np.array([width, height, depth])
        self._plan = FloorPlan(width, depth)
        self.windows = dict[str, list[Opening]]()
        self._objects, self._frames, self._subject = (list[SceneObject]() for _ in range(3))
        self._boxes, self._zones = list[Floats](), list[Floats]()

    def add_door(self, wall: str) -> bool:
        """Add a door to a wall, and keep the floor in front of it free."""
        made = wall_objects.door(self.draw, self.draw.number(0.8, 0.95))
        wide = float(np.ptp(made.bounds[:, 0]))
        along = self.along(wall, wide)
        if along is None or not self.hang_at([made], wall, along, 0.0):
            return False
        self._zones.append(self._zone(wall, along, (wide, 0.0, 2.1), _DOOR_SWING))
        return True

    def add_window(self, wall: str, size: tuple[float, float, float], curtains: bool) -> bool:
        """Add a window of a sill height, width and height, metres, and keep it clear."""
        sill, width, height = size
        along = self.along(wall, width + (1.3 if curtains else 0.3))
        if along is None or self._is_taken(wall, along, (width + 0.1, sill, height)):
            return False
        self.windows.setdefault(wall, []).append((along, sill, width, height))
        x, z = shell.in_front_of(wall, self.size, along, 0.0)
        made = wall_objects.window(self.draw, width, height).turned(TURNS[wall])
        self._frames.append(made.moved((x, sill, z)))
        for side in (-1.0, 1.0) if curtains else ():
            cloth = wall_objects.curtain(self.draw, 0.5, sill + height + 0.1)
            self.hang_at([cloth], wall, along + side * (0.5 * width + 0.3), 0.03)
        size = width, sill + 0.02, height
        self._zones.append(self._zone(wall, along, size, _WINDOW_REACH))
        return True

    def place_at_wall(self, group: Group, corner: bool = False) -> bool:
        """Stand a group with its back to some wall, in a corner if asked for."""
        wide, deep = 2.0 * float(np.abs(group.bounds[:, 0]).max()), -float(group.bounds[0, 2])
        for _ in range(_ATTEMPTS):
            wall = self.draw.one_of(_WALLS)
            along = self.along(wall, wide + 2.0 * _GAP, corner)
            if along is None:
                continue
            x, z = shell.in_front_of(wall, self.size, along, deep + _GAP)
            if self._place(group, x, z, TURNS[wall]):
                return True
        return False

    def place_free(self, group: Group) -> bool:
        """Stand a group away from the walls, turned by a multiple of 90 degrees or so."""
        for _ in range(_ATTEMPTS):
            reach = 0.3 * self.size[::2]
            x, z = self.draw.rng.uniform(-reach, reach)
            turn = 90.0 * self.draw.whole(0, 3)
            turn += self.draw.number(-12.0, 12.0) if self.draw.chance(0.3) else 0.0
            if self._place(group, float(x), float(z), turn):
                return True
        return False

    def hang(self, objects: Objects, heights: Range) -> bool:
        """Hang a group of objects on some wall, behind nothing; their backs are at z = 0."""
        low, high = bounds_of(objects)
        wide = 2.0 * float(max(-low[0], high[0])) + 0.1
        for _ in range(_ATTEMPTS):
            wall, height = self.draw.one_of(_WALLS), self.draw.number(*heights)
            along = self.along(wall, wide)
            if along is None:
                continue
            place = wide, height + float(low[1]), float(high[1] - low[1])
            if self._is_taken(wall, along, place):
                continue
            if self.hang_at(objects, wall, along, height):
                return True
        return False

    def dress(self, makers: Sequence[Dressing]) -> None:
        """Hang something on most bare stretches of all walls, at the height of eyes."""
        middle = self.draw.number(*_EYE_LEVEL)
        for wall in TURNS:
            for start, end in self._bare_stretches(wall, middle):
                count = max(1, round((end - start) / self.draw.number(*_DRESSED_BY)))
                wide = (end - start) / count
                for index in range(count if wide >= _SHORTEST else 0):
                    if not self.draw.chance(_LEFT_BARE):
                        self._dress(makers, wall, start + (index + 0.5) * wide, wide, middle)

    def _dress(
        self, makers: Sequence[Dressing], wall: str, along: float, wide: float, middle: float
    ) -> None:
        """Hang something on a stretch of a wall, or nothing if all that is tried is too large."""
        for _ in range(_DRESSINGS):
            made = self.draw.one_of(makers)(self.draw, wide)
            low, high = bounds_of(made)
            height = middle - 0.5 * float(low[1] + high[1])
            place = float(high[0] - low[0]), height + float(low[1]), float(high[1] - low[1])
            if not self._is_taken(wall, along, place) and self.hang_at(made, wall, along, height):
                return

    def suspend(self, obj: SceneObject, reach: float = 0.1) -> bool:
        """Hang an object from the ceiling; at first within `reach`, a part of the room's size."""
        for attempt in range(_ATTEMPTS):
            part = max(reach, 0.1 + 0.2 * attempt / _ATTEMPTS)
            limits = part * self.size[::2]
            x, z = self.draw.rng.uniform(-limits, limits)
            if self._add([obj], obj.boxes, np.array([x, self.size[1], z])):
                return True
        return False

    def build(
        self,
        name: str,
        main: str,
        surroundings: Sequence[SceneObject],
        sky_of: Callable[[LightMeter], OpenSky],
    ) -> UnlitScene | None:
        """Return the room with its emitters off, or None if no camera sees enough of it.

        Parameters
        ----------
        main : the light group that is on if the illumination has one colour
        surroundings : what encloses the room, besides its windows
        """
        backdrop = [*surroundings, *self._frames]
        places = self._plan.standing_places()
        camera = find_camera(self.draw.rng, self._objects, backdrop, self._subject, places)
        if camera is None:
            return None
        made = [*backdrop, *numbered(self._objects)]
        objects = with_lightness(made, self.draw.lightness)
        meter = LightMeter(objects, camera, closed=any(o.name == "ceiling" for o in surroundings))
        sky = sky_of(meter)
        spare = [f"{LAMP} {number}" for number in range(2, self.lamps + 1)]
        received = {
            group: sky.overcast if group == sky.group else meter.irradiance(group)
            for group in (main, *({sky.group, LAMP} - {main}), *spare)
        }
        names = (*(obj.name for obj in surroundings), WINDOW)
        return UnlitScene(name, objects, camera, received, names, sky)

    @property
    def lamps(self) -> int:
        """The number of lamps."""
        return sum(map(is_lamp, self._objects))

    def along(self, wall: str, wide: float, corner: bool = False) -> float | None:
        """Draw the middle of something on a wall; None if the wall is too short."""
        free = 0.5 * (shell.length_of(wall, self.size) - wide)
        if free < 0.0:
            return None
        if corner:
            return free if self.draw.chance(0.5) else -free
        return self.draw.number(-free, free)

    def _zone(
        self, wall: str, along: float, size: tuple[float, float, float], reach: float
    ) -> Floats:
        """Return the box, (1, 2, 3), in front of a width, from a height up, of a wall."""
        (wide, low, tall), ahead = size, partial(shell.in_front_of, wall, self.size)
        half = 0.5 * wide
        ends = np.array(
            [ahead(x, gap) for x in (along - half, along + half) for gap in (0.0, reach)]
        )
        bottom, top = ends.min(axis=0), ends.max(axis=0)
        return np.array([[[bottom[0], low, bottom[1]], [top[0], low + tall, top[1]]]])

    def _is_taken(self, wall: str, along: float, size: tuple[float, float, float]) -> bool:
        zone = self._zone(wall, along, size, _CLEAR)
        return any(overlap(zone, box) for box in (*self._boxes, *self._zones))

    def _bare_stretches(self, wall: str, height: float) -> list[Range]:
        """Return from where to where along a wall nothing stands or hangs at a height, metres."""
        edge = 0.5 * shell.length_of(wall, self.size)
        tall = 2.0 * _AROUND_EYES
        zone = self._zone(wall, 0.0, (2.0 * edge, height - 0.5 * tall, tall), _CLEAR)
        along = np.array(shell.in_front_of(wall, self.size, 1.0, 0.0))
        along -= shell.in_front_of(wall, self.size, 0.0, 0.0)
        taken = list[Range]()
        for box in np.concatenate([*self._boxes, *self._zones]):
            if overlap(zone, box[None]):
                first, last = sorted((box[:, ::2] @ along).tolist())
                taken.append((first, last))
        stretches, start = [], -edge
        for first, last in [*sorted(taken), (edge, edge)]:
            if first > start:
                stretches.append((start, first))
            start = max(start, last)
        return stretches

    def hang_at(self, objects: Objects, wall: str, along: float, height: float) -> bool:
        """Hang objects at a place on a wall, if they are in no one's way."""
        x, z = shell.in_front_of(wall, self.size, along, 0.0)
        turned = [obj.turned(TURNS[wall]) for obj in objects]
        return self._add(turned, _boxes_of(turned), np.array([x, height, z]))

    def _place(self, group: Group, x: float, z: float, turn: float) -> bool:
        turned = group.turned(turn)
        boxes, offset = _boxes_of(turned), np.array([x, 0.0, z])
        front = _access_of(group, turn) + offset if group.access else None
        if front is not None and any(overlap(front, other) for other in self._boxes):
            return False
        if not self._add(turned, boxes, offset):
            return False
        if front is not None:
            self._zones.append(front)
        self._subject = self._subject or self._objects[-len(turned) :]
        return True

    def _add(self, objects: Objects, boxes: Floats, offset: Floats) -> bool:
        """Move objects and add them if they lie within the room and are in no one's way."""
        boxes = boxes + offset
        half = 0.5 * self.size + 1e-9
        aside = np.abs(boxes[:, :, ::2]).max(axis=(0, 1)) > half[::2]
        if aside.any() or boxes[:, 1, 1].max() > 2.0 * half[1]:
            return False
        if any(overlap(boxes, other) for other in (*self._boxes, *self._zones)):
            return False
        if not self._plan.leaves_ways(boxes):
            return False
        self._plan.occupy(boxes)
        self._boxes.append(boxes)
        self._objects += [obj.moved(offset) for obj in objects]
        return True


def _boxes_of(objects: Objects) -> Floats:
    """Return the bounding boxes of all parts, (n, 2, 3), metres."""
    return np.concatenate([obj.boxes for obj in objects])


def _access_of(group: Group, turn: float) -> Floats:
    """Return the box, (1, 2, 3), of the floor in front of a group that is turned."""
    low, high = group.bounds
    corners = [(x, z) for x in (low[0], high[0]) for z in (high[2], high[2] + group.access)]
    (x, z), angle = np.transpose(corners), np.radians(turn)
    spun = x * np.cos(angle) + z * np.sin(angle), z * np.cos(angle) - x * np.sin(angle)
    (x0, z0), (x1, z1) = np.min(spun, axis=1) + 1e-3, np.max(spun, axis=1) - 1e-3
    return np.array([[[x0, 0.02, z0], [x1, 1.8, z1]]])
