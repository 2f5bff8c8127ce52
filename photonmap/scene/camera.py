"""The camera: where it stands, what it projects and through which lens; and its checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from typing import Annotated, Any, ClassVar

import numpy as np

from photonmap.errors import InputError, Line
from photonmap.runtime.wording import shown
from photonmap.scene.parameters import (
    Direction,
    Number,
    Part,
    Point,
    Text,
    Vector,
    Whole,
    check_parameters,
    unit,
)
from photonmap.scene.projections import PROJECTIONS, Orthographic, Pinhole, Projection, RayMap

FARTHEST = 1e30  # Largest coordinate of a camera, scene units: depths are float32
_PARALLEL = 1e-6
"""Least sine of the angle between view and up at which the picture has a defined upright."""
FOV = 40.0  # Angle of view where none is given, degrees
NOT_IN_FILES = '/\\:*?"<>|'
"""Characters that a camera's name may not have: it becomes part of the names of files."""
ALL = "all"  # What stands for every camera in place of a name
_Size = partial(Number, unit="scene units", above=0.0, at_most=FARTHEST)
_OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])
"""From OpenCV's axes, y down and the view along z, to OpenGL's."""


@dataclass(frozen=True)
class Lens:
    """A thin lens: what is not at its focus distance is blurred.

    Its size is given by `radius`, or by `f_number` and `focal_length`.

    Parameters
    ----------
    focus : distance, along the view, of the plane that is sharp, scene units
    radius : of the opening, scene units
    f_number : focal length / diameter of the opening
    focal_length : scene units: 0.05 for 50 mm in a scene in metres; it decides the size of the
        opening, and not the angle of view
    blades : sides of the opening, a regular polygon whose corners lie at the radius; 0 for a disk
    rotation : of the polygon, degrees, counter-clockwise in the image
    """

    focus: Annotated[float | None, _Size("focus distance")] = None
    radius: Annotated[float | None, _Size("radius")] = None
    f_number: Annotated[float | None, Number("f-number", above=0.0, such_as="2.8")] = None
    focal_length: Annotated[float | None, _Size("focal length")] = None
    blades: Annotated[int, Whole("number of blades", at_least=3, at_most=64, or_none=True)] = 0
    rotation: Annotated[float, Number("rotation", "degrees")] = 0.0
    kind: ClassVar[str] = "thin"

    @property
    def opening(self) -> float:
        """The radius of a checked lens, scene units."""
        if self.radius is not None:
            return self.radius
        assert self.focal_length is not None
        assert self.f_number is not None
        return 0.5 * self.focal_length / self.f_number

    def find_conflict(self) -> str | None:
        """Return what is wrong with the attributes taken together; None if nothing is."""
        by_number = self.f_number is not None or self.focal_length is not None
        if self.focus is None:
            return "has no focus distance; add focus"
        if self.radius is not None and by_number:
            return "has a radius and an f-number or focal length; give the one or the other"
        if self.radius is None and (self.f_number is None or self.focal_length is None):
            return "has no size; add radius, or f_number and focal_length"
        return None

    def describe(self) -> dict[str, Any]:
        """Return the JSON-able record of a checked lens."""
        others = ("focus", "f_number", "focal_length", "blades", "rotation")
        attributes = {name: getattr(self, name) for name in others}
        return {"kind": self.kind, "radius": self.opening, **attributes}


@dataclass(frozen=True)
class Camera:
    """A camera: a pinhole of an angle of view, unless it has a height or another projection.

    Parameters
    ----------
    origin, target : scene units
    up : any vector that is not parallel to the view
    fov : full vertical angle of a pinhole, degrees
    height : of what an orthographic camera sees, scene units: its rays are parallel; None for a
        pinhole
    projection : in place of `fov` and `height`: `photonmap.Intrinsics`, `Fisheye`,
        `FisheyeIntrinsics`, `Panorama` or `RayMap`
    lens : `photonmap.Lens`, through which what is not in focus is blurred; None for a point
    name : by which one of several cameras is chosen
    """

    origin: Annotated[Vector, Point()]
    target: Annotated[Vector, Point()]
    up: Annotated[Vector, Direction()] = (0.0, 1.0, 0.0)
    fov: Annotated[float, Number("angle of view", "degrees", above=0.0, below=180.0)] = FOV
    height: Annotated[float | None, Number("height", "scene units", above=0.0)] = None
    projection: Annotated[Projection | None, Part("projection", kinds=PROJECTIONS)] = None
    lens: Annotated[Lens | None, Part.of("lens", Lens)] = None
    name: Annotated[str, Text("name")] = ""

    @property
    def model(self) -> Projection:
        """The projection, also of a camera that is described by `fov` or `height`."""
        if self.projection is not None:
            return self.projection
        return Pinhole(self.fov) if self.height is None else Orthographic(self.height)

    @property
    def eye(self) -> Vector | None:
        """The point that all rays leave, scene units; None if they leave several points."""
        model = self.model
        if isinstance(model, RayMap):
            origins = model.array[..., :3].reshape(-1, 3)
            x, y, z = origins[0].tolist()
            return (x, y, z) if (origins == origins[0]).all() else None
        return None if self.lens is not None or isinstance(model, Orthographic) else self.origin

    def changed(self, **values: Any) -> Camera:
        """Return a camera with other values; an angle of view makes it a pinhole."""
        projection: dict[str, Any] = {}
        if "fov" in values:
            projection = {"height": None, "projection": None}
        return replace(self, **{**projection, **values})

    def stereo(self, baseline: float) -> tuple[Camera, Camera]:
        """Return the left and the right one of two parallel cameras about this one.

        Their names end in `_left` and `_right`.

        Parameters
        ----------
        baseline : distance between them, scene units

        Raises
        ------
        InputError : it is not above 0; or the camera is a ray map, whose rays do not move with it
        """
        distance = Number("baseline", "scene units", above=0.0).check(baseline)
        if isinstance(self.model, RayMap):
            raise InputError(
                f"{distance:g} does not go with a ray map, whose rays do not move; give two of them"
            )
        right = 0.5 * distance * frame_of(check_camera(self))[1]
        label = self.name or "camera"

        def moved(side: float, name: str) -> Camera:
            origin, target = (
                tuple((np.array(point, float) + side * right).tolist())
                for point in (self.origin, self.target)
            )
            return replace(self, origin=origin, target=target, name=name)

        return moved(-1.0, f"{label}_left"), moved(1.0, f"{label}_right")

    def describe(self, width: int, height: int) -> dict[str, Any]:
        """Return the JSON-able record of a checked camera over an image, with its matrices.

        `camera_to_world` is 4×4 with x right, y up and the view along −z, scene units, as in
        OpenGL; `camera_to_world_opencv` has y down and the view along z. `intrinsics` is 3×3 in
        pixels, the image's corner at (0, 0), y down; None for panoramas and ray maps. It projects
        directions of depth 1, after the distortion of the kind; that of an orthographic camera
        projects points at any depth.
        """
        view, right, up = frame_of(self)
        pose = np.eye(4)
        pose[:3] = np.stack([right, up, -view, np.array(self.origin)], axis=1)
        matrix = self.model.matrix(width, height)
        return {
            "name": self.name,
            "kind": self.model.kind,
            "origin": list(self.origin),
            "target": list(self.target),
            "up": list(self.up),
            "distortion": [],
            **self.model.describe(),
            "camera_to_world": pose.tolist(),
            "camera_to_world_opencv": (pose @ _OPENCV).tolist(),
            "intrinsics": None if matrix is None else matrix.tolist(),
            "lens": None if self.lens is None else self.lens.describe(),
        }


