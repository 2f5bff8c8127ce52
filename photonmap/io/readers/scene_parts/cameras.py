"""Read the cameras of a TOML scene, `[camera]` or `[[camera]]`."""

from __future__ import annotations

from typing import Any

from photonmap.errors import InputError
from photonmap.io.readers.toml import Toml, parse_value
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.parameters import Part, parameters_of
from photonmap.scene.projections import RayMap
from photonmap.scene.scene import check_names

SECTION = "camera"
_REQUIRED = ("origin", "target")
_UNMOVED = {"origin": (0.0, 0.0, 0.0), "target": (0.0, 0.0, -1.0)}
"""Of a ray map, which holds its rays in world space"""
_BASELINE = "baseline"
_KEYS = (*parameters_of(Camera), _BASELINE)


def read_cameras(toml: Toml) -> list[Camera]:
    """Read `[camera]`, or all sections `[[camera]]`, in their order.

    Raises
    ------
    InputError : a key is unknown or missing, a value is not valid, or several cameras do not have
        different names
    """
    if SECTION not in toml.sections:
        return []
    sections = toml.sections[SECTION]
    if not isinstance(sections, list):
        section = toml.section("[camera]", _KEYS, SECTION)
        return _read(toml, "[camera]", section, SECTION)
    cameras: list[Camera] = []
    for index, section in enumerate(sections):
        at = (SECTION, index)
        if not isinstance(section, dict):
            raise toml.error("camera is not a section; write [[camera]] above its keys", SECTION)
        toml.check_known(_KEYS, "[[camera]] key", *at)
        cameras += _read(toml, "[[camera]]", section, *at)
        if len(sections) > 1:
            with toml.naming(*at, *(["name"] * ("name" in section))):
                check_names(cameras)
    return cameras


def _read(toml: Toml, label: str, section: dict[str, Any], *at: str | int) -> list[Camera]:
    """Read one section; two cameras where it has a baseline."""
    lines = {key: toml.line(*at, key) for key in section}
    values = {key: value for key, value in section.items() if key != _BASELINE}
    for key, parameter in parameters_of(Camera).items():
        if isinstance(parameter, Part) and key in values:
            try:
                values[key] = parse_value(parameter, values[key], toml.path.parent)
            except InputError as error:
                raise InputError(f"camera {key} {error}", toml.path, lines[key]) from None
    pose = _UNMOVED if isinstance(values.get("projection"), RayMap) else {}
    values = {**pose, **values}
    for key in _REQUIRED:
        if key not in values:
            raise toml.error(f"{label} lacks {key}; add {key} = [x, y, z]", *at)
    camera = check_camera(Camera(**values), toml.path, lines)
    if _BASELINE not in section:
        return [camera]
    try:
        return list(camera.stereo(section[_BASELINE]))
    except InputError as error:
        problem = f"camera {_BASELINE} {error}"
        raise InputError(problem, toml.path, lines[_BASELINE]) from None
