"""What passes add up to under several illuminations at once: light is additive.

Passes carry the light groups of all. The light of an illumination is mixed from these in each pass,
so that its means and errors are those of passes of its own that have the same noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.spectral_columns import LIGHT, SpectralColumns
from photonmap.film.bias import BiasProbe, Repeatable
from photonmap.film.light_groups import LightGroups
from photonmap.film.moments import Accumulator
from photonmap.kernels.core.passes import EMPTY, FOUND, Estimate, Pixels
from photonmap.runtime.storage import strips

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Mix:
    """Mixes the light of an illumination from that of groups.

    Parameters
    ----------
    columns : of the illumination
    factors : of the groups that passes carry, for each group of the illumination, (G, H, N)
    """

    columns: SpectralColumns
    factors: Array

    def __call__(self, pixels: Pixels, seen: Array | None) -> tuple[Pixels, Array | None]:
        """Return what a pass estimates, and what it sees via specular surfaces, of this light."""
        light = {name: self._mix(getattr(pixels, name)) for name in LIGHT}
        own = len(self.factors)
        reflectance = np.tile(pixels.reflectance[:, : self.columns.distinct], own)
        lookups = pixels.lookups.copy()
        dark = ~light["irradiance_indirect"].any(axis=1) & ((lookups & FOUND) > 0)
        lookups[dark] = lookups[dark] & ~np.uint8(FOUND) | np.uint8(EMPTY)
        mixed = pixels._replace(**light, reflectance=reflectance, lookups=lookups)
        return mixed, None if seen is None else self._mix(seen)

    def _mix(self, image: Array) -> Array:
        """Return an image of all groups, (…, P, H N), in those of the illumination, (…, P, G N)."""
        bands = self.factors.shape[2]
        mixed = np.zeros((*image.shape[:-1], len(self.factors) * bands), np.float32)
        for group, factors in enumerate(self.factors):
            for other in np.flatnonzero(factors.any(axis=1)):
                for part in strips(image.shape[-2]):
                    light = image[..., part, other * bands : (other + 1) * bands] * factors[other]
                    mixed[..., part, group * bands : (group + 1) * bands] += light
        return mixed


class IlluminationMoments:
    """The moments of each illumination, as a render loop takes them: those of all together."""

    def __init__(self, parts: Sequence[LightGroups], mixes: Sequence[Mix]) -> None:
        self.parts, self.mixes = parts, mixes
        self.whole = _Worst([part.whole for part in parts])

    @property
    def filters(self) -> bool:
        """Whether light is filtered when it is read out."""
        return self.parts[0].filters

    @property
    def filtered(self) -> _Worst:
        """Those that are read out, of filtered light."""
        return _Worst([part.filtered for part in self.parts])

    @property
    def passes(self) -> int:
        """How many were taken in."""
        return self.parts[0].passes

    def add(self, pixels: Pixels, seen: Array | None) -> None:
        """Take in one complete pass."""
        for part, mix in zip(self.parts, self.mixes, strict=True):
            part.add(*mix(pixels, seen))

    def close(self) -> None:
        """Take in a replicate that has begun."""
        for part in self.parts:
            part.close()

    def clear(self) -> None:
        """Forget all passes."""
        for part in self.parts:
            part.clear()


class _Worst:
    """What a render loop asks of moments: that of the illumination that is worst off."""

    def __init__(self, parts: Sequence[Accumulator]) -> None:
        self._parts = parts

    @property
    def count(self) -> int:
        return self._parts[0].count

    def error(
        self, buffer: str = "radiance", percentile: float | None = None, lit: bool = True
    ) -> float:
        return max(part.error(buffer, percentile, lit) for part in self._parts)

    def shows_nothing(self) -> bool:
        return all(part.shows_nothing() for part in self._parts)

    def states_error(self, lit: bool = True) -> bool:
        return any(part.states_error(lit) for part in self._parts)

    @property
    def counts(self) -> NDArray[np.uint32]:
        return self._parts[0].counts

    def truncated(self) -> int:
        return self._parts[0].truncated()


class IlluminationProbes:
    """The probes of each illumination, as a render loop takes them."""

    def __init__(
        self, integrator: Repeatable, parts: Sequence[BiasProbe], moments: IlluminationMoments
    ) -> None:
        self._integrator, self.parts, self._moments = integrator, parts, moments

    def probe(self, index: int, estimate: Estimate, _: Any) -> None:
        """Repeat pass `index`, once for all, if it is one to be probed."""
        if not self.parts[0].repeats(index):
            return
        moments = self._moments

        def indirect(estimate: Estimate) -> list[NDArray[np.float64]]:
            each = zip(self.parts, moments.mixes, moments.parts, strict=True)
            return [
                part.indirect(Estimate(*mix(estimate.pixels, estimate.via_specular)), own.whole)
                for part, mix, own in each
            ]

        narrow = indirect(estimate)
        wide = indirect(self._integrator.estimate(index, wider=1))
        for part, one, other, own in zip(self.parts, narrow, wide, moments.parts, strict=True):
            part.take_in(index, other - one, own.whole)

    def bias(self, count: int) -> float | None:
        """Return the largest estimate after `count` passes; None if it is unknown."""
        known = [bias for part in self.parts if (bias := part.bias(count)) is not None]
        return max(known, default=None)
