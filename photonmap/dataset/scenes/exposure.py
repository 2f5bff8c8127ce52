"""What each light group sends to what the camera sees, and how bright lights are by that."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.materials import reflectance_of
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import Floats, joined, normalised
from photonmap.dataset.models.wall_objects import WINDOW
from photonmap.dataset.scenes.illumination import MAIN_SHARE, Illumination, is_sky
from photonmap.dataset.scenes.rooms.camera_search import directions
from photonmap.errors import InputError
from photonmap.integrators.look import RayCaster
from photonmap.scene.camera import Camera

LEVEL = 1.0
"""Median irradiance of what the camera sees, W·m⁻², to which emitters are set."""
SKY = "sky"
"""The light group of the sky outdoors."""
_OPEN = (WINDOW, SKY)  # groups that show daylight
_SAMPLES = 64
"""Points on the emitters of a group, or directions to the sky, from which light is traced."""
_NEAREST, _ABOVE = 0.1, 1e-3
"""Least distance to an emitter that counts, and how far above surfaces rays begin, metres."""

Radiance = Callable[[Floats], Floats]
"""Returns the radiance seen in directions, (..., 3), as (...)."""


class LightMeter:
    """Measures light with shadow rays.

    In a closed room, interreflection adds what it adds in a sphere of the same area A and mean
    reflectance ρ: an irradiance of Φ ρ / (1 − ρ) / A for a flux Φ.
    """

    def __init__(self, objects: Sequence[SceneObject], camera: Camera, closed: bool) -> None:
        self._parts = [part for obj in objects for part in obj.parts]
        self._closed = closed
        whole = joined([part.shape for part in self._parts])
        sizes = [len(part.shape.faces) for part in self._parts]
        owners = np.repeat(np.arange(len(sizes)), sizes)
        self._rays = RayCaster(whole.vertices, whole.faces)
        origin = np.array(camera.origin, np.float64)
        ways = directions(np.array(camera.target) - origin, camera.fov)
        triangles, distances = self._rays.first_hits(np.tile(origin, (len(ways), 1)), ways)
        emits = np.array([bool(part.light_group) for part in self._parts])
        seen = (triangles >= 0) & ~emits[owners[triangles]]
        corners = whole.vertices[whole.faces[triangles[seen]]]
        normals = normalised(np.cross(*(corners[:, 1:] - corners[:, :1]).transpose(1, 0, 2)))
        self._normals = normals * -np.sign((normals * ways[seen]).sum(axis=1, keepdims=True))
        self._points = origin + distances[seen, None] * ways[seen] + _ABOVE * self._normals

    def irradiance(self, group: str, radiance: Radiance | None = None) -> Floats:
        """Return the irradiance of the points, (P,), by the radiance seen in the group, or 1."""
        radiance = radiance or (lambda ways: np.ones(ways.shape[:-1]))
        emitters = joined([p.shape for p in self._parts if p.light_group == group])
        ends, normals = _spread(emitters.vertices[emitters.faces])
        way = ends - self._points[:, None]
        square = np.maximum((way**2).sum(axis=2), _NEAREST**2)
        cosines = np.maximum((way * self._normals[:, None]).sum(axis=2), 0.0)
        cosines *= np.maximum(-(way * normals).sum(axis=2), 0.0)
        clear = self._rays.is_clear(self._points, ends)
        seen = cosines / square**2 * clear * radiance(normalised(way))
        leaving = radiance(_by_cosine(-normals)).mean()
        direct = seen.sum(axis=1) * emitters.area / _SAMPLES
        return direct + math.pi * emitters.area * leaving * self._gain

    def from_sky(self, radiance: Radiance) -> Floats:
        """Return the irradiance of the points, (P,), by the radiance of the sky."""
        ways = _fibonacci((np.arange(_SAMPLES) + 0.5) / _SAMPLES)
        amounts = radiance(ways)
        received = [a * self.from_afar(way) for a, way in zip(amounts, ways, strict=True)]
        return 2.0 * math.pi * np.mean(received, axis=0)

    def from_afar(self, towards: Floats) -> Floats:
        """Return the irradiance of the points, (P,), from a sun of irradiance 1 in a direction."""
        ways = np.tile(towards, (len(self._points), 1))
        hit, _ = self._rays.first_hits(self._points, ways)
        return np.maximum(self._normals @ towards, 0.0) * (hit < 0)

    @cached_property
    def _gain(self) -> float:
        """The irradiance that interreflection adds for each watt, m⁻²."""
        if not self._closed:
            return 0.0
        areas = np.array([part.shape.area for part in self._parts])
        mean = float(areas @ [reflectance_of(part.material) for part in self._parts] / areas.sum())
        return mean / (1.0 - mean) / float(areas.sum())


def _fibonacci(heights: Floats) -> Floats:
    """Return unit vectors of evenly falling heights, y, on a spiral, (M, 3)."""
    ring = np.sqrt(1.0 - heights * heights)
    turn = (np.arange(len(heights)) + 0.5) * math.pi * (1.0 + math.sqrt(5.0))
    return np.stack([ring * np.cos(turn), heights, ring * np.sin(turn)], axis=1)


def _by_cosine(normals: Floats) -> Floats:
    """Return directions about `_SAMPLES` normals, (M, 3), distributed by the cosine.

    The sum of a normal and a point of the unit sphere is; strides mix those of several emitters.
    """
    sphere = _fibonacci(1.0 - 2.0 * (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
    return normalised(normals + sphere[np.arange(_SAMPLES) * 37 % _SAMPLES])


def _spread(corners: Floats) -> tuple[Floats, Floats]:
    """Return points, (M, 3), spread evenly over triangles, (T, 3, 3), and the normals there."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    number = np.arange(_SAMPLES)
    at = np.searchsorted(np.cumsum(area) / area.sum(), (number + 0.5) / _SAMPLES)
    # The R2 sequence (Roberts 2018), folded onto the triangle.
    u, v = ((0.5 + number[:, None] * (0.7548776662466927, 0.5698402909980532)) % 1.0).T
    u, v = np.where(u + v > 1.0, (1.0 - u, 1.0 - v), (u, v))
    a, b, c = corners[at].transpose(1, 0, 2)
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return points, cross[at] / area[at, None]


