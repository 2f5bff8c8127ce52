"""What the surfaces reflect that buffers of first hits tell of, one row each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.surfaces.glossy import mean_albedo
from photonmap.kernels.bsdf.models import GLOSSY
from photonmap.kernels.core.records import GLASS

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
    dip: Array | None
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
