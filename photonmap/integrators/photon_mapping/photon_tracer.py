"""The photons of each pass: radiosity cache and caustic map, which are the same for every camera.

The first view of a scene traces them, and keeps the passes that there is room for; what is not kept
is traced again, to the same bits.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

from photonmap.integrators.base import Counters, PassSetup, empty_cache
from photonmap.integrators.photon_mapping.cache_tracer import CacheTracer
from photonmap.integrators.photon_mapping.caustics import CausticTracer, can_connect, no_caustics
from photonmap.integrators.photon_mapping.pilot import do_photons_hit
from photonmap.integrators.shared_work import NO_ROOM, Room
from photonmap.kernels.core.passes import CausticMap, PhotonMaps, RadiosityCache


class TracedPass(NamedTuple):
    """The photons of a pass."""

    maps: PhotonMaps
    counters: Counters
    """what tracing them counted; of a pass that was kept no seconds"""


def tracer_of(setup: PassSetup) -> PhotonTracer:
    """Return what traces the photons of a setup; of views that share work, the same for all."""
    shared = setup.shared
    if shared is None:
        return PhotonTracer(setup)
    key = setup.light, setup.photons, can_connect(setup.view)
    return shared.once(key, lambda: PhotonTracer(replace(setup, shared=None), shared.make_room()))


class PhotonTracer:
    """Traces the photons of passes; keeps the passes for which there is room."""

    def __init__(self, setup: PassSetup, room: Room = NO_ROOM) -> None:
        self._setup, self._room = setup, room
        self._specular = setup.compiled.specular is not None
        self._kept: dict[tuple[int, int], TracedPass] = {}
        self.setup_seconds = 0.0
        """spent on what is done once"""

    def trace(self, index: int, wider: int = 0) -> TracedPass:
        """Return the photons of pass `index`, supports `wider` times doubled in width."""
        kept = self._kept.get((index, wider))
        if kept is not None:
            return kept
        counters, start = Counters(), time.perf_counter()
        cache = self._trace_cache(index, wider, counters)
        traced = time.perf_counter()
        caustics = self._trace_caustics(index, wider, counters)
        ended = time.perf_counter()
        maps = PhotonMaps(cache, caustics)
        if self._room.take(maps):
            again = replace(counters, reused=counters.photons)
            self._kept[index, wider] = TracedPass(maps, again)
        timed = replace(counters, photon_seconds=ended - start, caustic_seconds=ended - traced)
        return TracedPass(maps, timed)

    @cached_property
    def traces_paths_instead(self) -> bool:
        """Whether photons hit too little to estimate light: then gather rays go on as paths.

        What gather rays see via specular surfaces is always looked up.
        """
        setup = self._setup
        if self._specular or not setup.simulates("indirect"):
            return False
        with self._setting_up():
            return not do_photons_hit(setup)

    def _trace_cache(self, index: int, wider: int, counters: Counters) -> RadiosityCache:
        if not self._setup.simulates("indirect") or self.traces_paths_instead:
            return empty_cache(self._setup.bands)
        return self._cache_tracer.trace(index, wider, counters)

    @cached_property
    def _cache_tracer(self) -> CacheTracer:
        return CacheTracer(self._setup)

    def _trace_caustics(self, index: int, wider: int, counters: Counters) -> CausticMap | None:
        if not self._specular:
            return None
        if not self._setup.simulates("caustics"):
            return no_caustics(self._setup.bands)
        tracer = self._caustic_tracer
        caustics, rays = tracer.trace(index, wider)
        counters.photons += tracer.photons
        counters.add_rays(caustic=rays)
        return caustics

    @cached_property
    def _caustic_tracer(self) -> CausticTracer:
        with self._setting_up():
            return CausticTracer(self._setup)

    @contextmanager
    def _setting_up(self) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.setup_seconds += time.perf_counter() - start