def set_levels(
    illumination: Illumination, received: Mapping[str, NDArray[np.float64]]
) -> list[tuple[str, float, list[str]]]:
    """Return the luminance of each light of an illumination, with its colour and groups.

    A light's share is that of the mean irradiance of what the camera sees; the median irradiance
    of all lights together is `LEVEL`. See `deal` for which group takes which colour.

    Parameters
    ----------
    received : irradiance of the points that the camera sees, (P,), for each light group at a
        luminance of 1, the main group first

    Raises
    ------
    InputError : there are more colours than light groups
    """
    dealt = deal(illumination, list(received))
    sums = [np.sum([received[group] for group in groups], axis=0) for _, _, groups in dealt]
    radiances = [share / each.mean() for (_, share, _), each in zip(dealt, sums, strict=True)]
    total = np.sum([level * each for level, each in zip(radiances, sums, strict=True)], axis=0)
    median = np.median(total)
    return [
        (color, float(level * LEVEL / median), groups)
        for (color, _, groups), level in zip(dealt, radiances, strict=True)
    ]


def deal(illumination: Illumination, groups: Sequence[str]) -> list[tuple[str, float, list[str]]]:
    """Deal the colours of an illumination to light groups, the main one first.

    Windows show daylight, as does the sky: they take the first colour of a sky if there is one;
    colours that are none are left to the lamps as far as there are enough. Lamps without a colour
    of their own burn with the first lamp.

    Returns
    -------
    for each light: its colour, its share, and its groups, after the first of which it is named

    Raises
    ------
    InputError : there are more colours than light groups
    """
    colors = list(illumination.colors)
    if len(colors) > len(groups):
        raise InputError(
            f"illumination {illumination.name!r} has {len(colors)} colours, but there are "
            f"{len(groups)} light groups ({', '.join(groups)}); give at most as many colours"
        )
    places = list(groups)
    sky = next((i for i, color in enumerate(colors) if is_sky(color)), None)
    open_ = next((group for group in places if group in _OPEN), None)
    if open_ and sky is None:
        places.sort(key=lambda group: group == open_)
    elif open_ in places[: len(colors)] and len(colors) > 1 and sky is not None:
        places.remove(open_)
        places.insert(sky, open_)
    places = places[: len(colors)]
    ranks = [sorted(places, key=groups.index).index(place) for place in places]
    rest = (1.0 - MAIN_SHARE) / max(len(places) - 1, 1)
    usual = [rest if rank else MAIN_SHARE for rank in ranks] if len(places) > 1 else [1.0]
    shares = illumination.shares or usual
    spare = [g for g in groups if g.startswith(LAMP) and g not in places]
    return [
        (color, share, [place, *spare] if place == LAMP else [place])
        for color, share, place in zip(colors, shares, places, strict=True)
    ]
