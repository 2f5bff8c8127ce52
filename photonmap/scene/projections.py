"""Projections: where on the image a camera shows what lies in a direction, one class a kind."""

from __future__ import annotations

import math
import zipfile
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import brief
from photonmap.scene.distortion import find_fold, widest_angle
from photonmap.scene.images import read_channels
from photonmap.scene.parameters import File, Number, Numbers, Whole, parameters_of

PROJECTIONS: dict[str, type[Projection]] = {}
"""The kinds of projections, by their `type` in TOML files."""
_LARGEST = 1 << 20
"""Pixels of a calibrated image along a side, at most."""
_Focal = Annotated[float, Number("focal length", "pixels", above=0.0)]
_OtherFocal = Annotated[float | None, Number("focal length", "pixels", above=0.0)]
_Center = Annotated[float | None, Number("principal point", "pixels")]
_Size = Annotated[
    tuple[int, int],
    Numbers("size in pixels", counts=(2,), each=Whole(at_least=1, at_most=_LARGEST)),
]
Rays = NDArray[np.float64]
CHANNELS = tuple(f"{part}.{axis}" for part in ("origin", "direction") for axis in "XYZ")
"""Channels of an OpenEXR file."""
_NAME = "rays"
"""The array of an NPZ file."""
_FARTHEST = 1e30


@dataclass(frozen=True)
class Projection:
    """How a camera maps directions to its image.

    A subclass is a dataclass with a `kind` of its own, whose annotations declare its parameters.
    """

    kind: ClassVar[str]
    takes_lens: ClassVar[bool] = False
    """whether light may enter through more than a point"""
    has_axis: ClassVar[bool] = False
    """whether depth is measured along the view; otherwise it is the distance"""

    def __init_subclass__(cls) -> None:
        """Enter the class under its kind."""
        if "kind" in vars(cls):
            PROJECTIONS[cls.kind] = cls

    def find_conflict(self) -> str | None:
        """Return what is wrong with the attributes taken together; None if nothing is."""
        return None

    def matrix(self, width: int, height: int) -> NDArray[np.float64] | None:
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

    def matrix(self, width: int, height: int) -> NDArray[np.float64]:
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

    def matrix(self, width: int, height: int) -> NDArray[np.float64]:
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

    def matrix(self, width: int, height: int) -> NDArray[np.float64]:
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

    def matrix(self, width: int, height: int) -> NDArray[np.float64]:
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
    def array(self) -> NDArray[np.float64]:
        """The rays, (H, W, 6)."""
        assert isinstance(self.rays, np.ndarray)
        return self.rays

    def __eq__(self, other: object) -> bool:
        """Compare all rays."""
        return isinstance(other, RayMap) and np.array_equal(self.array, other.array)

    def __hash__(self) -> int:
        """Hash the size."""
        return hash(self.array.shape)


def _matrix(fx: float, fy: float, cx: float, cy: float) -> NDArray[np.float64]:
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def read_rays(path: str | PathLike[str]) -> Rays:
    """Read rays, (H, W, 6), from NPZ or OpenEXR; an `InputError` says what the file lacks."""
    path = Path(path)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    values = _read_exr(path) if path.suffix.lower() == ".exr" else _read_npz(path)
    return check_rays(values, str(path))


def check_rays(values: Any, label: str) -> Rays:
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
        with np.load(path, allow_pickle=False) as file:
            if isinstance(file, np.ndarray) or _NAME not in file:
                raise InputError(f"has no array {_NAME!r}; save it as NPZ with this name", path)
            return file[_NAME]
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
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