def check_camera(
    camera: Camera,
    path: str | PathLike[str] | None = None,
    lines: Mapping[str, Line] | None = None,
) -> Camera:
    """Return a camera of attributes of any type, from a file or from code, with plain floats.

    Errors name the file, and the line of each attribute in it. An `InputError` says that it is not
    a camera, a vector is not three finite numbers, target is origin, up is parallel to the view, a
    number is out of its range, a coordinate exceeds 1e30, or projection and lens are not valid or
    do not go together.
    """

    def error(attribute: str, problem: str) -> InputError:
        return InputError(f"camera {attribute} {problem}", path, (lines or {}).get(attribute))

    if not isinstance(camera, Camera):
        remedy = "give a photonmap.Camera, as in Camera((0, 0, 3), (0, 0, 0))"
        raise InputError(f"{shown(camera)} is not a camera; {remedy}")
    checked = Camera(**check_parameters(camera, error))
    for attribute in ("origin", "target", "up"):
        if max(map(abs, getattr(checked, attribute))) > FARTHEST:
            far = f"is too far away; give coordinates up to {FARTHEST:g}"
            raise error(attribute, f"{shown(getattr(camera, attribute))} {far}")
    view = view_of(checked)
    if not view.any():
        problem = "is at the origin of the camera; move one of them"
        raise error("target", f"{shown(camera.target)} {problem}")
    if np.linalg.norm(np.cross(view, unit(np.array(checked.up)))) < _PARALLEL:
        raise error("up", f"{shown(camera.up)} is parallel to the view; choose another direction")
    if conflict := _find_conflict(checked, lines or {}):
        raise error(*conflict)
    return checked


def check_image_size(camera: Camera, size: tuple[int, int]) -> None:
    """Refuse a ray map of another size than that of the image: width and height, pixels."""
    if not isinstance(camera.model, RayMap):
        return
    height, width = camera.model.array.shape[:2]
    if (width, height) != size:
        whose = f"camera {shown(camera.name)}: its" if camera.name else "the camera's"
        raise InputError(
            f"{whose} ray map is of {width}x{height} pixels, and the image of "
            f"{size[0]}x{size[1]}; render at a size of {width}x{height}"
        )


def _find_conflict(camera: Camera, given: Collection[str]) -> tuple[str, str] | None:
    """Return an attribute at odds with the others, and the problem; None if there is none.

    `given` are those that a file has, also where the value is the usual one.
    """
    if camera.name == ALL or set(camera.name) & set(NOT_IN_FILES):
        problem = f"{shown(camera.name)} cannot be part of a file's name; choose another"
        return "name", problem
    has_fov = camera.fov != FOV or "fov" in given
    has_height = camera.height is not None
    if camera.projection is not None and (has_fov or has_height):
        kind = camera.projection.kind
        problem = f"is given besides the projection, {kind}; leave one of them out"
        return "fov" if has_fov else "height", problem
    if "fov" in given and has_height:
        return "fov", "is given besides the height of parallel rays; leave one of them out"
    if camera.lens is not None and not camera.model.takes_lens:
        return "lens", f"does not go with the projection, {camera.model.kind}; leave it out"
    return None


def view_of(camera: Camera) -> np.ndarray:
    """Return a camera's viewing direction, of length 1; 0 if target and origin coincide."""
    return unit(np.array(camera.target) / 2 - np.array(camera.origin) / 2)


def frame_of(camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a checked camera's view, right and up, three orthogonal vectors of length 1."""
    view = view_of(camera)
    right = np.cross(view, unit(np.array(camera.up)))
    right /= np.linalg.norm(right)
    return view, right, np.cross(right, view)
