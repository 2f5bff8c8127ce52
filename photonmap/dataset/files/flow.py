"""Optical flow and disparity between two views of one scene, exact at the centres of pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_KINDS = ("pinhole", "intrinsics")
_FLAT = 0.5
"""Distance from a tangent plane within which a surface is the same, in sides of a pixel there."""
_ROUNDING = 1e-5  # the same, relative to the distance from the camera
_RECTIFIED = 1e-6
"""Largest deviation of axes, and of the direction between eyes, in rectified pairs."""


@dataclass(frozen=True, eq=False)
class Eye:
    """Where a camera stands, and how it projects."""

    origin: Floats  # (3,) scene units
    axes: Floats  # (3, 3), rows right, down and view
    matrix: Floats  # (3, 3) intrinsics, pixels, (0, 0) the image's corner
    size: tuple[int, int]  # width and height, pixels

    @classmethod
    def of(cls, camera: Mapping[str, Any], size: Sequence[int]) -> Eye:
        """Return the eye of a camera's record; `size` is the width and height of its image."""
        if camera.get("kind") not in _KINDS or any(camera.get("distortion") or ()):
            kind = camera.get("kind")
            problem = "flow is between images of pinholes without distortion"
            raise InputError(f"{problem}, and one is of the kind {kind}")
        names = ("camera_to_world_opencv", "intrinsics")
        try:
            pose, matrix = (np.array(camera[name], np.float64) for name in names)
        except (KeyError, TypeError, ValueError):
            pose = matrix = np.zeros(0)
        finite = np.isfinite(pose).all() and np.isfinite(matrix).all()
        if (pose.shape, matrix.shape) != ((4, 4), (3, 3)) or not finite:
            raise InputError(
                f"a camera lacks {' and '.join(names)} of finite numbers; verify the set"
            )
        width, height = size
        return cls(pose[:3, 3], pose[:3, :3].T, matrix, (width, height))

    @property
    def centers(self) -> Floats:
        """(H, W, 2) the centres of pixels."""
        width, height = self.size
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        return np.stack([x, y], axis=-1)

    def points(self, distance: NDArray[Any]) -> Floats:
        """Return the points that pixels show: (H, W, 3); `distance` is from the eye, (H, W)."""
        (fx, _, cx), (_, fy, cy), _ = self.matrix
        x, y = np.moveaxis(self.centers, -1, 0)
        rays = np.stack([(x - cx) / fx, (y - cy) / fy, np.ones_like(x)], axis=-1) @ self.axes
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        return self.origin + rays * np.asarray(distance, np.float64)[..., None]

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the pixels of points, (…, 2), and their depths along the view, (…)."""
        seen = (points - self.origin) @ self.axes.T
        depth = seen[..., 2]
        safe = np.where(depth > 0.0, depth, 1.0)
        focal, center = self.matrix[[0, 1], [0, 1]], self.matrix[:2, 2]
        return seen[..., :2] / safe[..., None] * focal + center, depth

    def contains(self, pixels: Floats) -> Mask:
        """Return whether pixels are within the image."""
        width, height = self.size
        x, y = np.moveaxis(pixels, -1, 0)
        return (x >= 0.0) & (x < width) & (y >= 0.0) & (y < height)


@dataclass(frozen=True, eq=False)
class Flow:
    """Where the points of one image are in another."""

    first: Eye  # the eyes of both images
    second: Eye
    # (H, W, 2) float32, pixels: x and y there less x and y here, y down; 0 where not `valid`
    flow: NDArray[np.float32]
    valid: Mask  # (H, W) bool: a surface is at the pixel's centre, and in front of the other camera
    inside: Mask  # (H, W) bool: its point is within the other image
    visible: Mask  # (H, W) bool: and nothing hides it there

    @cached_property
    def occluded(self) -> Mask:
        """(H, W): the point is within the other image, but something hides it."""
        return self.inside & ~self.visible

    @property
    def is_rectified(self) -> bool:
        """Whether the images are of parallel cameras side by side, with equal intrinsics."""
        between = self.first.axes @ (self.second.origin - self.first.origin)
        length = float(np.linalg.norm(between))
        return (
            length > 0.0
            and bool(np.abs(between[1:]).max() <= _RECTIFIED * length)
            and np.allclose(self.first.axes, self.second.axes, rtol=0.0, atol=_RECTIFIED)
            and np.allclose(self.first.matrix, self.second.matrix)
        )

    @property
    def disparity(self) -> NDArray[np.float32]:
        """(H, W) float32, pixels: x in the left image less x in the right.

        It is focal length × baseline / depth.

        Raises
        ------
        InputError : the images are not those of a rectified pair
        """
        if not self.is_rectified:
            remedy = "take the flow of these"
            raise InputError(f"disparity is of parallel cameras side by side; {remedy}")
        to_right = float((self.first.axes @ (self.second.origin - self.first.origin))[0]) > 0.0
        return -self.flow[..., 0] if to_right else self.flow[..., 0]


@dataclass(frozen=True, eq=False)
class Target:
    """Where the points of an image are to be looked for in another."""

    points: Floats  # (H, W, 3) scene units
    pixels: Floats  # (H, W, 2) in the other image
    valid: Mask  # as in `Flow`
    inside: Mask


def find_targets(first: Eye, second: Eye, distance: NDArray[Any]) -> Target:
    """Return where the points of the first image are in the second; `distance` is the buffer."""
    hit = np.asarray(distance) > 0.0
    points = first.points(distance)
    pixels, depth = second.project(points)
    valid = hit & (depth > 0.0)
    return Target(points, pixels, valid, valid & second.contains(pixels))


def compare_surfaces(
    target: Target, ids: NDArray[Any], second: Eye, seen: Mapping[str, NDArray[Any]]
) -> Mask:
    """Return where the second image shows the points: surfaces and objects are compared.

    A point is seen if one of the four pixels around it shows the same object, in a tangent plane of
    which the point lies. `ids` are those of the first image's objects, (H, W); `seen` has
    `distance`, `normal` and `object_id` of the second.
    """
    width, height = second.size
    surfaces = second.points(seen["distance"])
    size = np.asarray(seen["distance"], np.float64) / second.matrix[0, 0]
    allowed = _FLAT * size + _ROUNDING * np.asarray(seen["distance"], np.float64)
    at = np.where(target.inside[..., None], target.pixels, 0.0) - 0.5
    low = np.floor(at).astype(np.intp)
    found = np.zeros(target.inside.shape, bool)
    for dx, dy in product((0, 1), repeat=2):
        x = np.clip(low[..., 0] + dx, 0, width - 1)
        y = np.clip(low[..., 1] + dy, 0, height - 1)
        normal = np.asarray(seen["normal"], np.float64)[y, x]
        away = np.abs(((target.points - surfaces[y, x]) * normal).sum(axis=-1))
        found |= (seen["object_id"][y, x] == ids) & (away <= allowed[y, x])
    return found & target.inside


def flow_of(first: Eye, second: Eye, target: Target, visible: Mask) -> Flow:
    """Return the flow to where points were found."""
    moved = np.where(target.valid[..., None], target.pixels - first.centers, 0.0)
    return Flow(first, second, moved.astype(np.float32), target.valid, target.inside, visible)
