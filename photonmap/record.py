"""The run record: all that is needed to judge a render and to repeat it."""

from __future__ import annotations

import math
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.spectra.munsell import VARIABLE as MUNSELL
from photonmap.spectra.text import ILLUMINANTS

if TYPE_CHECKING:
    from photonmap.kernels.records import Film
    from photonmap.scene import Camera

PACKAGES = ("photonmap", "numpy", "numba", "embreex", "OpenImageIO", "colour-science")


def describe_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    return versions


def describe_code() -> dict[str, str]:
    """Return what the same renders give the same arrays with: versions, and a hash of kernels."""
    from photonmap.kernels.jit import CACHE_FOLDER

    return {**describe_versions(), "kernels": CACHE_FOLDER.name.removeprefix("kernels-")}


def describe_measured_sets() -> dict[str, str | None]:
    """Return the files of measured spectra that colours may be named from; None without one."""
    return {"munsell": os.environ.get(MUNSELL), "illuminants": os.environ.get(ILLUMINANTS)}


def describe_camera(camera: Camera, film: Film) -> dict[str, Any]:
    """Return a camera with its matrices.

    `camera_to_world` is 4×4 with x right, y up and the view along −z, scene units; `intrinsics`
    is 3×3 in pixels, the image's corner at (0, 0), y down.
    """
    origin, target = np.array(camera.origin), np.array(camera.target)
    back = (origin - target) / np.linalg.norm(origin - target)
    right = np.cross(camera.up, back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(back, right), back, origin], axis=1)
    focal = 0.5 * film.height / math.tan(math.radians(camera.fov) / 2.0)
    return {
        "origin": list(camera.origin),
        "target": list(camera.target),
        "up": list(camera.up),
        "fov": camera.fov,
        "camera_to_world": pose.tolist(),
        "intrinsics": [
            [focal, 0.0, 0.5 * film.width],
            [0.0, focal, 0.5 * film.height],
            [0.0, 0.0, 1.0],
        ],
    }
