"""A room that is filled thing by thing: nothing cuts into anything, and all rests on something."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from photonmap.dataset import fixtures
from photonmap.dataset.lighting import radiance_of
from photonmap.dataset.palette import Palette
from photonmap.dataset.setting import Setting
from photonmap.dataset.shapes import Shape, box, rotation, sheet
from photonmap.dataset.solids import Random
from photonmap.dataset.things import Part, Thing, bounds_of, overlap
from photonmap.scene import Camera, Material
from photonmap.vectors import Vector

BACK, LEFT, RIGHT, FRONT = "back", "left", "right", "front"
_TURNS = {BACK: 0.0, LEFT: 90.0, FRONT: 180.0, RIGHT: -90.0}
"""Degrees by which what faces +z is turned to stand before a wall."""
BACKDROP = ("floor", "ceiling", "walls", "skirting", "window")
"""Kinds of things that make up the room itself."""
_GAP = 0.03
"""Metres between walls and furniture."""
_CLEAR = 0.45
"""Metres around the camera that stay free."""
_SKIRTING = (0.09, 0.014)
_ATTEMPTS = 12
_POINTS = 200
"""About as many at most are looked at to set the exposure."""
_BOUNCED = 0.7
"""Of the lamps' light, that the surfaces of a room send on in all."""


