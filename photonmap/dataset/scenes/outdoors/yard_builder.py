"""A place outdoors: a house front, three other sides, ground, and the sky above."""

from __future__ import annotations

from collections.abc import Sequence

from photonmap.dataset.models.lamps import LAMP, numbered
from photonmap.dataset.models.materials.lightness import with_lightness
from photonmap.dataset.models.places.outdoors import wall_lantern
from photonmap.dataset.models.scene_object import Part, SceneObject
from photonmap.dataset.models.shapes import box
from photonmap.dataset.scenes.exposure import SKY, LightMeter
from photonmap.dataset.scenes.open_sky import OpenSky
from photonmap.dataset.scenes.outdoors.enclosures import MakeGround, MakeSide
from photonmap.dataset.scenes.rooms import shell
from photonmap.dataset.scenes.rooms.room_builder import RoomBuilder
from photonmap.dataset.scenes.rooms.shell import BACK, TURNS
from photonmap.dataset.scenes.unlit_scene import UnlitScene

BACKDROP = ("ground", "walls", "eaves", "window")
"""Names of the objects that enclose a place."""
_BRACKET = (1.8, 2.2)
"""Heights of wall lanterns, metres."""


class YardBuilder(RoomBuilder):
    """Builds a place like a room without a ceiling; its back is the front of a house."""

    def add_lantern(self) -> bool:
        """Hang a lantern on the house."""
        made = wall_lantern(self._palette)
        for _ in range(24):
            along = self._along(BACK, 0.4)
            height = float(self._rng.uniform(*_BRACKET))
            if along is not None and self._hang([made], BACK, along, height):
                return True
        return False

    def build_yard(
        self, name: str, ground: MakeGround, sides: Sequence[MakeSide]
    ) -> UnlitScene | None:
        """Return the place with its lights off, or None if no camera sees enough of it.

        Parameters
        ----------
        name : of the scene
        ground : makes the ground
        sides : makers of the left, the front and the right side
        """
        surroundings = [
            SceneObject("ground", ground(self._rng, self._palette, self._size)),
            SceneObject("walls", [*self._house(), *self._sides(sides)]),
            self._eaves(),
        ]
        camera = self._find_camera(surroundings)
        if camera is None:
            return None
        made = [*surroundings, *self._frames, *numbered(self._objects)]
        objects = with_lightness(made, self._palette.lightness)
        meter = LightMeter(objects, camera, closed=False)
        # The sun stands in front of the house, or to a side of it.
        sky = OpenSky.over(meter, float(self._rng.uniform(105.0, 255.0)))
        lamps = [LAMP, *(f"{LAMP} {number}" for number in range(2, self.lamps + 1))]
        received = {SKY: sky.overcast, **{group: meter.irradiance(group) for group in lamps}}
        return UnlitScene(name, objects, camera, received, BACKDROP, sky)

    def _house(self) -> list[Part]:
        """Return the front of a house around its windows, on a base of another colour."""
        x, z = shell.in_front_of(BACK, self._size, 0.0, 0.0)
        length, paint = shell.length_of(BACK, self._size), self._palette.pale()
        pieces = shell.wall_pieces(length, float(self._size[1]), self._windows.get(BACK, ()))
        return [Part(piece.moved((x, 0.0, z)), paint) for piece in pieces]

    def _eaves(self) -> SceneObject:
        """Return the edge of the roof, on top of the house front."""
        x, z = shell.in_front_of(BACK, self._size, 0.0, 0.1)
        edge = box(float(self._size[0]), 0.14, 0.45, 0.01)
        roof = edge.moved((x, float(self._size[1]), z))
        return SceneObject("eaves", [Part(roof, self._palette.chip(12.0, (3, 5), (2, 6)))])

    def _sides(self, sides: Sequence[MakeSide]) -> list[Part]:
        parts = list[Part]()
        for wall, make in zip([w for w in TURNS if w != BACK], sides, strict=True):
            x, z = shell.in_front_of(wall, self._size, 0.0, 0.0)
            made = make(self._rng, self._palette, shell.length_of(wall, self._size))
            parts += [
                Part(p.shape.turned(TURNS[wall]).moved((x, 0.0, z)), p.material) for p in made
            ]
        return parts
