"""Cameras as kernels take them, and the camera of scenes without one."""

from __future__ import annotations

import math

import numpy as np

from photonmap.compile.frame import Frame
from photonmap.errors import InputError
from photonmap.kernels.camera import cameras
from photonmap.kernels.core import passes
from photonmap.runtime.options import check_size
from photonmap.runtime.wording import shown
from photonmap.scene import projections
from photonmap.scene.camera import FOV, Camera, Lens, check_camera, check_image_size, frame_of
from photonmap.scene.parameters import Vector, parameters_of, unit, vector
from photonmap.spectra.curves import Floats

_NODES = 33  # Rows and columns of the table of undistorted points from which distortion is inverted
_NOTHING = np.zeros(3)
_NO_TABLE = np.zeros((1, 1, 1))
_NO_LENS = passes.Lens(False, (0.0,) * 3, (0.0,) * 3, 0.0, 0)
_LINEAR = passes.Projection((1.0, 1.0), (0.0, 0.0), (0.0,) * 5, (0.0, 0.0), _NO_TABLE)
"""What a projection that needs none of it has."""
_NO_OPTICS = passes.Optics(_NO_LENS, _LINEAR)
_MARGIN = 1.05
_AZIMUTH, _ELEVATION = math.radians(30.0), math.radians(25.0)
"""Of the camera, to the right of the front and above it."""


def camera_rays(camera: Camera, size: tuple[int, int]) -> Floats:
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
    cameras.fill_rays(record, x.ravel(), y.ravel(), rays)
    return rays.reshape(height, width, 6)


def compile_camera(camera: Camera, frame: Frame, size: tuple[int, int]) -> passes.Camera:
    """Return a checked camera over an image of width × height pixels, in the kernels' units.

    A ray map of another size is an `InputError`.
    """
    check_image_size(camera, size)
    width, height = size
    origin = frame.into(np.array(camera.origin))
    view, right, up = frame_of(camera)
    match camera.model:
        case projections.Pinhole(fov):
            pixel = 2.0 * np.tan(np.radians(fov) / 2.0) / height
            corner = view + pixel * (0.5 * height * up - 0.5 * width * right)
            record = _record(cameras.PINHOLE, origin, corner, pixel * right, -pixel * up)
        case projections.Orthographic(tall):
            pixel = tall / frame.size / height
            corner = origin + pixel * (0.5 * height * up - 0.5 * width * right)
            record = _record(cameras.ORTHOGRAPHIC, view, corner, pixel * right, -pixel * up)
        case projections.Intrinsics() as model if not any(model.distortion):
            (fx, _, cx), (_, fy, cy), _ = model.matrix(width, height)
            corner = view + cy / fy * up - cx / fx * right
            record = _record(cameras.PINHOLE, origin, corner, right / fx, -up / fy)
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
    model: projections.Projection, frame: Frame, size: tuple[int, int]
) -> tuple[int, passes.Projection]:
    """Return the kind and the record of a projection that is not linear."""
    matrix = model.matrix(*size)
    plain = _LINEAR
    if matrix is not None:
        (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
        plain = _LINEAR._replace(focal=(fx, fy), center=(cx, cy))
    match model:
        case projections.Panorama():
            width, height = size
            return cameras.PANORAMA, _LINEAR._replace(
                focal=(0.5 * width / math.pi, height / math.pi), center=(0.5 * width, 0.5 * height)
            )
        case projections.RayMap():
            rays = np.array(model.array)
            rays[..., :3] = frame.into(rays[..., :3])
            return cameras.RAY_MAP, _LINEAR._replace(table=rays)
        case projections.Fisheye(fov):
            widest = math.radians(fov) / 2.0
            return cameras.FISHEYE, plain._replace(reach=(widest, widest))
        case projections.FisheyeIntrinsics():
            widest, radius = projections.widest_angle(model.coefficients)
            return cameras.FISHEYE, plain._replace(
                distortion=(*model.coefficients, 0.0), reach=(radius, widest)
            )
        case projections.Intrinsics():
            grid = projections.undistorted_grid(
                model.coefficients, model.normalized_corners, _NODES
            )
            reach = float(size[0]), float(size[1])
            return cameras.DISTORTED, plain._replace(
                distortion=model.coefficients, reach=reach, table=grid
            )
    raise AssertionError(model)


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


def _plain(vector: np.ndarray) -> Vector:
    x, y, z = map(float, vector)
    return x, y, z


def frame_scene(
    vertices: Floats, aspect: float = 1.0, up: Vector = (0.0, 1.0, 0.0), fov: float = FOV
) -> Camera:
    """Look at a scene from the front, right and above, so that it fits the image with a margin.

    The front is +z where y is up, and −y where z is up. Vertices, (V, 3), are in scene units;
    `aspect` is width / height, `fov` the full vertical angle, degrees. An `InputError` says that
    `up` is no direction, or `fov` no angle.
    """
    upright = unit(np.array(vector(up) or (0.0, 0.0, 0.0)))
    if not upright.any():
        raise InputError(f"up {shown(up)} is not a direction; give three numbers, as in (0, 0, 1)")
    angle = parameters_of(Camera)["fov"].check(fov)
    front = np.array([0.0, 0.0, 1.0] if abs(upright[2]) < 0.9 else [0.0, -1.0, 0.0])
    front -= (front @ upright) * upright
    front /= np.linalg.norm(front)
    side = math.cos(_AZIMUTH) * front + math.sin(_AZIMUTH) * np.cross(upright, front)
    toward = math.cos(_ELEVATION) * side + math.sin(_ELEVATION) * upright
    right = np.cross(upright, toward)
    right /= np.linalg.norm(right)
    center = 0.5 * vertices.min(axis=0) + 0.5 * vertices.max(axis=0)
    slope = math.tan(math.radians(angle) / 2.0) / _MARGIN
    offsets = vertices - center
    depths = offsets @ toward
    aside, width = _fit(offsets @ right, depths, slope * aspect)
    above, height = _fit(offsets @ np.cross(toward, right), depths, slope)
    target = center + aside * right + above * np.cross(toward, right)
    origin = target + (max(width, height) or 1.0) * toward
    return Camera(_plain(origin), _plain(target), _plain(upright), angle)


def _fit(across: Floats, depths: Floats, slope: float) -> tuple[float, float]:
    """Return where two planes that touch all points from both sides meet, across and in depth.

    Depths of the points, (V,), increase towards the camera; the slope of the planes is half their
    distance over the depth at which they are so far apart.
    """
    one, other = (slope * depths + across).max(), (slope * depths - across).max()
    return float(one - other) / 2.0, float(one + other) / (2.0 * slope)
