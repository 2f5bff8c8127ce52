"""Where a photographer would stand in a furnished room."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import Floats, Random, area_vectors, joined, normalised
from photonmap.dataset.models.wall_objects import WINDOW
from photonmap.integrators.look import RayCaster
from photonmap.scene.camera import Camera

_CANDIDATES = 150  # cameras that are compared
_RAYS = (20, 15)  # rays of an image, across and down
_AROUND = 3
"""How many times as wide and high as a candidate's image the field is in which cuts are found."""
_EYE, _AIM, _FOV = (1.2, 1.75), (0.4, 1.25), (38.0, 62.0)
"""Ranges of the camera's height, of the height it looks at, metres, and of its angle, degrees."""
_NEAR, _FAR = 0.7, 1.9
"""Least distance to what is seen, and least median of those distances, metres."""
_SHARE = (0.15, 0.6)  # share of the image that objects cover
_LARGEST = 0.25  # largest share of the image that one object covers
_SUBJECT = 0.05  # least share of the image that the main group covers
_ANOTHER = 0.12  # what another object of the same kind is worth
_PARTS = 5  # parts of the image, across and down, all of which are worth showing something
_FULL = 0.35  # share of such a part that objects cover where it is worth most
_OPEN_FLOOR = 0.5
"""What a part is worth that shows the floor, a window or the sky, but no object; a wall is 0."""
_CUT = 0.3  # share of what is visible of an object that is outside the image where it counts as cut
_LEVEL = 0.7  # least slope of floors and ceilings, as the vertical part of their normals


class _Field(NamedTuple):
    """What can be seen: triangles, and by triangle the object (-1 for none) and the open floor."""

    rays: RayCaster
    owners: NDArray[np.int64]
    open: NDArray[np.bool_]


class _Outlook(NamedTuple):
    """What a camera sees, by ray, (rows, columns): objects (-1 for none), distances, open floor."""

    objects: NDArray[np.int64]
    distances: Floats
    open: NDArray[np.bool_]


class _Kinds(NamedTuple):
    """By object, (n,): a number for its name, and whether it belongs to the main group."""

    names: NDArray[np.int64]
    subject: NDArray[np.bool_]


def find_camera(
    rng: Random,
    objects: Sequence[SceneObject],
    surroundings: Sequence[SceneObject],
    subject: Collection[SceneObject],
    places: NDArray[np.float64],
) -> Camera | None:
    """Return a camera at a free place that sees many kinds of objects, none from too near.

    Of several, the one is chosen that sees most kinds, in most parts of the image, cuts fewest of
    them at its edge, least of all the main group, and shows least of walls without things.

    Parameters
    ----------
    objects : of the room, without its shell
    surroundings : the shell of the room, with its windows
    subject : those of the main group, which the camera sees
    places : (n, 2) x and z at which someone can stand, metres

    Returns
    -------
    Camera, or None where no candidate sees enough
    """
    solid = [obj for obj in objects if obj.bounds[0, 1] < 1.9]
    field = _field_of(objects, surroundings)
    names = np.unique([obj.name for obj in objects], return_inverse=True)[1]
    members = {id(obj) for obj in subject}
    kinds = _Kinds(names, np.array([id(obj) in members for obj in objects]))
    best, most = None, 0.0
    # Drawn once, as the best of many cameras would always be a high one with a wide angle.
    eye, fov = float(rng.uniform(*_EYE)), float(rng.uniform(*_FOV))
    for _ in range(_CANDIDATES if len(places) else 0):
        x, z = places[rng.integers(len(places))]
        origin = np.array([x, eye, z])
        aim = solid[int(rng.integers(len(solid)))].bounds.mean(axis=0)
        target = np.array([aim[0], rng.uniform(*_AIM), aim[2]])
        worth = float(rng.uniform(0.7, 1.3))
        if np.linalg.norm((target - origin)[::2]) < _FAR:
            continue
        worth *= _worth(_look(field, origin, target, fov), kinds)
        if worth > most:
            best = Camera(tuple(origin.tolist()), tuple(target.tolist()), fov=fov)
            most = worth
    return best


