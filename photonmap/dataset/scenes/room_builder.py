"""A room that is furnished object by object: nothing intersects, and everything is supported."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from photonmap.dataset.models import wall_fixtures
from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.palette import Palette
from photonmap.dataset.models.scene_object import Part, SceneObject, bounds_of, overlap
from photonmap.dataset.models.shapes import Random, Shape, box, parallelogram, rotation
from photonmap.dataset.scenes.illumination import radiance_for_exposure
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.scene.camera import Camera
from photonmap.scene.material import Material
from photonmap.scene.vectors import Vector

BACK, LEFT, RIGHT, FRONT = "back", "left", "right", "front"
_TURNS = {BACK: 0.0, LEFT: 90.0, FRONT: 180.0, RIGHT: -90.0}
"""Rotation about y, degrees, that makes an object that faces +z stand with its back to a wall."""
BACKDROP = ("floor", "ceiling", "walls", "skirting", "window")
"""Names of the objects that make up the room itself."""
_GAP = 0.03
"""Distance between walls and furniture, metres."""
_CLEAR = 0.45
"""Half the side of the box around the camera that stays free, metres."""
_SKIRTING = (0.09, 0.014)
"""Height and thickness of the skirting board, metres."""
_ATTEMPTS = 12
"""Positions tried for an object before it is left out."""
_MAX_POINTS = 200
"""Approximate largest number of points at which exposure is estimated."""
_REFLECTED = 0.7
"""Fraction of the emitted light that the surfaces of a room reflect, over all bounces."""


class RoomBuilder:
    """Builds a room: a box around the y axis with its floor at y = 0, seen towards -z.

    Parameters
    ----------
    name : of the scene
    rng : draws positions and objects
    palette : draws materials
    width, depth, height : along x, z and y, metres
    """

    def __init__(
        self, name: str, rng: Random, palette: Palette, width: float, depth: float, height: float
    ) -> None:
        self.name, self.rng, self.palette = name, rng, palette
        self.size = np.array([width, height, depth])
        self.objects: list[SceneObject] = []
        self._boxes: list[np.ndarray] = []
        self._rugs: list[np.ndarray] = []
        self._windows: dict[str, list[tuple[float, float, float, float]]] = {}
        self._camera: Camera | None = None

    def set_camera(self, origin: Vector, target: Vector, fov: float = 52.0) -> None:
        """Place the camera near a position, and keep the space around it free."""
        moved = np.array(origin) + self.rng.uniform(-0.08, 0.08, 3) * (1.0, 0.5, 1.0)
        x, y, z = moved.tolist()
        self._camera = Camera((x, y, z), target, fov=fov)
        free = np.stack([moved - _CLEAR, moved + _CLEAR])
        free[0, 1] = 0.0
        self._boxes.append(free[None])

    def place(
        self,
        objects: Sequence[SceneObject],
        x: float,
        z: float,
        turn: float = 0.0,
        jitter: float = 0.05,
    ) -> bool:
        """Stand a group of objects on the floor or a rug near (x, z), if there is room.

        Parameters
        ----------
        objects : the first carries the others; around the y axis, resting on y = 0
        turn : rotation about the y axis, degrees
        jitter : largest random displacement along x and z at the first attempt, metres

        Returns
        -------
        bool : whether there was room
        """
        turned = [obj.turned(turn) for obj in objects]
        boxes = _boxes_of(turned)
        for attempt in range(_ATTEMPTS):
            reach = jitter * (1.0 + 0.5 * attempt)
            dx, dz = self.rng.uniform(-reach, reach, 2) if jitter else (0.0, 0.0)
            offset = np.array([x + dx, 0.0, z + dz])
            offset[1] = self._floor_at(boxes + offset)
            if self._add(turned, boxes, offset):
                return True
        return False

    def place_against(
        self, objects: Sequence[SceneObject], wall: str, along: float, turn: float = 0.0
    ) -> bool:
        """Stand a group of objects against a wall, `along` metres right of the wall's middle."""
        depth = -float(bounds_of([obj.turned(turn) for obj in objects])[0, 2])
        x, z = self._in_front_of(wall, along, depth + _GAP)
        return self.place(objects, x, z, _TURNS[wall] + turn, 0.0)

    def hang(self, objects: Sequence[SceneObject], wall: str, along: float, height: float) -> bool:
        """Hang a group of objects on a wall; their backs are at z = 0."""
        x, z = self._in_front_of(wall, along, 0.0)
        turned = [obj.turned(_TURNS[wall]) for obj in objects]
        return self._add(turned, _boxes_of(turned), np.array([x, height, z]))

    def suspend(self, obj: SceneObject, x: float, z: float) -> bool:
        """Hang an object from the ceiling; its top is at y = 0."""
        return self._add([obj], obj.boxes, np.array([x, self.size[1], z]))

    def lay_rug(self, rug: SceneObject, x: float, z: float, turn: float = 0.0) -> bool:
        """Lay a rug; objects whose footprint is within it will stand on it."""
        laid = rug.turned(turn).moved((x, 0.0, z))
        if not self._add([laid], laid.boxes, np.zeros(3)):
            return False
        self._rugs.append(laid.bounds)
        return True

    def add_window(self, wall: str, along: float, sill: float, width: float, height: float) -> None:
        """Add a window of this sill height, width and height, metres, to a wall."""
        self._windows.setdefault(wall, []).append((along, sill, width, height))
        x, z = self._in_front_of(wall, along, 0.0)
        made = wall_fixtures.window(self.palette, width, height).turned(_TURNS[wall])
        self.objects.append(made.moved((x, sill, z)))

    def build(
        self, main: str, floor: Callable[[RoomBuilder], SceneObject], walls: Sequence[Material]
    ) -> UnlitScene:
        """Build floor, walls and ceiling, and return the room with its emitters off.

        Parameters
        ----------
        main : the light group that is on if the illumination has one colour
        floor : makes the floor
        walls : materials of the back wall and of the other walls
        """
        assert self._camera is not None
        shell = [floor(self), self._ceiling(), self._walls(walls), self._skirting()]
        groups = [main, *({wall_fixtures.WINDOW, LAMP} - {main})]
        objects = [*shell, *self.objects]
        points = np.concatenate(self._boxes).mean(axis=1)
        points = points[:: 1 + len(points) // _MAX_POINTS]
        surface = 2.0 * float(self.size @ np.roll(self.size, 1))
        radiances = {
            group: radiance_for_exposure(objects, group, points, _REFLECTED / surface)
            for group in groups
        }
        return UnlitScene(self.name, objects, self._camera, radiances, BACKDROP)

    def _in_front_of(self, wall: str, along: float, gap: float) -> tuple[float, float]:
        """Return x and z of the position at a distance from a wall, `along` right of its middle."""
        half = 0.5 * self.size[2 if wall in (BACK, FRONT) else 0]
        x, _, z = rotation(_TURNS[wall], 1) @ np.array([along, 0.0, gap - half])
        return float(x), float(z)

    def _floor_at(self, boxes: np.ndarray) -> float:
        """Return the height of the rug that boxes lie on entirely, or 0."""
        low, high = boxes[:, 0, ::2].min(axis=0), boxes[:, 1, ::2].max(axis=0)
        for rug in self._rugs:
            if (low >= rug[0, ::2]).all() and (high <= rug[1, ::2]).all():
                return float(rug[1, 1])
        return 0.0

    def _add(self, objects: list[SceneObject], boxes: np.ndarray, offset: np.ndarray) -> bool:
        """Move objects and add them if they lie within the room and intersect nothing."""
        boxes = boxes + offset
        half = 0.5 * self.size + 1e-9
        aside = np.abs(boxes[:, :, ::2]).max(axis=(0, 1)) > half[::2]
        if aside.any() or boxes[:, 1, 1].max() > 2.0 * half[1]:
            return False
        if any(overlap(boxes, other) for other in self._boxes):
            return False
        self._boxes.append(boxes)
        self.objects += [obj.moved(offset) for obj in objects]
        return True

    def _ceiling(self) -> SceneObject:
        w, h, d = self.size
        shape = parallelogram((-w / 2, h, -d / 2), (w, 0.0, 0.0), (0.0, 0.0, d))
        return SceneObject("ceiling", [Part(shape, self.palette.grey(7))])

    def _walls(self, materials: Sequence[Material]) -> SceneObject:
        parts = []
        for wall, turn in _TURNS.items():
            x, z = self._in_front_of(wall, 0.0, 0.0)
            material = materials[0 if wall == BACK else 1]
            pieces = [s.turned(turn).moved((x, 0.0, z)) for s in self._wall_pieces(wall)]
            parts += [Part(piece, material) for piece in pieces]
        return SceneObject("walls", parts)

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
        return [parallelogram((u, v, 0.0), (w, 0.0, 0.0), (0.0, h, 0.0)) for u, v, w, h in pieces]

    def _skirting(self) -> SceneObject:
        tall, thick = _SKIRTING
        parts = []
        for wall, turn in _TURNS.items():
            long = self.size[0 if wall in (BACK, FRONT) else 2] - 2.0 * thick
            x, z = self._in_front_of(wall, 0.0, 0.5 * thick)
            shape = box(float(long), tall, thick, 0.004).turned(turn).moved((x, 0.0, z))
            parts.append(Part(shape, self.palette.grey(8)))
        return SceneObject("skirting", parts)


def _boxes_of(objects: Sequence[SceneObject]) -> np.ndarray:
    """Return the bounding boxes of all parts, (n, 2, 3), metres."""
    return np.concatenate([obj.boxes for obj in objects])


def planks(room: RoomBuilder) -> SceneObject:
    """Return a floor of planks in three similar colours, in staggered rows."""
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
            shape = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, low - high))
            parts.append(Part(shape, room.palette.choice(colors)))
    return SceneObject("floor", parts)


def tiles(room: RoomBuilder) -> SceneObject:
    """Return a floor of square tiles, checked in two colours."""
    width, _, depth = room.size
    columns, rows = round(width / 0.33), round(depth / 0.33)
    colors = (room.palette.chip(None, (7, 8), (2, 4)), room.palette.chip(None, (4, 5), (4, 6)))
    wide, deep = width / columns, depth / rows
    parts = []
    for i in range(columns):
        for k in range(rows):
            corner = (i * wide - width / 2, 0.0, (k + 1) * deep - depth / 2)
            shape = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, -deep))
            parts.append(Part(shape, colors[(i + k) % 2]))
    return SceneObject("floor", parts)


def plain(room: RoomBuilder) -> SceneObject:
    """Return a floor of one colour."""
    width, _, depth = room.size
    shape = parallelogram((-width / 2, 0.0, depth / 2), (width, 0.0, 0.0), (0.0, 0.0, -depth))
    return SceneObject("floor", [Part(shape, room.palette.grey(5))])
