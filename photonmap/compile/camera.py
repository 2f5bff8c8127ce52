"""Cameras as kernels take them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.frame import Frame
from photonmap.kernels.camera.cameras import (
    DISTORTED,
    FISHEYE,
    ORTHOGRAPHIC,
    PANORAMA,
    PINHOLE,
    RAY_MAP,
)
from photonmap.kernels.camera.rays import fill_rays
from photonmap.kernels.core import passes
from photonmap.runtime.options import check_size
from photonmap.scene.camera import Camera, check_camera, check_image_size, frame_of
from photonmap.scene.distortion import undistorted_grid, widest_angle
from photonmap.scene.lens import Lens
from photonmap.scene.projections import (
    Fisheye,
    FisheyeIntrinsics,
    Intrinsics,
    Orthographic,
    Panorama,
    Pinhole,
    Projection,
    RayMap,
)

_NODES = 33
"""Rows and columns of the table of undistorted points from which distortion is inverted."""
_NOTHING = np.zeros(3)
_NO_TABLE = np.zeros((1, 1, 1))
_NO_LENS = passes.Lens(False, (0.0,) * 3, (0.0,) * 3, 0.0, 0)
_LINEAR = passes.Projection((1.0, 1.0), (0.0, 0.0), (0.0,) * 5, (0.0, 0.0), _NO_TABLE)
"""What a projection that needs none of it has."""
_NO_OPTICS = passes.Optics(_NO_LENS, _LINEAR)


def camera_rays(camera: Camera, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return the rays through the centres of all pixels, and of the lens: (H, W, 6), scene units.

    Of each, the origin and a direction of any length, in world space; (0, 0, 0) where a fisheye
    sees nothing. `photonmap.RayMap` takes such an array.

    Parameters
    ----------
    size : width and height of the image, pixels

    Raises
    ------
    InputError : the camera or the size is not valid
    """
    checked, (width, height) = check_camera(camera), check_size(size)
    record = compile_camera(checked, Frame(np.zeros(3), 1.0), (width, height))
    y, x = np.mgrid[:height, :width] + 0.5
    rays = np.empty((width * height, 6))
    fill_rays(record, x.ravel(), y.ravel(), rays)
    return rays.reshape(height, width, 6)


def compile_camera(camera: Camera, frame: Frame, size: tuple[int, int]) -> passes.Camera:
    """Return a checked camera over an image, in the kernels' units.

    Parameters
    ----------
    size : width and height of the image, pixels

    Raises
    ------
    InputError : the camera is a ray map of another size
    """
    check_image_size(camera, size)
    width, height = size
    origin = frame.into(np.array(camera.origin))
    view, right, up = frame_of(camera)
    match camera.model:
        case Pinhole(fov):
            pixel = 2.0 * np.tan(np.radians(fov) / 2.0) / height
            corner = view + pixel * (0.5 * height * up - 0.5 * width * right)
            record = _record(PINHOLE, origin, corner, pixel * right, -pixel * up)
        case Orthographic(tall):
            pixel = tall / frame.size / height
            corner = origin + pixel * (0.5 * height * up - 0.5 * width * right)
            record = _record(ORTHOGRAPHIC, view, corner, pixel * right, -pixel * up)
        case Intrinsics() as model if not any(model.distortion):
            (fx, _, cx), (_, fy, cy), _ = model.matrix(width, height)
            corner = view + cy / fy * up - cx / fx * right
            record = _record(PINHOLE, origin, corner, right / fx, -up / fy)
        case model:
            kind, projection = _project(model, frame, size)
            optics = passes.Optics(_NO_LENS, projection)
            record = _record(kind, origin, view, right, -up)._replace(optics=optics)
    if camera.model.has_axis:
        record = record._replace(axis=_plain(view))
    if camera.lens is not None:
        optics = record.optics or _NO_OPTICS
        lens = _compile_lens(camera.lens, frame, right, up)
        record = record._replace(optics=optics._replace(lens=lens))
    return record


def _project(
    model: Projection, frame: Frame, size: tuple[int, int]
) -> tuple[int, passes.Projection]:
    """Return the kind and the record of a projection that is not linear."""
    matrix = model.matrix(*size)
    plain = _LINEAR if matrix is None else _calibrated(matrix)
    match model:
        case Panorama():
            width, height = size
            return PANORAMA, _LINEAR._replace(
                focal=(0.5 * width / math.pi, height / math.pi), center=(0.5 * width, 0.5 * height)
            )
        case RayMap():
            return RAY_MAP, _LINEAR._replace(table=_compile_rays(model, frame))
        case Fisheye(fov):
            widest = math.radians(fov) / 2.0
            return FISHEYE, plain._replace(reach=(widest, widest))
        case FisheyeIntrinsics():
            widest, radius = widest_angle(model.coefficients)
            return FISHEYE, plain._replace(
                distortion=(*model.coefficients, 0.0), reach=(radius, widest)
            )
        case Intrinsics():
            grid = undistorted_grid(model.coefficients, model.normalized_corners, _NODES)
            reach = float(size[0]), float(size[1])
            return DISTORTED, plain._replace(distortion=model.coefficients, reach=reach, table=grid)
    raise AssertionError(model)


def _calibrated(matrix: NDArray[np.float64]) -> passes.Projection:
    (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
    return _LINEAR._replace(focal=(fx, fy), center=(cx, cy))


def _compile_rays(model: RayMap, frame: Frame) -> NDArray[np.float64]:
    """Return the rays of a map, in the kernels' units."""
    rays = np.array(model.array)
    rays[..., :3] = frame.into(rays[..., :3])
    return rays


def _compile_lens(lens: Lens, frame: Frame, right: np.ndarray, up: np.ndarray) -> passes.Lens:
    assert lens.focus is not None
    radius, angle = lens.opening / frame.size, math.radians(lens.rotation)
    turned = math.cos(angle) * right + math.sin(angle) * up
    upright = math.cos(angle) * up - math.sin(angle) * right
    nearness = frame.size / lens.focus
    return passes.Lens(
        True, _plain(radius * turned), _plain(radius * upright), nearness, lens.blades
    )


def _record(kind: int, *vectors: np.ndarray) -> passes.Camera:
    return passes.Camera(kind, *map(_plain, vectors), _plain(_NOTHING), None)


def _plain(vector: np.ndarray) -> Any:
    return tuple(map(float, vector))
