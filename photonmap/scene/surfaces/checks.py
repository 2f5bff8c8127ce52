"""Checks of a material, but for the values of its colours."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.scene.material import Material
from photonmap.scene.parameters import Emission, Text, parameters_of
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture, check_texture
from photonmap.spectra.curves import LARGEST_REFLECTANCE


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


def check_textures(material: Material) -> None:
    """Check the values of a material's textures; those of relief are part of `check_material`.

    Raises
    ------
    InputError
        a texture has values that are no reflectance, opacity or radiance, or has spectra where
        colours or numbers belong
    """
    for attribute, parameter in parameters_of(Material).items():
        paint = getattr(material, attribute)
        if not (parameter.textured and isinstance(paint, Texture)):
            continue
        with naming(f"material {material.name!r}: {attribute}"):
            if isinstance(paint, SpectralTexture) and attribute != "reflectance":
                raise InputError("only reflectance may be a SpectralTexture; give a Texture")
            is_light = isinstance(parameter, Emission)
            check_texture(paint, np.inf if is_light else LARGEST_REFLECTANCE)
