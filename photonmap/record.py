"""The run record: all that is needed to judge a render and to repeat it."""

from __future__ import annotations

import math
import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.camera import frame_of
from photonmap.spectra.munsell import VARIABLE as MUNSELL
from photonmap.spectra.text import ILLUMINANTS

if TYPE_CHECKING:
    from photonmap.kernels.records import Film
    from photonmap.scene import Camera

PACKAGES = ("photonmap", "numpy", "numba", "embreex", "OpenImageIO", "colour-science")


def describe_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


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
    view, right, up = frame_of(camera)
    pose = np.eye(4)
    pose[:3] = np.stack([right, up, -view, np.array(camera.origin)], axis=1)
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
