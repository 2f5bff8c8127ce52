"""Where a photographer would stand in a furnished room."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import Random, normalised
from photonmap.scene.camera import Camera

_CANDIDATES = 48
"""Cameras that are compared."""
_RAYS = (20, 15)
"""Rays of a candidate's image, across and down."""
_EYE, _AIM, _FOV = (1.3, 1.7), (0.5, 1.15), (50.0, 66.0)
"""Ranges of the camera's height, of the height it looks at, metres, and of its angle, degrees."""
_NEAR, _FAR = 0.7, 1.9
"""Least distance to what is seen, and least median of those distances, metres."""
_SHARE = (0.24, 0.55)
"""Share of the image that objects cover."""
_LARGEST = 0.2
"""Largest share of the image that one object covers."""
_SUBJECT = 0.06
"""Least share of the image that the main group covers."""
_ANOTHER = 0.06
"""What another object of the same kind is worth."""
_PARTS = 5
"""Parts of the image, across and down, all of which are worth showing something."""
_SMALL = 0.35
"""Objects up to this size, metres, count as one box."""


class _Outlook(NamedTuple):
    """What a camera sees: by ray, the object (-1 for walls), and the distance in metres."""

    objects: NDArray[np.int64]
    distances: NDArray[np.float64]


class _Boxes(NamedTuple):
    """Bounding boxes, (n, 2, 3), the objects that they belong to, (n,), and the room's size."""

    bounds: NDArray[np.float64]
    owners: NDArray[np.int64]
    size: NDArray[np.float64]


class _Kinds(NamedTuple):
    """By object, (n,): a number for its name, and whether it belongs to the main group."""

    names: NDArray[np.int64]
    subject: NDArray[np.bool_]


def find_camera(
    rng: Random,
    objects: Sequence[SceneObject],
    subject: Collection[SceneObject],
    places: NDArray[np.float64],
    size: NDArray[np.float64],
) -> Camera | None:
    """Return a camera at a free place that sees many kinds of objects, none from too near.

    Parameters
    ----------
    objects : of the room, without its shell
    subject : those of the main group, which the camera sees
    places : (n, 2) x and z at which someone can stand, metres
    size : (3,) of the room along x, y and z, metres

    Returns
    -------
    Camera, or None where no candidate sees enough
    """
    solid = [obj for obj in objects if obj.bounds[0, 1] < 1.9]
    boxes = _boxes_of(objects, size)
    names = np.unique([obj.name for obj in objects], return_inverse=True)[1]
    members = {id(obj) for obj in subject}
    kinds = _Kinds(names, np.array([id(obj) in members for obj in objects]))
    best, most = None, 0.0
    for _ in range(_CANDIDATES if len(places) else 0):
        x, z = places[rng.integers(len(places))]
        origin = np.array([x, rng.uniform(*_EYE), z])
        aim = solid[int(rng.integers(len(solid)))].bounds.mean(axis=0)
        target = np.array([aim[0], rng.uniform(*_AIM), aim[2]])
        fov = float(rng.uniform(*_FOV))
        worth = float(rng.uniform(0.75, 1.25))
        if np.linalg.norm((target - origin)[::2]) < _FAR:
            continue
        worth *= _worth(_look(boxes, origin, target, fov), kinds)
        if worth > most:
            best = Camera(tuple(origin.tolist()), tuple(target.tolist()), fov=fov)
            most = worth
    return best


def _worth(seen: _Outlook, kinds: _Kinds) -> float:
    """Return how much a camera shows, 0 for a camera that will not do."""
    found, counts = np.unique(seen.objects[seen.objects >= 0], return_counts=True)
    if not len(found):
        return 0.0
    shares = counts / seen.objects.size
    near, far = np.min(seen.distances), np.median(seen.distances)
    fits = _SHARE[0] <= shares.sum() <= _SHARE[1] and shares.max() <= _LARGEST
    fits = fits and shares[kinds.subject[found]].sum() >= _SUBJECT
    if not (fits and near > _NEAR and far > _FAR):
        return 0.0
    rows, columns = _RAYS[1] // _PARTS, _RAYS[0] // _PARTS
    parts = (seen.objects >= 0).reshape(_PARTS, rows, _PARTS, columns).any(axis=(1, 3))
    return (len(np.unique(kinds.names[found])) + _ANOTHER * len(found)) * float(parts.mean())


def _boxes_of(objects: Sequence[SceneObject], size: NDArray[np.float64]) -> _Boxes:
    bounds = [
        obj.boxes if np.ptp(obj.bounds, axis=0).max() > _SMALL else obj.bounds[None]
        for obj in objects
    ]
    owners = np.repeat(np.arange(len(objects)), [len(each) for each in bounds])
    return _Boxes(np.concatenate(bounds), owners, size)


def directions(ahead: NDArray[np.float64], fov: float) -> NDArray[np.float64]:
    """Return the directions of a camera's rays, (n, 3), of length 1, evenly over its image."""
    ahead = normalised(ahead)
    right = normalised(np.cross(ahead, (0.0, 1.0, 0.0)))
    half = math.tan(math.radians(0.5 * fov))
    u, v = (half * ((np.arange(n) + 0.5) * 2.0 / n - 1.0) for n in _RAYS)
    v = v * _RAYS[1] / _RAYS[0]
    ways = ahead + u[None, :, None] * right + v[:, None, None] * np.cross(right, ahead)
    ways = normalised(ways.reshape(-1, 3))
    return np.where(np.abs(ways) < 1e-9, 1e-9, ways)


def _look(
    boxes: _Boxes, origin: NDArray[np.float64], target: NDArray[np.float64], fov: float
) -> _Outlook:
    """Cast the rays of a camera at boxes within a room around the y axis."""
    ways = directions(target - origin, fov)
    walls = np.stack([-0.5 * boxes.size, 0.5 * boxes.size])
    walls[:, 1] = 0.0, boxes.size[1]
    wall = np.max((walls[:, None] - origin) / ways, axis=0).min(axis=1)
    ends = (boxes.bounds[None] - origin) / ways[:, None, None]
    enter, leave = ends.min(axis=2).max(axis=2), ends.max(axis=2).min(axis=2)
    hits = np.where((leave >= np.maximum(enter, 0.0)), np.maximum(enter, 0.0), np.inf)
    nearest = hits.argmin(axis=1)
    distance = hits[np.arange(len(ways)), nearest]
    owner = np.where(distance < wall, boxes.owners[nearest], -1)
    return _Outlook(owner, np.minimum(distance, wall))
