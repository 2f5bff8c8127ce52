"""Material data behind the first-hit buffers: what surfaces reflect, one row each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.compile.surfaces.glossy import TERMS, mean_albedo
from photonmap.kernels.bsdf.models import GLOSSY
from photonmap.kernels.core.records import GLASS, Specular
from photonmap.kernels.integrators.first_hits import FirstHits, SurfaceRows, describe_surfaces

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

        The base has an albedo, (R, N), for light of some distribution, of which the coat itself
        reflects `light`, (R, 1).
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
    glass: Array
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
    covering: Array
    """(R,) reflectance at normal incidence of what covers the base beside bare metal; -1 if none is
    """
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
    def glass_fraction(self) -> Array:
        """Which fraction of each is glass that scatters, (R,)."""
        if self.specular is None:
            return np.zeros(len(self.model))
        is_glass = (self.specular.kind == GLASS) | self.is_thin
        return np.where(is_glass, self.specular.glass, 0.0)


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
        specular.glass is not None and specular.glass.maps is not None
    )


def surfaces_of_materials(compiled: CompiledScene) -> Surfaces:
    """Return what materials reflect, their textures counting with their means."""
    reflectance, scattering = compiled.materials.reflectance, compiled.scattering
    count = len(reflectance)
    model, glossy = np.zeros(count, np.uint8), np.zeros_like(reflectance)
    lobes, dip = np.zeros((count, 2 + TERMS)), np.zeros((count, 0, 0), np.float32)
    covering = np.full(count, -1.0)
    coat = sheen = None
    if scattering is not None:
        model, glossy = scattering.below, scattering.specular
        means = scattering.albedos[:count, :, -1]
        lobes = np.column_stack([scattering.parameters[:, 0], means, scattering.parameters[:, 4]])
        dip, covering = scattering.dip, scattering.parameters[:, 5]
        if scattering.coats is not None:
            coats = scattering.coats
            albedos = scattering.albedos[np.maximum(coats.row, 0), :, -1]
            coat_lobes = np.column_stack([coats.alpha, albedos, coats.mean_rise])
            coat = Coat(coats.weight[:, None], coats.f0[:, None], coat_lobes)
        if (sheens := scattering.sheens) is not None:
            sheen = Sheen(sheens.color, sheens.albedo[sheens.row, -1:])
    specular = _specularity(compiled.specular)
    of_lobe = glossy, lobes, dip, covering
    return Surfaces(reflectance, model, *of_lobe, specular, compiled.is_thin, coat, sheen)


def surfaces_at_hits(compiled: CompiledScene, hits: FirstHits) -> Surfaces:
    """Return what the surfaces of R first hits reflect, as textures say."""
    seen = _rows(surfaces_of_materials(compiled), compiled.geometry.material[hits.triangle])
    no_table, no_row = np.empty((0, 0)), np.empty(0)
    rows = SurfaceRows(
        reflectance=seen.reflectance,
        glossy=seen.glossy,
        lobes=seen.lobes,
        coat_weight=no_table if seen.coat is None else seen.coat.weight,
        coat_lobes=no_table if seen.coat is None else seen.coat.lobes,
        sheen_color=no_table.astype(np.float32) if seen.sheen is None else seen.sheen.color,
        alpha=no_row if seen.specular is None else seen.specular.alpha,
        glass=no_row if seen.specular is None else seen.specular.glass,
    )
    describe_surfaces(compiled.arrays, hits, rows)
    return seen


def _rows(table: Any, index: Array) -> Any:
    """Return rows of all arrays of a tuple, at any depth, each an array of its own."""
    if isinstance(table, tuple):
        return type(table)(*(_rows(part, index) for part in table))
    return table if table is None else np.ascontiguousarray(table[index])


def _specularity(specular: Specular | None) -> Specularity | None:
    """Return the specular lobes of materials, textures counting with their means."""
    if specular is None:
        return None
    ones = np.ones(len(specular.kind))
    alpha = specular.alpha if len(specular.alpha) else 0.0 * ones
    glass = ones if specular.glass is None else specular.glass.value
    return Specularity(specular.kind, specular.mirror, specular.ior, alpha, glass)
