"""One pass of photon mapping: photons, irradiance store, camera pass, sharing.

A pass depends on the seed and its own number alone, so passes are independent estimates and the
same for any number of threads. From pass to pass the store's cells and the sharing windows
shrink, so the answer converges to the truth (Knaus and Zwicker 2011).
"""

import hashlib
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from photonmap.caustics import CausticTracer, no_caustics
from photonmap.cells import divide_cells, lay_cells, measure_fill
from photonmap.cuts import share_cut
from photonmap.effects import EffectPlan
from photonmap.focus import LEARNED, count_rays, focused
from photonmap.kernels.eye import camera_pass
from photonmap.kernels.path import path_pass
from photonmap.kernels.photon import trace_photons
from photonmap.kernels.records import (
    FIRST_CAUSTIC,
    LANES,
    LIT_BY_CAUSTIC,
    SEEN_CAUSTIC,
    SEEN_DIRECT,
    SEEN_INDIRECT,
    Caustics,
    Cells,
    Film,
    Pixels,
    Plan,
    Scratch,
)
from photonmap.kernels.share import share
from photonmap.kernels.store import join
from photonmap.landing import do_photons_land
from photonmap.openness import find_reached, measure_open
from photonmap.prepare import Prepared
from photonmap.storage import RAM, Storage
from photonmap.survey import SAMPLES, TILE, WINDOW, survey
from photonmap.triangles import triangle_areas
from photonmap.workers import Workers

CELLS_PER_PHOTON = 1 / 4
"""On one side of all surfaces, in the first pass."""
BUNDLE = 32768
MOST_BUNDLES = 16
CELL_RANGE = 16384
CELLS_HOLD, WINDOWS_HOLD = 8, 64
"""Passes after which cells and windows begin to shrink; before, noise outweighs their bias."""
MAX_BOUNCES = 1000
COUNTERS = ("photons", "stores", "cut", "rays", "photon_seconds", "caustic_seconds")
Layout = tuple[Cells, int, NDArray[np.float32]]
"""Of the store: cells, how many they are, and how much open surface each has, (cells, 1).

In units of the area that `Cells` knows."""
Store = tuple[Cells, np.ndarray]
Light = tuple[Store, Caustics | None]

SURVEY, PHOTONS, CAMERA, PROBE, CAUSTIC_PILOT, CAUSTICS, LANDING, CUTS, REACHED, OPEN = range(10)


