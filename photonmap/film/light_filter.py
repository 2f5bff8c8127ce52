"""Direct and indirect light averaged over pixels of a surface when a render is read out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from photonmap.film.moments import Accumulator
from photonmap.film.surface_filter import SurfaceFilter, Surfaces
from photonmap.kernels.core.passes import Film, Pixels
from photonmap.kernels.film.surface_filter import GROUPS
from photonmap.runtime.storage import RAM, Storage
from photonmap.runtime.workers import Workers

FILTERED = "direct", "indirect"
"""Buffers that are filtered."""
LEAST_PASSES = GROUPS
"""Of a render that is filtered: one in each group."""
EXPECTED = 0.72
"""By how much an error is taken to fall when passes are planned, as samples then go where it is,
too: by filtering alone it was 0.63 to 0.81 in rooms."""


class LightFilter:
    """Filters some of the `FILTERED` buffers, each by itself, of all lights that it follows."""

    def __init__(
        self,
        buffers: Sequence[str],
        film: Film,
        workers: Workers,
        surfaces: Surfaces,
        storage: Storage = RAM,
    ) -> None:
        self.filters = {
            name: SurfaceFilter(name, film, workers, surfaces, storage) for name in buffers
        }
        self._followed: list[Accumulator] = []
        self._last: tuple[int, list[Accumulator]] | None = None

    def follow(self, moments: Sequence[Accumulator]) -> int:
        """Filter further lights by the same weights; return the number of the first of them."""
        for each in self.filters.values():
            each.follow(moments)
        self._followed += moments
        return len(self._followed) - len(moments)

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind, by name: the arrays themselves."""
        parts = [each.arrays for each in self.filters.values()]
        return {name: array for part in parts for name, array in part.items()}

    def add(self, pixels: Pixels, light: int, index: int, passes: float) -> None:
        """Take in one light: the mean of so many passes from number `index` on."""
        for name, each in self.filters.items():
            each.add(getattr(pixels, name), light, index, passes)

    def apply(self) -> list[Accumulator]:
        """Return the moments of all lights, filtered; the same ones after few passes."""
        count = self._followed[0].count
        if count < LEAST_PASSES:
            return self._followed
        if self._last is None or self._last[0] != count:
            changes = {name: each.filter() for name, each in self.filters.items()}
            filtered = [
                moments.with_light({name: each[light] for name, each in changes.items()})
                for light, moments in enumerate(self._followed)
            ]
            self._last = count, filtered
        return self._last[1]
