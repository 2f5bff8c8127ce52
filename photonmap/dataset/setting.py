"""A scene before its lights are chosen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
    objects : names of the things that it is about, not walls and lamps
    """

    name: str
    things: Sequence[Thing]
    camera: Camera
    radiances: Mapping[str, float]
    objects: Sequence[str]

    def lit(self, illumination: Illumination) -> Scene:
        """Return the scene with its lamps on."""
        lamps = lamp_materials(illumination, self.radiances)
        meshes = [
            mesh
            for thing in count_names(self.things)
            for mesh in meshes_of(thing, lambda part: lamps.get(part.lamp, part.material))
        ]
        return Scene(meshes, [], self.camera, self.name)
