"""What a glTF file says otherwise than the scene that it was written for."""

from __future__ import annotations

from typing import Any

import numpy as np

from photonmap.scene.camera import Camera, frame_of
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.parameters import (
    Emission,
    Parameter,
    Part,
    Reflectance,
    Text,
    parameters_of,
)
from photonmap.scene.surfaces.explicit import explicit
from photonmap.scene.surfaces.relief import BumpMap
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Spectrum


def _close(a: Any, b: Any) -> bool:
    """Return whether numbers are the same to kernels, which compute with float32."""
    return np.allclose(a, b, rtol=1e-9, atol=1e-12)


def find_material_changes(wanted: Material, read: Material) -> dict[str, Any]:
    """Return the attributes of a material that were read otherwise; textures stay as they are."""
    found, wanted = {}, explicit(wanted)
    for attribute, parameter in parameters_of(Material).items():
        value, other = getattr(wanted, attribute), getattr(read, attribute)
        if isinstance(parameter, Text) or isinstance(value, Texture):
            continue
        if attribute == "coat_relief":
            value, other = wanted.own_coat_relief, read.own_coat_relief
            if type(value) is not type(other):
                found[attribute] = value
            continue
        if isinstance(parameter, Part):
            if isinstance(value, BumpMap) or (attribute == "dispersion" and value != other):
                found[attribute] = value
            continue
        if attribute == "abbe" and wanted.dispersion is not None:
            continue
        if attribute == "roughness" and not wanted.is_glossy and wanted.ior is None:
            continue
        if not _is_same(parameter, value, other):
            found[attribute] = value
    return found


def _is_same(parameter: Parameter, value: Any, other: Any) -> bool:
    """Return whether two values look the same in any bands.

    An equal triple is D65 as an emission, but a constant spectrum as a reflectance.
    """
    if isinstance(value, Spectrum):
        return False
    if isinstance(other, Texture):
        if np.ptp(other.image.texels, axis=(0, 1)).any():
            return False
        other = other.mean  # white, to hold opacity
    if value is None or other is None:
        return value is other
    if isinstance(parameter, Reflectance):
        return _close(np.ones(3) * value, np.ones(3) * other)
    if isinstance(parameter, Emission) and np.any(value) and np.ndim(value) != np.ndim(other):
        return False
    return _close(value, other)


def is_same_view(wanted: Camera, read: Camera) -> bool:
    """Return whether two checked cameras give the same picture, and have the same name."""
    if wanted.projection is not None or wanted.lens is not None:
        return False
    same_place = _close([wanted.origin, *frame_of(wanted)], [read.origin, *frame_of(read)])
    same_size = _close([wanted.fov, wanted.height or 0.0], [read.fov, read.height or 0.0])
    return same_place and same_size and (wanted.name or "camera") == read.name


def is_same_light(wanted: Light, read: Light | None) -> bool:
    """Return whether a light was read as it was, up to rounding; `read` is None where it was not.

    The target of a spot only gives a direction, as does the length of a direction.
    """
    if type(wanted) is not type(read) or wanted.group not in ("", wanted.name):
        return False
    assert read is not None
    declared = parameters_of(type(wanted))[wanted.color_attribute or ""]
    if not _is_same(declared, wanted.color, read.color):
        return False
    return _close(_shape(wanted), _shape(read))


def _shape(light: Light) -> list[float]:
    """Return where a light stands and how it shines."""
    emitter = light.emitter()
    return [*(emitter.position or ()), *emitter.axis, *emitter.cosines, emitter.cone]
