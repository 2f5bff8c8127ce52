"""Projections: where on the image a camera shows what lies in a direction, one class a kind.

Lens distortion is that of OpenCV's formulas, which must not fold the image.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError
from photonmap.runtime.bounds import read_npz
from photonmap.runtime.wording import brief
from photonmap.scene.images import read_channels
from photonmap.scene.parameters import File, Number, Numbers, Whole, parameters_of
from photonmap.spectra.curves import Floats

PROJECTIONS: dict[str, type[Projection]] = {}
"""The kinds of projections, by their `type` in TOML files."""
_LARGEST = 1 << 20  # Pixels of a calibrated image along a side, at most
_Focal = Annotated[float, Number("focal length", "pixels", above=0.0)]
_OtherFocal = Annotated[float | None, Number("focal length", "pixels", above=0.0)]
_Center = Annotated[float | None, Number("principal point", "pixels")]
_Size = Annotated[
    tuple[int, int],
    Numbers("size in pixels", counts=(2,), each=Whole(at_least=1, at_most=_LARGEST)),
]
CHANNELS = tuple(f"{part}.{axis}" for part in ("origin", "direction") for axis in "XYZ")
"""Channels of an OpenEXR file."""
_NAME = "rays"  # The array of an NPZ file
_FARTHEST = 1e30
Bounds = tuple[float, float, float, float]  # Left, top, right and bottom of an image

STEPS = 24
"""Steps from the middle of the image to each point, whose solution begins at the one before."""
NEWTON = 6
ALONG_EDGE = 129
CLOSE = 1e-10


@dataclass(frozen=True)
class Projection:
    """How a camera maps directions to its image.

    A subclass is a dataclass with a `kind` of its own, whose annotations declare its parameters.
    """

    kind: ClassVar[str]
    takes_lens: ClassVar[bool] = False  # whether light may enter through more than a point
    has_axis: ClassVar[bool] = False
    """whether depth is measured along the view; otherwise it is the distance"""

    def __init_subclass__(cls) -> None:
        """Enter the class under its kind."""
        if "kind" in vars(cls):
            PROJECTIONS[cls.kind] = cls

    def find_conflict(self) -> str | None:
        """Return what is wrong with the attributes taken together; None if nothing is."""
        return None

    def matrix(self, width: int, height: int) -> Floats | None:
        """Return K, 3×3 in pixels of an image of this size; None if it has no such matrix.

        The image's corner is (0, 0), x is right and y down.
        """
        return None

    def describe(self) -> dict[str, Any]:
        """Return the JSON-able record of what is not in the matrix: of its numbers."""
        declared = parameters_of(type(self)).items()
        return {name: getattr(self, name) for name, each in declared if isinstance(each, Number)}


@dataclass(frozen=True)
class Pinhole(Projection):
    """Perspective with square pixels about the middle; `fov` is the vertical angle, degrees."""

    fov: Annotated[float, Number("angle of view", "degrees", above=0.0, below=180.0)] = 40.0
    kind: ClassVar[str] = "pinhole"
    takes_lens: ClassVar[bool] = True
    has_axis: ClassVar[bool] = True

    def matrix(self, width: int, height: int) -> Floats:
        """Return K; it projects points of depth 1."""
        focal = 0.5 * height / math.tan(math.radians(self.fov) / 2.0)
        return _matrix(focal, focal, 0.5 * width, 0.5 * height)


@dataclass(frozen=True)
class Orthographic(Projection):
    """Parallel rays; the image shows `height` scene units from top to bottom."""

    height: Annotated[float, Number("height", "scene units", above=0.0)]
    kind: ClassVar[str] = "orthographic"
    takes_lens: ClassVar[bool] = True
    has_axis: ClassVar[bool] = True

    def matrix(self, width: int, height: int) -> Floats:
        """Return what projects points at any depth."""
        scale = height / self.height
        return _matrix(scale, scale, 0.5 * width, 0.5 * height)


@dataclass(frozen=True)
class _Calibrated(Projection):
    """A projection with the intrinsics of a calibration.

    Parameters
    ----------
    fx, fy : focal lengths, pixels; fy is fx by default
    size : width and height of the calibrated image, pixels; images of another size show the same,
        stretched if they are of another shape
    cx, cy : principal point, pixels from the upper left *corner* of the image; its middle by
        default. OpenCV counts from the centre of the first pixel: add 0.5 to its numbers
    distortion : coefficients in the order of OpenCV
    """

    fx: _Focal
    size: _Size
    fy: _OtherFocal = None
    cx: _Center = None
    cy: _Center = None
    distortion: tuple[float, ...] = ()
    most: ClassVar[int]

    @property
    def coefficients(self) -> tuple[float, ...]:
        """As many as there can be; those that are not given are 0."""
        return (*self.distortion, *(0.0,) * (self.most - len(self.distortion)))

    @property
    def normalized_corners(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of the image, in units of the image plane."""
        (width, height), k = self.size, self.matrix(*self.size)
        low, high = -k[:2, 2] / k[[0, 1], [0, 1]], ([width, height] - k[:2, 2]) / k[[0, 1], [0, 1]]
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def matrix(self, width: int, height: int) -> Floats:
        """Return K for an image of any size."""
        across, down = width / self.size[0], height / self.size[1]
        cx = 0.5 * self.size[0] if self.cx is None else self.cx
        cy = 0.5 * self.size[1] if self.cy is None else self.cy
        fy = self.fx if self.fy is None else self.fy
        return _matrix(self.fx * across, fy * down, cx * across, cy * down)

    def describe(self) -> dict[str, Any]:
        """Return the calibrated size and the coefficients."""
        return {"calibrated_size": list(self.size), "distortion": list(self.distortion)}


