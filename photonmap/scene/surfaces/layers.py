"""Materials checked, by themselves and in scenes, named by their lobes, or standing for others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from numbers import Real
from typing import Any

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.scene.material import LOBES, Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, Emission, Text, check_parameters, parameters_of
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import (
    Paint,
    Texture,
    check_texture,
    is_black,
    mean_color,
    mean_number,
)
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Spectrum
from photonmap.spectra.fluorescence import most_quanta
from photonmap.spectra.observer import upsample_reflectance

LIKE_AIR = 1e-3
"""By how much an index may lie below 1: that of air is 1.0003, of which some files take account."""
_TOUCHING = 1e-6  # Distance, in sizes of a mesh, up to which boxes count as touching


def check_material(material: Material) -> Material:
    """Return a material in plain floats, with all checked but the values of colours and textures.

    An `InputError` says that the name is not a text, or a number is out of range.
    """

    def error(attribute: str, problem: str) -> InputError:
        return InputError(f"material {material.name!r}: {attribute}: {problem}")

    with naming(f"material {material.name!r}"):
        Text().check(material.name)
    return replace(material, **check_parameters(material, error))


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
    if material.fluorescence is not None:
        _check_fluorescence(material)


def _check_fluorescence(material: Material) -> None:
    """Check that no more photons leave than arrive; of textures, where they are brightest."""
    if material.is_all_glass:
        raise LayerError(material, ("fluorescence", "ior"), "glass has no diffuse base; remove one")
    if material.ior is not None and isinstance(material.transmission, Texture):
        remedy = "what is sent out has no image of it; give the transmission as a number"
        raise LayerError(material, ("fluorescence", "transmission"), remedy)
    amount = material.fluorescence_concentration
    amount = amount.largest if isinstance(amount, Texture) else amount
    reflected, mirrored = _curve_of(material.reflectance), _curve_of(material.mirror)
    at, sent, kept, unit = most_quanta(
        material.fluorescence, amount, lambda nm: reflected(nm) + mirrored(nm)
    )
    if sent + kept > LARGEST_REFLECTANCE:
        other = "mirror" if material.has("mirror") else "reflectance"
        remedy = (
            f"of a {unit} at {at:g} nm they send out {sent:.3g} and {kept:.3g}; keep the sum "
            f"within 1, by a lower {other} where light is taken up, or less concentration"
        )
        raise LayerError(material, ("fluorescence", other), remedy)


def _curve_of(paint: Paint) -> Spectrum:
    """Return a reflectance over wavelength, at its brightest if it is a texture."""
    if isinstance(paint, Spectrum):
        return paint
    if isinstance(paint, SpectralTexture):
        return Spectrum(paint.wavelengths, paint.spectra.max(axis=0))
    return upsample_reflectance(
        np.ones(3) * (paint.largest if isinstance(paint, Texture) else paint)
    )


def check_relative_indices(meshes: Sequence[Mesh]) -> None:
    """Check that where an index is below 1, there is glass to which it can be relative.

    Its bounding box meets that of the mesh; otherwise a `StrandedIndexError` is raised.
    """
    solid = [each for each in meshes if each.material.ior is not None and len(each.vertices)]
    for mesh in solid:
        if is_relative(mesh.material) and not any(_meet(mesh, each) for each in solid):
            raise StrandedIndexError(mesh)


def is_relative(material: Material) -> bool:
    """Return whether an index is relative to what is around."""
    index = material.ior
    return isinstance(index, Real) and material.outside == 1.0 and 0.0 < index < 1.0 - LIKE_AIR


class StrandedIndexError(InputError):
    """An index below 1 of a `mesh` that no glass surrounds."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        super().__init__(
            f"material {mesh.material.name!r}: ior {mesh.material.ior:g} is below 1, relative to "
            f"glass around it, and {mesh.name!r} lies in none; give it relative to air, such as 1.5"
        )


def _meet(mesh: Mesh, other: Mesh) -> bool:
    """Return whether the boxes of two meshes meet, and the other can be around."""
    if other is mesh or other.material.thin or is_relative(other.material):
        return False
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    slack = _TOUCHING * float(np.ptp(other.vertices))
    return bool(
        (low <= other.vertices.max(axis=0) + slack).all()
        and (high >= other.vertices.min(axis=0) - slack).all()
    )


def name_kind(material: Material) -> str:
    """Return how a material reflects or transmits, in a few words."""
    opaque = "" if is_black(material.reflectance) else "diffuse"
    if material.fluorescence is not None:
        opaque = f"fluorescent {opaque}".strip()
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
