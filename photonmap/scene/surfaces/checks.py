"""Checks of a material, but for the values of its colours and textures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from photonmap.errors import naming
from photonmap.scene.material import Material
from photonmap.scene.parameters import Text, parameters_of
from photonmap.scene.textures import Texture


def check_material(material: Material) -> Material:
    """Check all of a material but the values of its colours and textures.

    Returns
    -------
    Material, its numbers as plain floats

    Raises
    ------
    InputError : the name is not a text, or a number is out of range
    """
    plain: dict[str, Any] = {}
    with naming(f"material {material.name!r}"):
        Text().check(material.name)
    for attribute, parameter in parameters_of(Material).items():
        value = getattr(material, attribute)
        if value is not None and not (parameter.textured and isinstance(value, Texture)):
            with naming(f"material {material.name!r}: {attribute}"):
                plain[attribute] = parameter.check(value)
    return replace(material, **plain)