@dataclass(frozen=True)
class Intrinsics(_Calibrated):
    """Perspective with the intrinsics of a calibration, and Brown's and Conrady's distortion.

    `distortion` is (k1, k2, p1, p2) or (k1, k2, p1, p2, k3), as OpenCV has it.
    """

    distortion: Annotated[
        tuple[float, ...], Numbers("distortion (k1, k2, p1, p2, k3)", counts=(0, 4, 5))
    ] = ()
    kind: ClassVar[str] = "intrinsics"
    most: ClassVar[int] = 5
    takes_lens: ClassVar[bool] = True
    has_axis: ClassVar[bool] = True

    def find_conflict(self) -> str | None:
        """Find distortion that folds the image."""
        if any(self.distortion) and find_fold(self.coefficients, self.normalized_corners):
            return "folds inside the image, which would show some directions twice; check its signs"
        return None


@dataclass(frozen=True)
class FisheyeIntrinsics(_Calibrated):
    """A fisheye with the intrinsics of a calibration: OpenCV's fisheye model.

    `distortion` is (k1, k2, k3, k4). At θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) focal lengths from
    the principal point lies what is seen at the angle θ from the view; beyond 180° is nothing.
    """

    distortion: Annotated[
        tuple[float, ...], Numbers("distortion (k1, k2, k3, k4)", counts=(0, 4))
    ] = ()
    kind: ClassVar[str] = "fisheye intrinsics"
    most: ClassVar[int] = 4

    def find_conflict(self) -> str | None:
        """Find an angle within the image at which the radius stops increasing."""
        left, top, right, bottom = self.normalized_corners
        farthest = math.hypot(max(-left, right), max(-top, bottom))
        angle, radius = widest_angle(self.coefficients)
        if angle < math.pi and radius < farthest:
            return f"folds inside the image, at {math.degrees(angle):.4g} degrees; check its signs"
        return None


@dataclass(frozen=True)
class Fisheye(Projection):
    """An equidistant fisheye: distances from the middle are angles from the view.

    `fov` is the full angle across the height of the image, degrees, up to 360. Nothing is seen
    outside of that circle.
    """

    fov: Annotated[float, Number("angle of view", "degrees", above=0.0, at_most=360.0)] = 180.0
    kind: ClassVar[str] = "fisheye"

    def matrix(self, width: int, height: int) -> Floats:
        """Return K; it multiplies angles, radians, in the direction away from the middle."""
        focal = height / math.radians(self.fov)
        return _matrix(focal, focal, 0.5 * width, 0.5 * height)


@dataclass(frozen=True)
class Panorama(Projection):
    """All directions, as an equirectangular image: longitude across, latitude from top to bottom.

    The middle shows the view; the left and the right edge what lies behind.
    """

    kind: ClassVar[str] = "panorama"


