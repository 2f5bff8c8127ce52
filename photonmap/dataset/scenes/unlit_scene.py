"""A scene whose emitters are off, until it is given an illumination."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.scene_object import SceneObject, to_meshes, with_unique_names
from photonmap.dataset.scenes.exposure import set_levels
from photonmap.dataset.scenes.illumination import Illumination, is_sky, light_spectrum
from photonmap.dataset.scenes.open_sky import OpenSky
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class UnlitScene:
    """Objects and a camera, with all emitters off.

    Parameters
    ----------
    name : of the scene
    objects : everything in it, emitters included
    camera : the default view
    received : irradiance of what the camera sees, (P,), for each light group at a luminance of 1,
        the main group first, see `photonmap.dataset.scenes.exposure`
    backdrop : names of the kinds of objects that form the surroundings, such as walls
    sky : above a place outdoors, or outside the windows of a room, whose panes are of its light
        group; None for single objects
    """

    name: str
    objects: Sequence[SceneObject]
    camera: Camera
    received: Mapping[str, NDArray[np.float64]]
    backdrop: Collection[str]
    sky: OpenSky | None = None

    @cached_property
    def named_objects(self) -> list[SceneObject]:
        """The objects under unique names, which are those of their meshes."""
        return with_unique_names(self.objects)

    @property
    def object_names(self) -> list[str]:
        """Unique names of all objects that are not part of the backdrop."""
        pairs = zip(self.objects, self.named_objects, strict=True)
        return [named.name for obj, named in pairs if obj.name not in self.backdrop]

    def lit(self, illumination: Illumination) -> Scene:
        """Return the scene under an illumination.

        Raises
        ------
        InputError : there are more colours than light groups, or a colour is no light
        """
        received, lights = dict(self.received), list[Light]()
        skies = filter(is_sky, illumination.colors)
        if self.sky and (first := next(skies, None)):
            received[self.sky.group] = self.sky.received(first)
        emitters = dict[str, Material]()
        for color, level, groups in set_levels(illumination, received):
            if self.sky and groups[0] == self.sky.group:
                lights += self.sky.lights(color, level)
                emitters[groups[0]] = Material(f"{groups[0]} pane", 0.0, portal=True)
            else:
                made = Material(groups[0], 0.0, light_spectrum(color) * level)
                emitters |= dict.fromkeys(groups, made)
        meshes = [
            mesh
            for obj in self.named_objects
            for mesh in to_meshes(obj, lambda part: emitters.get(part.light_group, part.material))
        ]
        return Scene(meshes, lights, self.camera, self.name)
