"""Materials checked and named by their lobes, and those that stand for others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.scene.material import LOBES, Material
from photonmap.scene.parameters import Colored, Emission, Text, parameters_of
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture, check_texture, is_black, mean_color, mean_number
from photonmap.spectra.curves import LARGEST_REFLECTANCE


def check_material(material: Material) -> Material:
    """Return a material in plain floats, with all checked but the values of colours and textures.

    An `InputError` says that the name is not a text, or a number is out of range.
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

    An `InputError` says that values are no reflectance, opacity or radiance, or that there are
    spectra where colours or numbers belong.
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


class LayerError(InputError):
    """Layers of a material that do not go together: `attributes` names the two."""

    def __init__(self, material: Material, attributes: tuple[str, str], remedy: str) -> None:
        self.attributes = attributes
        layer, other = attributes
        super().__init__(f"material {material.name!r}: {layer} does not go with {other}: {remedy}")


def check_layers(material: Material) -> None:
    """Check that the layers of a material go together, or raise `LayerError`."""
    for name, lobe in LOBES.items():
        for other, remedy in lobe.clashes.items():
            if material.has(name) and material.has(other):
                raise LayerError(material, (name, other), remedy)


def name_kind(material: Material) -> str:
    """Return how a material reflects or transmits, in a few words."""
    opaque = "" if is_black(material.reflectance) else "diffuse"
    for name, lobe in LOBES.items():
        if material.has(name):
            opaque = lobe.over.format(opaque) if opaque else lobe.alone
    opaque = opaque or "black"
    if material.ior is None:
        return opaque
    is_rough = bool(material.roughness) or material.is_anisotropic
    glass = f"{'rough ' * is_rough}{'thin ' * bool(material.thin)}glass"
    return glass if material.is_all_glass else f"part {glass}, part {opaque}"


def without_images(material: Material, base: bool = False) -> Material:
    """Return a material without relief, and with the mean of the images of its lobes.

    It is the same one if it has none. With `base`, also with the mean of its other images: of
    reflectance, emission, opacity and glass.
    """
    even: dict[str, Any] = dict.fromkeys(("relief", "coat_relief", "anisotropy_map"))
    of_lobes = {each for name, lobe in LOBES.items() for each in (name, *lobe.parameters)}
    for name, parameter in parameters_of(Material).items():
        if parameter.textured and (base or name in of_lobes):
            mean = mean_color if isinstance(parameter, Colored) else mean_number
            even[name] = mean(getattr(material, name))
    changed = {name: value for name, value in even.items() if value is not getattr(material, name)}
    return replace(material, **changed) if changed else material


def explicit(material: Material) -> Material:
    """Return the same material, for files that know no metals by name: with what they stand for."""
    if not material.is_metal_mirror:
        return replace(material, glossy_edge=material.edge)
    metal = material.mirror
    return replace(material, mirror=0.0, glossy=metal, glossy_edge=material.edge, roughness=0.0)