@dataclass(frozen=True, eq=False, repr=False)
class RayMap(Projection):
    """A ray for each pixel of images of one size.

    `rays` is an array (H, W, 6), or a file, NPZ with an array `rays` or OpenEXR with channels
    `origin.X` … `direction.Z`: the origin, scene units, and the direction, of any length, of the
    ray through each pixel's centre, in world space. A camera's `origin`, `target` and `up` do not
    move them.
    """

    rays: Annotated[
        ArrayLike | str | PathLike[str],
        File("ray map", key="file", read=read_rays, save=save_rays, suffix=".npz"),
    ]
    kind: ClassVar[str] = "ray map"

    __repr__ = brief

    def __post_init__(self) -> None:
        """Read the file, and check the array."""
        from_file = isinstance(self.rays, str | PathLike)
        rays = read_rays(self.rays) if from_file else check_rays(self.rays, "the ray map")  # type: ignore[arg-type]
        object.__setattr__(self, "rays", rays)

    @property
    def array(self) -> Floats:
        """The rays, (H, W, 6)."""
        assert isinstance(self.rays, np.ndarray)
        return self.rays

    def __eq__(self, other: object) -> bool:
        """Compare all rays."""
        return isinstance(other, RayMap) and np.array_equal(self.array, other.array)

    def __hash__(self) -> int:
        """Hash the size."""
        return hash(self.array.shape)


def _matrix(fx: float, fy: float, cx: float, cy: float) -> Floats:
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def read_rays(path: str | PathLike[str]) -> Floats:
    """Read rays, (H, W, 6), from NPZ or OpenEXR; an `InputError` says what the file lacks."""
    path = Path(path)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    values = _read_exr(path) if path.suffix.lower() == ".exr" else _read_npz(path)
    return check_rays(values, str(path))


def check_rays(values: Any, label: str) -> Floats:
    """Return rays as read-only (H, W, 6) float64.

    An `InputError` says that the shape is another, a number is not finite or above 1e30, or a
    direction is zero.
    """
    try:
        is_checked = isinstance(values, np.ndarray) and not values.flags.writeable
        rays = np.array(values, np.float64, order="C", copy=None if is_checked else True)
    except (ValueError, TypeError):
        raise InputError(f"{label} is not an array of numbers; give (H, W, 6)") from None
    if rays.ndim != 3 or rays.shape[2] != 6 or not rays.size:
        raise InputError(f"{label} has shape {rays.shape}; give (H, W, 6), origin and direction")
    bad = ~(np.abs(rays) <= _FARTHEST).all(axis=2)
    if bad.any():
        row, column = (int(index) for index in np.argwhere(bad)[0])
        raise InputError(
            f"{label} has a ray at row {row}, column {column} that is not finite; give six numbers "
            f"up to {_FARTHEST:g}"
        )
    none = (rays[..., 3:] == 0.0).all(axis=2)
    if none.any():
        row, column = (int(index) for index in np.argwhere(none)[0])
        raise InputError(
            f"{label} has no direction at row {row}, column {column}; give every pixel one"
        )
    rays.flags.writeable = False
    return rays


def save_rays(rays: Any, path: str | PathLike[str]) -> None:
    """Write rays as NPZ."""
    np.savez_compressed(path, rays=np.asarray(rays))


def _read_npz(path: Path) -> Any:
    try:
        found = read_npz(Path(path), lambda shapes: [_NAME] if _NAME in shapes else [])
        if not found:
            raise InputError(f"has no array {_NAME!r}; save it as NPZ with this name", path)
        return found[_NAME]
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("is not an NPZ file; save it again", path) from None


def _read_exr(path: Path) -> Any:
    channels = read_channels(path)
    pixels, names = channels.pixels, channels.names
    missing = [name for name in CHANNELS if name.lower() not in names]
    if missing:
        raise InputError(f"has no channel {missing[0]}; give {', '.join(CHANNELS)}", path)
    return pixels[..., [names.index(name.lower()) for name in CHANNELS]]