def stream_key(seed: int, index: int, domain: int) -> np.uint64:
    """Return the key of an independent family of random streams."""
    text = f"{seed} {index} {domain}".encode()
    return np.uint64(int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little"))


def bundle_count(photons: int) -> int:
    """Return how many copies of the store are filled side by side, for any number of threads."""
    return min(max(-(-photons // BUNDLE), 1), MOST_BUNDLES)


def window_width(indices: np.ndarray) -> float:
    """Return the mean width of passes' windows, the supports that narrow the slowest.

    In units of the first pass's.
    """
    return float(np.mean((1.0 + indices / WINDOWS_HOLD) ** (-1.0 / 6.0)))


class Passes:
    """Runs passes one after the other over the same arrays.

    Parameters
    ----------
    prepared : the scene
    film : the image
    bands : N
    photons : emitted in each pass
    seed : of all random numbers
    workers : that share the work
    method : photon mapping, or the plain path tracer that arbitrates
    plan : of the effects; None for all
    storage : where the arrays lie
    """

    def __init__(
        self,
        prepared: Prepared,
        film: Film,
        bands: int,
        photons: int,
        seed: int,
        workers: Workers,
        method: Literal["photon", "path"] = "photon",
        plan: EffectPlan | None = None,
        storage: Storage = RAM,
    ) -> None:
        self._effects = plan
        self._prepared = prepared
        self._scene = prepared.arrays
        self._smooth = prepared.optics is not None
        self._caustics: CausticTracer | None = None
        self._film, self._bands, self._photons = film, bands, photons
        self._seed, self._workers, self._method = seed, workers, method
        self._camera = prepared.film_camera(film.width, film.height)
        self._size = film.width * film.height
        self._storage = storage
        self._pixels = empty_pixels(self._size, bands, storage)
        self.seen = storage.zeros((5, self._size, bands)) if self._smooth else None
        self._shared = storage.zeros((self._size, bands))
        self._areas = triangle_areas(prepared.geometry)
        self._layouts: dict[int, Layout] = {}
        self._bundles = np.empty((0, 0, 0), np.float32)
        self.powers: np.ndarray | None = None
        """(2, P) by which samples change after the first passes, see `Focus`"""
        self.photon_seconds = self.caustic_seconds = self.setup_seconds = 0.0
        self.photons = self.stores = self.cut = self.rays = 0

    @property
    def shares(self) -> bool:
        """Whether pixels share their indirect light with neighbours."""
        return self._method == "photon" and self._on("indirect")

    @property
    def counters(self) -> dict[str, float]:
        """All that passes leave behind here: each is else a function of seed and number alone."""
        return {name: getattr(self, name) for name in COUNTERS}

    def resume(self, counters: dict[str, float]) -> None:
        """Go on from the counters of earlier passes."""
        for name in COUNTERS:
            setattr(self, name, counters[name])

    def run(self, index: int, wider: int = 0) -> Pixels:
        """Run pass `index` (from 0); the arrays returned are overwritten by the next.

        So is `seen`, what the pass saw in smooth surfaces; None where there are none. Supports
        are so many times doubled in width, with the same random numbers.
        """
        light = self.illuminate(index, wider)
        return self.finish(index, self.look(index, *light), wider)

    @property
    def has_supports(self) -> bool:
        """Whether light is averaged over cells, windows or disks."""
        return self.shares or (self._smooth and self._method == "photon" and self._on("caustics"))

    def illuminate(self, index: int, wider: int = 0) -> Light:
        """Trace the photons of a pass: the store, and the map of caustics if there is one."""
        if self._method == "path":
            return empty_store(self._bands), None
        start = time.perf_counter()
        stored = self._on("indirect") and not self.traces_paths_instead
        store = self._trace_photons(index, wider) if stored else empty_store(self._bands)
        traced = time.perf_counter()
        caustics = self._trace_caustics(index, wider)
        self.caustic_seconds += time.perf_counter() - traced
        self.photon_seconds += time.perf_counter() - start
        return store, caustics

    def look(self, index: int, store: Store, caustics: Caustics | None) -> Pixels:
        """Run the camera pass, or trace the paths."""
        if self._method == "path":
            return self._trace_paths(index)
        return self._render(index, store, caustics)

    def finish(self, index: int, pixels: Pixels, wider: int = 0) -> Pixels:
        """Share indirect light between pixels, and clear what is to be left out."""
        return self._leave_out(self._share(index, pixels, wider) if self.shares else pixels)

    @cached_property
    def traces_paths_instead(self) -> bool:
        """Whether too few photons land to say what indirect light there is.

        What gather rays see in mirrors and through glass is always looked up.
        """
        if self._method == "path" or self._smooth or not self._on("indirect"):
            return False
        key = stream_key(self._seed, 0, LANDING)
        return not do_photons_land(self._prepared, self._bands, self._photons, key)

    def share_of_paths_cut(self) -> float:
        """Return which share of the path tracer's paths is cut, see `share_cut`."""
        if self._method != "path" or not self._on("indirect"):
            return 0.0
        key = stream_key(self._seed, 0, CUTS)
        return share_cut(self._prepared, self._bands, MAX_BOUNCES, key)

    @property
    def effect_seconds(self) -> dict[str, float]:
        """Seconds of the effects that are timed apart: of their photons."""
        spent = {"indirect": self.photon_seconds - self.caustic_seconds}
        return spent | ({"caustics": self.caustic_seconds} if self._smooth else {})

    def _on(self, effect: str) -> bool:
        return self._effects is None or self._effects.on(effect)

    def _leave_out(self, pixels: Pixels) -> Pixels:
        """Clear what was estimated along the way, though it is to be left out."""
        for effect, names, rows in (
            ("emission", ("emission",), ()),
            ("direct", ("direct", "irradiance_direct"), (SEEN_DIRECT,)),
            ("indirect", ("indirect", "irradiance_indirect"), (SEEN_INDIRECT,)),
            ("caustics", (), (FIRST_CAUSTIC, LIT_BY_CAUSTIC, SEEN_CAUSTIC)),
        ):
            if not self._on(effect):
                for name in names:
                    getattr(pixels, name)[:] = 0.0
                if self.seen is not None:
                    self.seen[list(rows)] = 0.0
        return pixels

    def _trace_caustics(self, index: int, wider: int) -> Caustics | None:
        if not self._smooth:
            return None
        if not self._on("caustics"):
            return no_caustics(self._bands)
        if self._caustics is None:
            key = stream_key(self._seed, 0, CAUSTIC_PILOT)
            with self._setting_up():
                self._caustics = CausticTracer(
                    self._scene, self._bands, self._photons, self._size, key, self._workers
                )
        key = stream_key(self._seed, index, CAUSTICS)
        self.photons += self._caustics.photons
        return self._caustics.trace(index, key, wider)

    def _trace_photons(self, index: int, wider: int) -> Store:
        cells, count, fill = self._layout(index, wider)
        total = self._photons
        bundles = bundle_count(total)
        if self._bundles.shape[:2] != (bundles, count):
            self._bundles = self._storage.zeros((bundles, count, self._bands))
        key = stream_key(self._seed, index, PHOTONS)
        counts = self._workers.map(
            lambda bundle: trace_photons(
                *self._scene,
                cells,
                key,
                bundle * total // bundles,
                (bundle + 1) * total // bundles,
                total,
                MAX_BOUNCES,
                np.empty(self._bands, np.float32),
                self._bundles[bundle],
            ),
            bundles,
        )
        stores, cut = np.sum(counts, axis=0)
        self.stores += int(stores)
        self.cut += int(cut)
        self.photons += total
        self.rays += int(stores) + total
        radiosity = self._storage.zeros((count, self._bands))
        self._workers.ranges(
            lambda first, last: join(self._bundles, first, last, radiosity), count, CELL_RANGE
        )
        radiosity /= fill
        return cells, radiosity

    def _layout(self, index: int, wider: int) -> Layout:
        """Return cells whose area falls with the cube root of passes in the end, in steps of √2."""
        level = int(2.0 * math.log2(1.0 + index / CELLS_HOLD) / 3.0) - 4 * wider
        if level not in self._layouts:
            number = max(self._photons * CELLS_PER_PHOTON, 1.0) * 2.0 ** (0.5 * level)
            cells, count = lay_cells(self._scene[0], self._areas, self._areas.sum() / number)
            # Passes that are repeated with wider supports go back and forth between two.
            kept = list(self._layouts.items())[-1:]
            self._layouts = dict(kept) | {level: self._fill(cells, count)}
        return self._layouts[level]

    def _fill(self, cells: Cells, count: int) -> Layout:
        """Divide the cells that lie open in part, and measure the open surface of all."""
        part = self._measure_open(cells, count)
        cells, count = divide_cells(cells, part[:, 0] < 1.0)
        if count > len(part):
            of_divided = self._measure_open(cells, count)[len(part) :]
            part = np.concatenate([part, of_divided / np.float32(cells.finer**2)])
        surface = measure_fill(self._scene[0], self._areas, cells, count)
        return cells, count, part if surface is None else part * surface

    def _measure_open(self, cells: Cells, count: int) -> NDArray[np.float32]:
        key = stream_key(self._seed, 0, OPEN)
        return measure_open(
            self._scene,
            self._reached,
            self._areas,
            cells,
            count,
            key,
            self._workers,
            self._storage,
        )

    @cached_property
    def _reached(self) -> NDArray[np.bool_]:
        """Whether light comes to the sides of triangles, (T, 2)."""
        objects, key = self._prepared.object_ids, stream_key(self._seed, 0, REACHED)
        return find_reached(self._scene, objects, self._bands, key)

    def _render(self, index: int, store: Store, caustics: Caustics | None) -> Pixels:
        with self._setting_up():
            plan = self._focused(index)
        key = stream_key(self._seed, index, CAMERA)
        self._over_pixels(
            lambda first, last: camera_pass(
                self._scene,
                store,
                caustics,
                self._camera,
                self._film,
                plan,
                key,
                first,
                last,
                _scratch(self._bands, self._smooth),
                self._pixels,
                self.seen,
            )
        )
        self.rays += count_rays(plan)
        return self._pixels

    def _focused(self, index: int) -> Plan:
        """Return the plan of pass number `index`."""
        if self.powers is None or index < LEARNED or not self.powers.any():
            return self.plan
        return focused(self.plan, self.powers[index % 2], self._film)

    @contextmanager
    def _setting_up(self) -> Iterator[None]:
        """Take the time of what is done once, in the first pass."""
        start = time.perf_counter()
        yield
        self.setup_seconds += time.perf_counter() - start

    @cached_property
    def plan(self) -> Plan:
        """How much sampling each pixel gets."""
        key = stream_key(self._seed, 0, SURVEY)
        plan = survey(self._scene, self._camera, self._film, key, self._workers, self._storage)
        if not self._on("indirect"):
            plan = plan._replace(gathers=np.zeros_like(plan.gathers))
        if not self._on("soft_shadows"):
            plan = plan._replace(lights=np.ones_like(plan.lights))
        return plan

    def _share(self, index: int, pixels: Pixels, wider: int) -> Pixels:
        plan, shrink = self.plan, window_width(np.array([index])) * 2.0**wider
        self._over_pixels(
            lambda first, last: share(
                self._film, plan, WINDOW * shrink, shrink, first, last, pixels, self._shared
            )
        )
        return pixels._replace(irradiance_indirect=self._shared)

    def _over_pixels(self, task: Callable[[int, int], object]) -> None:
        self._workers.ranges(task, self._size, TILE)

    def _trace_paths(self, index: int) -> Pixels:
        key = stream_key(self._seed, index, CAMERA)
        nothing = empty_store(self._bands)
        self._over_pixels(
            lambda first, last: path_pass(
                self._scene,
                nothing,
                self._camera,
                self._film,
                SAMPLES,
                MAX_BOUNCES if self._on("indirect") else 1,
                key,
                first,
                last,
                _scratch(self._bands, self._smooth),
                self._pixels,
                self.seen,
            )
        )
        return self._pixels


def _scratch(bands: int, smooth: bool) -> Scratch:
    """Make what a kernel needs for one sample."""
    throughput, through = np.empty((2, bands), np.float32)
    irradiance = np.empty((3 if smooth else 2, bands), np.float32)
    return Scratch(throughput, through, irradiance, np.empty((2, LANES)), np.empty((3, LANES)))


def empty_store(bands: int) -> Store:
    """Make a store that never answers."""
    none = np.zeros((0, 2), np.int32), np.zeros(0, np.int32), np.zeros((0, 2), np.float32)
    return Cells(*none, np.zeros(0, np.int32), 1), np.zeros((0, bands), np.float32)


def empty_pixels(size: int, bands: int, storage: Storage = RAM) -> Pixels:
    """Make the arrays of a pass over `size` pixels."""
    return Pixels(
        *storage.zeros((6, size, bands)),
        coverage=storage.zeros(size),
        found=storage.zeros(size, np.uint8),
        plane=storage.zeros((size, 7)),
    )
