"""A scene before its lights are chosen."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from photonmap.dataset.lighting import Illumination, lamp_materials
from photonmap.dataset.things import Thing, count_names, meshes_of
from photonmap.scene import Camera, Scene


@dataclass(frozen=True, eq=False)
class Setting:
    """Things, a camera, and lamps that are off.

    Parameters
    ----------
    name : of the scene
    things : all that is in it, lamps too
    camera : at rest
    radiances : luminance of each group of lamps at which it lights the scene alone to a common
        exposure, the main one first
    backdrop : kinds of things that it is not about, as walls
    """

    name: str
    things: Sequence[Thing]
    camera: Camera
    radiances: Mapping[str, float]
    backdrop: Collection[str]

    @cached_property
    def named(self) -> list[Thing]:
        """Things, each with a name of its own: those of the meshes."""
        return count_names(self.things)

    @property
    def objects(self) -> list[str]:
        """Names of all things but the backdrop."""
        pairs = zip(self.things, self.named, strict=True)
        return [named.name for thing, named in pairs if thing.name not in self.backdrop]

    def lit(self, illumination: Illumination) -> Scene:
        """Return the scene with its lamps on."""
        lamps = lamp_materials(illumination, self.radiances)
        meshes = [
            mesh
            for thing in self.named
            for mesh in meshes_of(thing, lambda part: lamps.get(part.lamp, part.material))
        ]
        return Scene(meshes, [], self.camera, self.name)