def distort(distortion: Sequence[float], points: Floats) -> tuple[Floats, Floats]:
    """Return where OpenCV's k1, k2, p1, p2, k3 move points, (…, 2), and how that changes with them.

    The derivative, (…, 3), is symmetric: of x along x, of x along y, of y along y.
    """
    k1, k2, p1, p2, k3 = distortion
    x, y = points[..., 0], points[..., 1]
    z = x * x + y * y
    radial = 1.0 + z * (k1 + z * (k2 + z * k3))
    slope = 2.0 * (k1 + z * (2.0 * k2 + z * 3.0 * k3))
    moved = np.stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (z + 2.0 * x * x),
            y * radial + p1 * (z + 2.0 * y * y) + 2.0 * p2 * x * y,
        ],
        axis=-1,
    )
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return moved, np.stack([xx, xy, yy], axis=-1)


def undistort(distortion: Sequence[float], targets: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the points, (n, 2), that are moved to targets, and whether the way there is unfolded.

    Points are followed from the middle of the image outwards, so that of several points that are
    moved to one, that is found which is reached without passing a fold.
    """
    points, sound = np.zeros_like(targets), np.ones(len(targets), bool)
    with np.errstate(all="ignore"):
        for step in range(1, STEPS + 1):
            goal = targets * (step / STEPS)
            for _ in range(NEWTON):
                moved, derivative = distort(distortion, points)
                sound &= _area(derivative) > 0.0
                points = np.where(sound[:, None], points - _step(derivative, moved - goal), 0.0)
            moved, derivative = distort(distortion, points)
            off = np.abs(moved - goal).max(axis=-1)
            sound &= off <= CLOSE * (1.0 + np.abs(goal).max(axis=-1))
            sound &= _area(derivative) > 0.0
    return points, sound


def _area(derivative: Floats) -> Floats:
    """Return the determinant: not above 0 where the image is folded."""
    area: Floats = derivative[..., 0] * derivative[..., 2] - derivative[..., 1] ** 2
    return area


def _step(derivative: Floats, error: Floats) -> Floats:
    """Return a step of Newton's method."""
    xx, xy, yy = np.moveaxis(derivative, -1, 0)
    right, down = np.moveaxis(error, -1, 0)
    steps = np.stack([yy * right - xy * down, xx * down - xy * right], axis=-1)
    return steps / _area(derivative)[..., None]


@lru_cache(maxsize=64)
def find_fold(distortion: tuple[float, ...], bounds: Bounds) -> bool:
    """Return whether distortion folds an image, as it does if a point of its edge has no origin."""
    left, top, right, bottom = bounds
    x, y = np.linspace(left, right, ALONG_EDGE), np.linspace(top, bottom, ALONG_EDGE)
    sides = [(x, np.full_like(x, edge)) for edge in (top, bottom)]
    sides += [(np.full_like(y, edge), y) for edge in (left, right)]
    edge = np.concatenate([np.stack(side, axis=-1) for side in sides])
    return not bool(undistort(distortion, edge)[1].all())


def undistorted_grid(distortion: Sequence[float], bounds: Bounds, nodes: int) -> Floats:
    """Return the origins of a grid of points over an image, (nodes, nodes, 2)."""
    left, top, right, bottom = bounds
    x, y = np.meshgrid(np.linspace(left, right, nodes), np.linspace(top, bottom, nodes))
    grid = np.stack([x, y], axis=-1).reshape(-1, 2)
    return undistort(distortion, grid)[0].reshape(nodes, nodes, 2)


def fisheye_radius(distortion: Sequence[float], angle: float) -> float:
    """Return where OpenCV's fisheye model shows an angle, focal lengths from the middle."""
    k1, k2, k3, k4 = distortion
    z = angle * angle
    return angle * (1.0 + z * (k1 + z * (k2 + z * (k3 + z * k4))))


def widest_angle(distortion: Sequence[float]) -> tuple[float, float]:
    """Return the angle, up to π, to which a fisheye's radius increases, and the radius there."""
    k1, k2, k3, k4 = distortion
    roots = np.roots([9.0 * k4, 7.0 * k3, 5.0 * k2, 3.0 * k1, 1.0])
    turns = [float(root.real) for root in roots if abs(root.imag) < CLOSE and root.real > 0.0]
    angle = min([math.sqrt(turn) for turn in turns] + [math.pi])
    return angle, fisheye_radius(distortion, angle)
