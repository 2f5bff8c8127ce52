"""A scene whose emitters are off, until it is given an illumination; and the sky that it shows."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.scene_object import (
    Part,
    SceneObject,
    to_meshes,
    with_unique_names,
)
from photonmap.dataset.models.shapes import Floats
from photonmap.dataset.models.wall_objects import WINDOW
from photonmap.dataset.scenes.exposure import SKY, LightMeter, Radiance, set_levels
from photonmap.dataset.scenes.illumination import Illumination, clear_sky, is_sky, light_spectrum
from photonmap.scene.camera import Camera
from photonmap.scene.daylight import OvercastLight, SkyLight, SunLight
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.observer import luminance

SUN = "sun"
"""The light group of the sun."""
_GROUND = 0.2  # reflectance of the ground as far as the horizon


@dataclass(frozen=True, eq=False)
class OpenSky:
    """The sky of a scene: what it sends to the points that the camera sees, and its lights.

    A sky of one colour is overcast.

    Parameters
    ----------
    group : of its light
    azimuth : of the sun, degrees, as of `SunLight`
    overcast : irradiance of the points, (P,), from an overcast sky of radiance 1 at the zenith
    from_sky : returns the irradiance of the points, (P,), by the radiance of the sky
    sunlit : returns the irradiance of the points, (P,), from a sun of irradiance 1 at an elevation;
        None where no sun shines
    """

    group: str
    azimuth: float
    overcast: Floats
    from_sky: Callable[[Radiance], Floats]
    sunlit: Callable[[float], Floats] | None = None

    @classmethod
    def over(cls, meter: LightMeter, azimuth: float) -> OpenSky:
        """Return the sky over what a meter measures."""

        def sunlit(elevation: float) -> Floats:
            direction = SunLight(elevation=elevation, azimuth=azimuth).direction
            return meter.from_afar(-np.array(direction))

        return cls(SKY, azimuth, meter.from_sky(_overcast), meter.from_sky, sunlit)

    @classmethod
    def through_windows(cls, meter: LightMeter, azimuth: float) -> OpenSky:
        """Return the sky outside the windows of what a meter measures."""
        from_sky = partial(meter.irradiance, WINDOW)
        return cls(WINDOW, azimuth, from_sky(_overcast), from_sky)

    def received(self, color: str) -> Floats:
        """Return the irradiance of the points, (P,), from a light of level 1 by its name."""
        if clear_sky(color) is None:
            return self.overcast
        sky, *suns = self.lights(color, 1.0)
        assert isinstance(sky, SkyLight)
        received = self.from_sky(_seen_in(sky.luminance()))
        for sun in suns:
            assert isinstance(sun, SunLight)
            assert self.sunlit is not None
            received = received + luminance(sun.color) * self.sunlit(sun.elevation)
        return received

    def lights(self, color: str, level: float) -> list[Light]:
        """Return the lights of a colour: a clear sky, with its sun if it shines, or clouds."""
        clear = clear_sky(color)
        if clear is None:
            return [OvercastLight(light_spectrum(color) * level, _GROUND, SKY, self.group)]
        place = clear.turbidity, clear.elevation, self.azimuth, level
        sky = SkyLight(*place, SKY, self.group, _GROUND)
        return [sky] if self.sunlit is None else [sky, SunLight(*place, SUN)]


def _seen_in(image: NDArray[np.float32]) -> Radiance:
    """Return how to look up a map of the sky, (H, 2H), laid out as an `EnvironmentLight`'s is."""
    rows, columns = image.shape

    def radiance(directions: Floats) -> Floats:
        x, y, z = np.moveaxis(directions, -1, 0)
        row = np.arccos(np.clip(y, -1.0, 1.0)) / math.pi * rows
        column = (0.5 + np.arctan2(x, -z) / (2.0 * math.pi)) * columns
        at = np.minimum(row, rows - 1).astype(int), column.astype(int) % columns
        return image[at].astype(np.float64)

    return radiance


def _overcast(directions: Floats) -> Floats:
    return _seen_in(OvercastLight(ground=_GROUND).amounts())(directions)


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

        Lamps reflect as much as while they are off, so that illuminations of the same windows add
        up.

        Raises
        ------
        InputError : there are more colours than light groups, or a colour is no light
        """
        received, lights = dict(self.received), list[Light]()
        skies = filter(is_sky, illumination.colors)
        if self.sky and (first := next(skies, None)):
            received[self.sky.group] = self.sky.received(first)
        shining = dict[str, tuple[str, Spectrum | None]]()
        for color, level, groups in set_levels(illumination, received):
            if self.sky and groups[0] == self.sky.group:
                lights += self.sky.lights(color, level)
                shining[groups[0]] = f"{groups[0]} pane", None
            else:
                shining |= dict.fromkeys(groups, (groups[0], light_spectrum(color) * level))
        made = dict[tuple[str, str], Material]()

        def material(part: Part) -> Material:
            if part.light_group not in shining:
                return part.material
            name, emission = shining[part.light_group]
            key = name, part.material.name if emission else ""
            if key not in made:
                made[key] = (
                    Material(name, 0.0, portal=True)
                    if emission is None
                    else replace(part.material, name=name, emission=emission)
                )
            return made[key]

        meshes = [mesh for obj in self.named_objects for mesh in to_meshes(obj, material)]
        return Scene(meshes, lights, self.camera, self.name)
