"""The radiosity cache of each pass: cells that shrink, filled by the pass's own photons."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.geometry import triangle_areas
from photonmap.integrators.base import Counters, PassSetup
from photonmap.integrators.photon_mapping.cache_cells import (
    FINER_SHARED,
    divide_cells,
    find_lit_sides,
    lay_cells,
    measure_exposed,
    measure_seen_afar,
    measure_surface_fraction,
    split_shared,
)
from photonmap.integrators.photon_mapping.pilot import stores_per_photon
from photonmap.kernels.cache.radiosity_cache import sum_bundles
from photonmap.kernels.core.passes import MAX_BOUNCES, CacheCells, RadiosityCache, Span
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.integrators.photon import trace_photons

STORES_PER_CELL = 7
"""Photons that a cell stores on average in the first pass, if they lie on one side of all surfaces:
cells are larger where many photons, as those of a sky, miss the scene."""
MOST_CELLS_PER_PHOTON = 0.3
"""Where surfaces are white, and photons are stored many times."""
CELLS_HOLD = 9
"""Passes after which cells begin to shrink; before, noise outweighs their bias. The 18th pass is
the first that has smaller ones: renders of 16 passes lay them out once."""
BUNDLE = 32768
"""Photons that fill one copy of the cache."""
MOST_BUNDLES = 16
CELL_RANGE = 16384
"""Cells that are summed over bundles at a time."""


class Layout(NamedTuple):
    """The cells of a pass."""

    cells: CacheCells
    number: int
    fraction: NDArray[np.float32]
    """(cells, 1), of each cell's area that is exposed surface"""


def bundle_count(photons: int) -> int:
    """Return how many copies of the cache are filled side by side, for any number of threads."""
    return min(max(-(-photons // BUNDLE), 1), MOST_BUNDLES)


class CacheTracer:
    """Traces the photons of passes into radiosity caches, and counts them."""

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        self._areas = triangle_areas(setup.compiled.geometry)
        self._layouts: dict[int, Layout] = {}
        self._bundles = np.empty((0, 0, 0), np.float32)
        stores = stores_per_photon(setup, MAX_BOUNCES)
        self._cells_per_photon = min(stores / STORES_PER_CELL, MOST_CELLS_PER_PHOTON)

    def trace(self, index: int, wider: int, counters: Counters) -> RadiosityCache:
        """Return the cache of pass `index`, with cells `wider` times doubled in width."""
        setup, total, scene = self._setup, self._setup.photons, self._setup.scene(index)
        layout = self._layout(index, wider)
        bundles = bundle_count(total)
        shape = bundles, layout.number, setup.bands
        if self._bundles.shape != shape:
            self._bundles = setup.storage.zeros(shape)
        key = setup.key(index, Domain.PHOTONS)
        counts = setup.workers.map(
            lambda bundle: trace_photons(
                scene,
                RadiosityCache(layout.cells, self._bundles[bundle]),
                key,
                Span(bundle * total // bundles, (bundle + 1) * total // bundles),
                total,
                MAX_BOUNCES,
                np.empty((3, setup.bands), np.float32),
            ),
            bundles,
        )
        stores, rays, truncated, short = np.sum(counts, axis=0).tolist()
        counters.stores += stores
        counters.truncated += truncated
        counters.photons += total
        # Short rays find out what stands near, where it may be specular, or else whether anything.
        shadow = 0 if scene.specular else short
        counters.add_rays(photon=rays + short - shadow, shadow=shadow)
        radiosity = setup.storage.zeros((layout.number, setup.bands))
        setup.workers.ranges(
            lambda first, last: sum_bundles(self._bundles, first, last, radiosity),
            layout.number,
            CELL_RANGE,
        )
        radiosity /= layout.fraction
        counters.add_rays(photon=self._brighten_crowded(index, layout.cells, radiosity))
        return RadiosityCache(layout.cells, radiosity)

    def _brighten_crowded(
        self, index: int, cells: CacheCells, radiosity: NDArray[np.float32]
    ) -> int:
        """Divide crowded cells by their share that is seen from afar; return how many rays told."""
        if not cells.crowded.any():
            return 0
        lit = cells.crowded & radiosity.any(axis=1)
        known = self._lit_sides, self._areas, cells
        inverse, rays = measure_seen_afar(self._setup, index, *known, lit)
        radiosity *= inverse
        return rays

    def _layout(self, index: int, wider: int) -> Layout:
        """Return cells whose area falls with the cube root of passes in the end, in steps of √2."""
        level = int(2.0 * math.log2(1.0 + index / CELLS_HOLD) / 3.0) - 4 * wider
        if level not in self._layouts:
            number = max(self._setup.photons * self._cells_per_photon, 1.0) * 2.0 ** (0.5 * level)
            area, geometry = self._areas.sum() / number, self._setup.scene(0).geometry
            cells = lay_cells(geometry, self._areas, area)[0]
            # Passes that are repeated with wider supports go back and forth between two.
            kept = list(self._layouts.items())[-1:]
            self._layouts = dict(kept) | {level: self._measure(cells, area)}
        return self._layouts[level]

    def _measure(self, cells: CacheCells, area: float) -> Layout:
        """Divide cells beside emitters or exposed in part; measure the exposed surface of all."""
        geometry, areas = self._setup.scene(0).geometry, self._areas
        exposed = measure_exposed(self._setup, self._lit_sides, areas, cells)
        size = math.sqrt(area) / FINER_SHARED
        cells, split = split_shared(geometry, areas, cells, exposed.beside_emitter, size)
        of = np.append(np.arange(len(exposed.fraction)), split)  # the cell that each is, or was
        laid = len(of)
        cells, count = divide_cells(cells, exposed.fraction[of, 0] < 1.0)
        of = np.append(of, np.repeat(of[cells.parts >= 0], cells.finer**2))
        fraction, crowded, cluttered, _ = (rows[of] for rows in exposed)
        crowded[laid:] = True  # What hides a part of the whole stands on or beside each.
        cells = cells._replace(crowded=crowded, cluttered=cluttered)
        fraction[crowded] = 1.0  # What is seen from afar of them is measured in each pass.
        fraction[laid:] /= np.float32(cells.finer**2)
        surface = measure_surface_fraction(geometry, areas, cells, count)
        return Layout(cells, count, fraction if surface is None else fraction * surface)

    @cached_property
    def _lit_sides(self) -> NDArray[np.bool_]:
        """Whether light reaches the sides of triangles, (T, 2)."""
        return find_lit_sides(self._setup)