class Room:
    """A box of walls around the y axis, its floor at y = 0; the camera looks towards -z.

    Parameters
    ----------
    name : of the scene
    rng : draws places and things
    palette : draws materials
    width, depth, height : along x, z and y, metres
    """

    def __init__(
        self, name: str, rng: Random, palette: Palette, width: float, depth: float, height: float
    ) -> None:
        self.name, self.rng, self.palette = name, rng, palette
        self.size = np.array([width, height, depth])
        self.things: list[Thing] = []
        self._boxes: list[np.ndarray] = []
        self._rugs: list[np.ndarray] = []
        self._windows: dict[str, list[tuple[float, float, float, float]]] = {}
        self._camera: Camera | None = None

    def look(self, origin: Vector, target: Vector, fov: float = 52.0) -> None:
        """Put the camera, about here; nothing will stand in its way."""
        moved = np.array(origin) + self.rng.uniform(-0.08, 0.08, 3) * (1.0, 0.5, 1.0)
        x, y, z = moved.tolist()
        self._camera = Camera((x, y, z), target, fov=fov)
        free = np.stack([moved - _CLEAR, moved + _CLEAR])
        free[0, 1] = 0.0
        self._boxes.append(free[None])

    def put(
        self, things: Sequence[Thing], x: float, z: float, turn: float = 0.0, jitter: float = 0.05
    ) -> bool:
        """Stand a group of things on the floor, or on a rug, near a place if it is free.

        Parameters
        ----------
        things : the first carries the others; around the y axis, at rest on y = 0
        turn : degrees about the y axis
        jitter : by how much the place varies, metres

        Returns
        -------
        bool : whether there was a place
        """
        turned = [thing.turned(turn) for thing in things]
        boxes = _boxes_of(turned)
        for attempt in range(_ATTEMPTS):
            reach = jitter * (1.0 + 0.5 * attempt)
            dx, dz = self.rng.uniform(-reach, reach, 2) if jitter else (0.0, 0.0)
            offset = np.array([x + dx, 0.0, z + dz])
            offset[1] = self._floor_at(boxes + offset)
            if self._add(turned, boxes, offset):
                return True
        return False

    def against(self, things: Sequence[Thing], wall: str, along: float, turn: float = 0.0) -> bool:
        """Stand a group of things with its back to a wall, `along` metres right of its middle."""
        depth = -float(bounds_of([thing.turned(turn) for thing in things])[0, 2])
        x, z = self._before(wall, along, depth + _GAP)
        return self.put(things, x, z, _TURNS[wall] + turn, 0.0)

    def hang(self, things: Sequence[Thing], wall: str, along: float, height: float) -> bool:
        """Hang a group of things, whose backs are at z = 0, on a wall."""
        x, z = self._before(wall, along, 0.0)
        turned = [thing.turned(_TURNS[wall]) for thing in things]
        return self._add(turned, _boxes_of(turned), np.array([x, height, z]))

    def suspend(self, thing: Thing, x: float, z: float) -> bool:
        """Hang a thing, whose top is at y = 0, from the ceiling."""
        return self._add([thing], thing.boxes, np.array([x, self.size[1], z]))

    def lay(self, rug: Thing, x: float, z: float, turn: float = 0.0) -> bool:
        """Lay a rug, on which things may stand that lie within it as a whole."""
        laid = rug.turned(turn).moved((x, 0.0, z))
        if not self._add([laid], laid.boxes, np.zeros(3)):
            return False
        self._rugs.append(laid.bounds)
        return True

    def window(self, wall: str, along: float, sill: float, width: float, height: float) -> None:
        """Open a window in a wall."""
        self._windows.setdefault(wall, []).append((along, sill, width, height))
        x, z = self._before(wall, along, 0.0)
        made = fixtures.window(self.palette, width, height).turned(_TURNS[wall])
        self.things.append(made.moved((x, sill, z)))

    def finish(
        self, main: str, floor: Callable[[Room], Thing], walls: Sequence[Material]
    ) -> Setting:
        """Build the walls, and return the room with its lamps off.

        Parameters
        ----------
        main : the group of lights that shines where there is but one
        floor : makes the floor
        walls : the materials of the back wall and of the others
        """
        assert self._camera is not None
        shell = [floor(self), self._ceiling(), self._walls(walls), self._skirting()]
        groups = [main, *({fixtures.WINDOW, fixtures.LAMP} - {main})]
        things = [*shell, *self.things]
        points = np.concatenate(self._boxes).mean(axis=1)
        points = points[:: 1 + len(points) // _POINTS]
        surface = 2.0 * float(self.size @ np.roll(self.size, 1))
        radiances = {
            group: radiance_of(things, group, points, _BOUNCED / surface) for group in groups
        }
        return Setting(self.name, things, self._camera, radiances, BACKDROP)

    def _before(self, wall: str, along: float, gap: float) -> tuple[float, float]:
        """Return x and z of a place before a wall."""
        half = 0.5 * self.size[2 if wall in (BACK, FRONT) else 0]
        x, _, z = rotation(_TURNS[wall], 1) @ np.array([along, 0.0, gap - half])
        return float(x), float(z)

    def _floor_at(self, boxes: np.ndarray) -> float:
        """Return the height of the rug on which boxes lie as a whole, or 0."""
        low, high = boxes[:, 0, ::2].min(axis=0), boxes[:, 1, ::2].max(axis=0)
        for rug in self._rugs:
            if (low >= rug[0, ::2]).all() and (high <= rug[1, ::2]).all():
                return float(rug[1, 1])
        return 0.0

    def _add(self, things: list[Thing], boxes: np.ndarray, offset: np.ndarray) -> bool:
        """Move things and take them in, if they lie within the room and cut into nothing."""
        boxes = boxes + offset
        half = 0.5 * self.size + 1e-9
        aside = np.abs(boxes[:, :, ::2]).max(axis=(0, 1)) > half[::2]
        if aside.any() or boxes[:, 1, 1].max() > 2.0 * half[1]:
            return False
        if any(overlap(boxes, other) for other in self._boxes):
            return False
        self._boxes.append(boxes)
        self.things += [thing.moved(offset) for thing in things]
        return True

    def _ceiling(self) -> Thing:
        w, h, d = self.size
        shape = sheet((-w / 2, h, -d / 2), (w, 0.0, 0.0), (0.0, 0.0, d))
        return Thing("ceiling", [Part(shape, self.palette.grey(7))])

    def _walls(self, materials: Sequence[Material]) -> Thing:
        parts = []
        for wall, turn in _TURNS.items():
            x, z = self._before(wall, 0.0, 0.0)
            material = materials[0 if wall == BACK else 1]
            pieces = [s.turned(turn).moved((x, 0.0, z)) for s in self._wall_pieces(wall)]
            parts += [Part(piece, material) for piece in pieces]
        return Thing("walls", parts)

    def _wall_pieces(self, wall: str) -> list[Shape]:
        """Return a wall at z = 0 as rectangles around its windows."""
        half, tall = 0.5 * self.size[0 if wall in (BACK, FRONT) else 2], float(self.size[1])
        pieces, at = [], -half
        for along, low, width, height in sorted(self._windows.get(wall, [])):
            left, right = along - 0.5 * width, along + 0.5 * width
            pieces += [(at, 0.0, left - at, tall), (left, 0.0, width, low)]
            pieces.append((left, low + height, width, tall - low - height))
            at = right
        pieces.append((at, 0.0, half - at, tall))
        return [sheet((u, v, 0.0), (w, 0.0, 0.0), (0.0, h, 0.0)) for u, v, w, h in pieces]

    def _skirting(self) -> Thing:
        tall, thick = _SKIRTING
        parts = []
        for wall, turn in _TURNS.items():
            long = self.size[0 if wall in (BACK, FRONT) else 2] - 2.0 * thick
            x, z = self._before(wall, 0.0, 0.5 * thick)
            shape = box(float(long), tall, thick, 0.004).turned(turn).moved((x, 0.0, z))
            parts.append(Part(shape, self.palette.grey(8)))
        return Thing("skirting", parts)


def _boxes_of(things: Sequence[Thing]) -> np.ndarray:
    """Return the bounds of all parts, (n, 2, 3)."""
    return np.concatenate([thing.boxes for thing in things])


def planks(room: Room) -> Thing:
    """Return a floor of boards of three like colours, in staggered rows."""
    width, _, depth = room.size
    hue, value = float(room.rng.uniform(15.0, 21.0)), int(room.rng.integers(4, 6))
    colors = [room.palette.chip(hue, (value, value + 1), (4, 4), 3.0) for _ in range(3)]
    rows = math.ceil(width / 0.16)
    wide, parts = width / rows, []
    for row in range(rows):
        ends = np.arange(-depth / 2 - room.rng.uniform(0.0, 1.3), depth / 2, 1.3)
        cuts = [-depth / 2, *ends[ends > -depth / 2 + 0.05].tolist(), depth / 2]
        for low, high in pairwise(cuts):
            corner = (-width / 2 + row * wide, 0.0, high)
            shape = sheet(corner, (wide, 0.0, 0.0), (0.0, 0.0, low - high))
            parts.append(Part(shape, room.palette.choice(colors)))
    return Thing("floor", parts)


def tiles(room: Room) -> Thing:
    """Return a floor of square tiles in checks of two colours."""
    width, _, depth = room.size
    columns, rows = round(width / 0.33), round(depth / 0.33)
    colors = (room.palette.chip(None, (7, 8), (2, 4)), room.palette.chip(None, (4, 5), (4, 6)))
    wide, deep = width / columns, depth / rows
    parts = []
    for i in range(columns):
        for k in range(rows):
            corner = (i * wide - width / 2, 0.0, (k + 1) * deep - depth / 2)
            shape = sheet(corner, (wide, 0.0, 0.0), (0.0, 0.0, -deep))
            parts.append(Part(shape, colors[(i + k) % 2]))
    return Thing("floor", parts)


def plain(room: Room) -> Thing:
    """Return a floor of one colour."""
    width, _, depth = room.size
    shape = sheet((-width / 2, 0.0, depth / 2), (width, 0.0, 0.0), (0.0, 0.0, -depth))
    return Thing("floor", [Part(shape, room.palette.grey(5))])