def _worth(around: _Outlook, kinds: _Kinds) -> float:
    """Return how much a camera shows, by what is in and around its image; 0 if it will not do."""
    seen = _framed(around)
    number = len(kinds.names)
    counts = np.bincount(seen.objects[seen.objects >= 0], minlength=number)
    if not counts.any():
        return 0.0
    shares = counts / seen.objects.size
    fits = _SHARE[0] <= shares.sum() <= _SHARE[1] and shares.max() <= _LARGEST
    fits = fits and shares[kinds.subject].sum() >= _SUBJECT
    if not (fits and seen.distances.min() > _NEAR and np.median(seen.distances) > _FAR):
        return 0.0
    visible = np.bincount(around.objects[around.objects >= 0], minlength=number)
    cut = np.minimum((1.0 - counts / np.maximum(visible, 1)) / _CUT, 1.0)
    whole = 1.0 - float(shares @ cut) / float(shares.sum())
    subject = counts[kinds.subject].sum() / visible[kinds.subject].sum()
    found = np.flatnonzero(counts)
    variety = len(np.unique(kinds.names[found])) + _ANOTHER * len(found)
    return variety * (_filled(seen) * whole) ** 2 * float(subject) ** 3


def _filled(seen: _Outlook) -> float:
    """Return the mean worth of the parts of an image; nothing but walls has none."""
    shape = _PARTS, _RAYS[1] // _PARTS, _PARTS, _RAYS[0] // _PARTS
    things, floor = (
        each.reshape(shape).mean(axis=(1, 3)) for each in (seen.objects >= 0, seen.open)
    )
    full = np.minimum(things / _FULL, 1.0)
    return float((full + (1.0 - full) * _OPEN_FLOOR * floor).mean())


def _framed(around: _Outlook) -> _Outlook:
    """Return what is within the image, `_RAYS`, in the middle of the field around it."""
    rows, columns = ((n - n // _AROUND) // 2 for n in around.objects.shape)
    inner = slice(rows, rows + _RAYS[1]), slice(columns, columns + _RAYS[0])
    return _Outlook(around.objects[inner], around.distances[inner], around.open[inner])


def _field_of(objects: Sequence[SceneObject], surroundings: Sequence[SceneObject]) -> _Field:
    parts = [(part.shape, i) for i, obj in enumerate(objects) for part in obj.parts]
    parts += [(part.shape, -1) for obj in surroundings for part in obj.parts]
    whole = joined([shape for shape, _ in parts])
    faces = [len(shape.faces) for shape, _ in parts]
    owners = np.repeat([owner for _, owner in parts], faces)
    normals = normalised(area_vectors(whole.vertices, whole.faces))
    windows = [obj.name == WINDOW for obj in surroundings for _ in obj.parts]
    outside = np.concatenate([np.zeros(len(parts) - len(windows), bool), windows])
    level = (normals[:, 1] > _LEVEL) & (owners < 0)
    return _Field(RayCaster(whole.vertices, whole.faces), owners, level | np.repeat(outside, faces))


def directions(ahead: Floats, fov: float, around: int = 1) -> Floats:
    """Return the directions of a camera's rays, (n, 3), of length 1, evenly over its image.

    They may cover a field `around` times as wide and high, as densely. The fov is in degrees.
    """
    ahead = normalised(ahead)
    right = normalised(np.cross(ahead, (0.0, 1.0, 0.0)))
    half = math.tan(math.radians(0.5 * fov)) * around
    u, v = (half * ((np.arange(n * around) + 0.5) * 2.0 / (n * around) - 1.0) for n in _RAYS)
    u = u * _RAYS[0] / _RAYS[1]
    ways = ahead + u[None, :, None] * right + v[:, None, None] * np.cross(right, ahead)
    ways = normalised(ways.reshape(-1, 3))
    return np.where(np.abs(ways) < 1e-9, 1e-9, ways)


def _look(field: _Field, origin: Floats, target: Floats, fov: float) -> _Outlook:
    """Cast the rays of a camera."""
    ways = directions(target - origin, fov, _AROUND)
    triangles, distances = field.rays.first_hits(np.tile(origin, (len(ways), 1)), ways)
    missed = triangles < 0
    shape = _RAYS[1] * _AROUND, _RAYS[0] * _AROUND
    return _Outlook(
        np.where(missed, -1, field.owners[triangles]).reshape(shape),
        np.where(missed, np.inf, distances).reshape(shape),
        (missed | field.open[triangles]).reshape(shape),
    )
