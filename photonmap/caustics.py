"""Caustic photons of each pass: aimed at smooth surfaces, and counted over shrinking disks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.cuts import share_going_on
from photonmap.kernels.beyond import MOST_SMOOTH
from photonmap.kernels.caustics import fill_buckets, trace_caustics
from photonmap.kernels.records import Caustics, Guide, SceneArrays
from photonmap.workers import Workers

BUNDLE = 8192
PILOT = 1 << 16
"""Photons that look where smooth surfaces are, before the passes."""
PILOT_REFLECTIONS = 1 << 20
"""Of its photons that linger between smooth surfaces: where many do, as in a ball of mirrors, fewer
photons look, a sixteenth at least."""
SCOUTS, LINGERING = 1024, 64
"""Photons that tell how many linger, and the reflections after which one does."""
BOXES = 32
ANYWHERE = 0.2
"""Share of photons that leave regardless of what the pilot found."""
WANTED = 20
"""Photons within a disk of the first pass, about."""
LARGEST = 0.02
"""Radius at most, in sizes of the scene."""
MOST = 4
"""Caustic photons at most, times those of the irradiance store."""

Photons = tuple[NDArray[np.float32], NDArray[np.float32]]
"""Places and flux, as in `Caustics`."""


class CausticTracer:
    """Traces the caustic photons of passes, with random numbers of their own.

    Parameters
    ----------
    scene : with smooth surfaces
    bands : N
    photons : in each pass of the irradiance store
    wanted : caustic photons that should arrive in a pass
    key : of the pilot
    workers : that share the work
    """

    def __init__(
        self,
        scene: SceneArrays,
        bands: int,
        photons: int,
        wanted: int,
        key: np.uint64,
        workers: Workers,
    ) -> None:
        geometry, _, lights, optics, _ = scene
        self._scene = geometry, lights, optics
        self._bands, self._workers = bands, workers
        pilot = _pilot_size(_lingering(scene, bands, key ^ np.uint64(2)))
        self._guide = _guide(np.empty((0, 4), np.float32))
        origins, (places, _) = self._trace(pilot, key)
        self._guide = _guide(origins)
        found, _ = self._trace(pilot // 4, key ^ np.uint64(1))
        rate = max(len(found), 1) / (pilot // 4)
        photons = max(photons, 1)
        most = MOST if len(origins) or len(found) else 1
        self.photons = int(np.clip(wanted / rate, min(wanted, photons), most * photons))
        self._radius = _first_radius(places[:, :3], self.photons * rate)

    def trace(self, index: int, key: np.uint64, wider: int = 0) -> Caustics:
        """Return the caustic photons of pass number `index`, with disks `wider` times doubled."""
        radius = self._radius * (1.0 + index) ** (-1.0 / 6.0) * 2.0**wider
        return _sort(self._trace(self.photons, key)[1], radius)

    def _trace(self, total: int, key: np.uint64) -> tuple[NDArray[np.float32], Photons]:
        """Trace photons in bundles; return where they left, and those that arrived."""
        bundles = -(-total // BUNDLE)

        def trace(bundle: int) -> list[NDArray[np.float32]]:
            first, last = bundle * total // bundles, (bundle + 1) * total // bundles
            columns = 4, 6, self._bands
            arrays = [np.empty((last - first, width), np.float32) for width in columns]
            count = trace_caustics(*self._scene, self._guide, key, first, last, total, *arrays)
            return [array[:count] for array in arrays]

        origins, places, flux = map(
            np.concatenate, zip(*self._workers.map(trace, bundles), strict=True)
        )
        return origins, (places, flux)


def no_caustics(bands: int) -> Caustics:
    """Return a map without photons."""
    places, flux = np.empty((0, 6), np.float32), np.empty((0, bands), np.float32)
    return Caustics(places, flux, np.zeros(1, np.int32), 1.0)


def _lingering(scene: SceneArrays, bands: int, key: np.uint64) -> float:
    """Return the share of photons that smooth surfaces alone keep after many reflections.

    Of photons that lose nothing by them, and end at the first diffuse surface.
    """
    geometry, materials, lights, optics, textures = scene
    assert optics is not None
    if textures is not None:
        textures = textures._replace(basis=np.zeros_like(textures.basis))
    reflecting = optics._replace(mirror=np.ones_like(optics.mirror), tint=np.ones_like(optics.tint))
    black = materials._replace(reflectance=np.zeros_like(materials.reflectance))
    smooth_alone = geometry, black, lights, reflecting, textures
    return share_going_on(smooth_alone, bands, SCOUTS, LINGERING, key)


def _pilot_size(lingering: float) -> int:
    """Return how many photons look where smooth surfaces are."""
    fitting = PILOT_REFLECTIONS / max(lingering * MOST_SMOOTH, 1.0)
    return int(np.clip(fitting, PILOT // 16, PILOT))


def _guide(origins: NDArray[np.float32]) -> Guide:
    """Return where to send photons: in part as those of a pilot that arrived, in part anywhere."""
    tables = []
    for columns in (slice(0, 2), slice(2, 4)):
        boxes = np.minimum((origins[:, columns] * BOXES).astype(int), BOXES - 1)
        density = np.full((BOXES, BOXES), 1.0 / BOXES**2)
        if len(origins):
            counts = np.zeros((BOXES, BOXES))
            np.add.at(counts, tuple(boxes.T), 1.0)
            density = ANYWHERE * density + (1.0 - ANYWHERE) * counts / len(origins)
        rows = density.sum(axis=1)
        tables += [_cumulative(rows), _cumulative(density / rows[:, None])]
    return Guide(*tables)


def _cumulative(chances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return running sums along the last axis, from 0 to exactly 1."""
    sums = np.cumsum(chances, axis=-1)
    zero = np.zeros((*chances.shape[:-1], 1))
    return np.concatenate([zero, sums / sums[..., -1:]], axis=-1)


def _first_radius(positions: NDArray[np.float32], arriving: float) -> float:
    """Return the radius within which about `WANTED` of the arriving photons lie."""
    from scipy.spatial import cKDTree

    if len(positions) <= WANTED:
        return LARGEST
    some = positions[:: max(len(positions) // 512, 1)]
    distances = cKDTree(positions).query(some, k=WANTED + 1)[0][:, -1]
    denser = max(arriving / len(positions), 1e-3)
    return float(min(np.median(distances) / np.sqrt(denser), LARGEST))


def _sort(photons: Photons, radius: float) -> Caustics:
    """Sort photons by buckets of boxes as wide as the disk."""
    places, flux = photons
    count = max(2 * len(places), 1)
    buckets = np.empty(len(places), np.int32)
    fill_buckets(places, 2.0 * radius, 0, len(places), count, buckets)
    order = np.argsort(buckets, kind="stable")
    starts = np.zeros(count + 1, np.int32)
    np.cumsum(np.bincount(buckets, minlength=count), out=starts[1:])
    return Caustics(places[order], flux[order], starts, radius)
