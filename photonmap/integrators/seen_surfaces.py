"""Material data behind the first-hit buffers: what surfaces reflect, one row each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.compile.surfaces.glossy import TERMS, mean_albedo
from photonmap.kernels.bsdf.models import GLOSSY
from photonmap.kernels.core.lobe_records import Coats
from photonmap.kernels.core.records import GLASS, Scattering, Specular
from photonmap.kernels.integrators.first_hits import (
    look_up_coats,
    look_up_glass,
    look_up_lobes,
    look_up_sheens,
)

Array = NDArray[Any]


class Coat(NamedTuple):
    """Clear coats of R surfaces: each (R, 1), but for their lobes."""

    weight: Array
    """fraction of the surface that is covered"""
    f0: Array
    """reflectance at normal incidence"""
    lobes: Array
    """(R, 8) as `Surfaces.lobes`"""

    @property
    def mean(self) -> Array:
        """Reflectance of light from all around."""
        return mean_albedo(self.f0, self.lobes[:, 1:])

    def over(self, base: Array, light: Array) -> tuple[Array, Array]:
        """Return what the coat reflects, and by what it multiplies what the base does.

        Parameters
        ----------
        base : (R, N) albedo of all of the base, for light of some distribution
        light : (R, 1) what the coat itself reflects of it
        """
        through = (1.0 - light) ** 2 / (1.0 - light * base)
        return self.weight * light, 1.0 - self.weight + self.weight * through


class Sheen(NamedTuple):
    """Sheen of R surfaces."""

    color: Array
    """(R, N), 0 where there is none"""
    albedo: Array
    """(R, 1) reflectance of light from all around for a colour of 1"""


class Specularity(NamedTuple):
    """Specular lobes of R surfaces."""

    kind: Array
    """(R,)"""
    mirror: Array
    """(R, N) reflectance of mirrors, of metals at normal incidence"""
    ior: Array
    """(R,)"""
    alpha: Array
    """(R,) 0 of what is smooth"""
    share: Array
    """(R,) fraction that is glass, of glass"""


class Surfaces(NamedTuple):
    """What surfaces reflect: R materials, or as many points where textures give their lobes."""

    reflectance: Array
    """(R, N) diffuse albedo"""
    model: Array
    """(R,) of `kernels.bsdf.models`"""
    glossy: Array
    """(R, N) reflectance of the glossy lobe at normal incidence"""
    lobes: Array
    """(R, 8) its α, its mean albedos at the Fresnel terms of `Scattering.albedos`, and the mean of
    its `kernels.core.fresnel.rise`"""
    dip: Array
    """(R, 4, N) by which metals reflect less, as `Scattering.dip`"""
    specular: Specularity | None
    """None where there is none"""
    is_thin: Array
    """(R,)"""
    coat: Coat | None
    """None where no surface has one"""
    sheen: Sheen | None
    """likewise"""

    @property
    def is_glossy(self) -> Array:
        """Which have a glossy lobe, (R,), be it below a coat or a sheen."""
        return np.asarray(self.model == GLOSSY)

    @property
    def glass_share(self) -> Array:
        """Which fraction of each is glass that scatters, (R,)."""
        if self.specular is None:
            return np.zeros(len(self.model))
        is_glass = (self.specular.kind == GLASS) | self.is_thin
        return np.where(is_glass, self.specular.share, 0.0)


def has_textured_lobes(compiled: CompiledScene) -> bool:
    """Return whether textures say how some surfaces scatter."""
    scattering, specular = compiled.scattering, compiled.specular
    if scattering is not None:
        sheens = scattering.sheens
        if scattering.maps is not None or (sheens is not None and sheens.maps is not None):
            return True
    if specular is None:
        return False
    return specular.maps is not None or (
        specular.share is not None and specular.share.maps is not None
    )


def surfaces_of_materials(compiled: CompiledScene) -> Surfaces:
    """Return what materials reflect, their textures counting with their means."""
    reflectance, scattering = compiled.materials.reflectance, compiled.scattering
    count = len(reflectance)
    model, glossy = np.zeros(count, np.uint8), np.zeros_like(reflectance)
    lobes, dip = np.zeros((count, 2 + TERMS)), np.zeros((count, 0, 0), np.float32)
    coat = sheen = None
    if scattering is not None:
        model, glossy = scattering.below, scattering.specular
        means = scattering.albedos[:count, :, -1]
        lobes = np.column_stack([scattering.parameters[:, 0], means, scattering.parameters[:, 4]])
        dip = scattering.dip
        if scattering.coats is not None:
            coat = _coat(scattering, scattering.coats)
        if (sheens := scattering.sheens) is not None:
            sheen = Sheen(sheens.color, sheens.albedo[sheens.row, -1:])
    specular = _specularity(compiled.specular)
    return Surfaces(reflectance, model, glossy, lobes, dip, specular, compiled.is_thin, coat, sheen)


def surfaces_at_points(compiled: CompiledScene, triangle: Array, barycentrics: Array) -> Surfaces:
    """Return what R points reflect, as textures say.

    Parameters
    ----------
    triangle : (R,) int32, rows of `Geometry.triangles`
    barycentrics : (R, 2) float32, of the second and third corner
    """
    plain, scattering = surfaces_of_materials(compiled), compiled.scattering
    material = compiled.geometry.material[triangle]
    places = np.ascontiguousarray(triangle), np.ascontiguousarray(barycentrics)
    tables = plain.reflectance, plain.glossy, plain.lobes
    reflectance, glossy, lobes = (np.ascontiguousarray(table[material]) for table in tables)
    coat, specular, sheen = plain.coat, plain.specular, plain.sheen
    arrays = compiled.arrays
    if sheen is not None:
        sheen = Sheen(*(np.ascontiguousarray(rows[material]) for rows in sheen))
        if (sheens := arrays.scattering.sheens).maps:
            look_up_sheens(arrays.geometry, sheens, sheens.maps, *places, sheen.color)
    if scattering is not None and (maps := scattering.maps) is not None:
        look_up_lobes(arrays, arrays.scattering, maps, *places, reflectance, glossy, lobes)
        if coat is not None:
            coat = Coat(*(np.ascontiguousarray(rows[material]) for rows in coat))
            found = coat.weight[:, 0], coat.lobes
            look_up_coats(arrays.geometry, arrays.scattering, maps, *places, *found)
    elif coat is not None:
        coat = Coat(*(rows[material] for rows in coat))
    if specular is not None:
        specular = Specularity(*(np.ascontiguousarray(rows[material]) for rows in specular))
        found = specular.alpha, specular.share
        look_up_glass(arrays.geometry, arrays.specular, *places, *found)
    return Surfaces(
        reflectance,
        plain.model[material],
        glossy,
        lobes,
        plain.dip[material],
        specular,
        plain.is_thin[material],
        coat,
        sheen,
    )


def _coat(scattering: Scattering, coats: Coats) -> Coat:
    """Return the clear coats of materials."""
    albedos = scattering.albedos[np.maximum(coats.row, 0), :, -1]
    lobes = np.column_stack([coats.alpha, albedos, coats.mean_rise])
    return Coat(coats.weight[:, None], coats.f0[:, None], lobes)


def _specularity(specular: Specular | None) -> Specularity | None:
    """Return the specular lobes of materials, textures counting with their means."""
    if specular is None:
        return None
    ones = np.ones(len(specular.kind))
    alpha = specular.alpha if len(specular.alpha) else 0.0 * ones
    share = ones if specular.share is None else specular.share.value
    return Specularity(specular.kind, specular.mirror, specular.ior, alpha, share)
