"""Caustic photons of each pass: guided to specular surfaces, and counted over shrinking disks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.lights.probabilities import make_cdf
from photonmap.integrators.base import PassSetup
from photonmap.integrators.path_truncation import fraction_going_on
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN
from photonmap.kernels.caustics.photon_map import fill_buckets, trace_caustics
from photonmap.kernels.core.passes import CausticMap, CausticPhotons, EmissionGuide, Span
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.core.streams import Domain

BUNDLE = 8192
"""Photons that are traced at a time."""
PILOT = 1 << 16
"""Photons that find specular surfaces before the passes."""
PILOT_REFLECTIONS = 1 << 20
"""Reflections of the pilot's photons, at most: where many linger between specular surfaces, as in a
ball of mirrors, the pilot has fewer photons, a sixteenth at least."""
SCOUTS, LINGERING = 1024, 64
"""Photons used to estimate the fraction that lingers, and the reflections after which one does."""
BOXES = 32
"""Of a guide, along each side of a unit square."""
ANYWHERE = 0.2
"""Fraction of photons that leave regardless of what the pilot found."""
WANTED = 20
"""Photons within a disk of the first pass, about."""
LARGEST = 0.02
"""Radius of a disk at most, in sizes of the scene."""
MOST = 4
"""Caustic photons at most, times those of the radiosity cache."""


class CausticTracer:
    """Traces the caustic photons of passes, with random numbers of their own.

    Parameters
    ----------
    setup : of the passes; the scene has specular surfaces
    """

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        setup.begin_pass(0)
        lingering = _lingering_fraction(
            setup.compiled.arrays, setup.bands, setup.key(0, Domain.LINGERING)
        )
        pilot = _pilot_size(lingering)
        self._guide = _build_guide(np.empty((0, 4), np.float32))
        found, _ = self._trace(pilot, setup.key(0, Domain.CAUSTIC_PILOT))
        self._guide = _build_guide(found.origins)
        guided = len(self._trace(pilot // 4, setup.key(0, Domain.CAUSTIC_CHECK))[0].flux)
        rate = max(guided, 1) / (pilot // 4)
        photons, wanted = max(setup.photons, 1), setup.pixels
        most = MOST if len(found.flux) or guided else 1
        self.photons = int(np.clip(wanted / rate, min(wanted, photons), most * photons))
        """Photons emitted in a pass"""
        self._radius = _first_radius(found.positions[:, :3], self.photons * rate)

    def trace(self, index: int, key: np.uint64, wider: int = 0) -> tuple[CausticMap, int]:
        """Return the caustic map of pass `index`, disks `wider` times doubled, and its rays."""
        radius = self._radius * (1.0 + index) ** (-1.0 / 6.0) * 2.0**wider
        photons, rays = self._trace(self.photons, key)
        return _sort(photons, radius), rays

    def _trace(self, total: int, key: np.uint64) -> tuple[CausticPhotons, int]:
        """Trace photons in bundles; return those that arrived, and the number of rays."""
        bundles, scene = -(-total // BUNDLE), self._setup.compiled.arrays
        arriving = 3 if scene.scattering is not None else 0

        def trace(bundle: int) -> tuple[list[NDArray[np.float32]], int]:
            span = Span(bundle * total // bundles, (bundle + 1) * total // bundles)
            columns = 4, 6, 3, self._setup.bands
            photons = CausticPhotons(
                *(np.empty((span.last - span.first, width), np.float32) for width in columns)
            )
            count, rays = trace_caustics(scene, self._guide, key, span, total, photons)
            return [array[:count] for array in photons], rays

        traced, rays = zip(*self._setup.workers.map(trace, bundles), strict=True)
        photons = CausticPhotons(*map(np.concatenate, zip(*traced, strict=True)))
        if not arriving:
            photons = photons._replace(arrivals=photons.arrivals[:0])
        return photons, sum(rays)


def no_caustics(bands: int) -> CausticMap:
    """Return a map without photons."""
    positions, arrivals = np.empty((0, 6), np.float32), np.empty((0, 3), np.float32)
    flux = np.empty((0, bands), np.float32)
    return CausticMap(positions, arrivals, flux, np.zeros(1, np.int32), 1.0)


def _lingering_fraction(scene: SceneArrays, bands: int, key: np.uint64) -> float:
    """Return the fraction of photons that specular surfaces alone keep after many reflections.

    Of photons that lose nothing by them, and end at the first surface of another kind.
    """
    specular, textures, materials = scene.specular, scene.textures, scene.materials
    assert specular is not None
    if textures is not None:
        textures = textures._replace(basis=np.zeros_like(textures.basis))
    lossless = specular._replace(
        mirror=np.ones_like(specular.mirror), tint=np.ones_like(specular.tint)
    )
    black = materials._replace(reflectance=np.zeros_like(materials.reflectance))
    specular_alone = scene._replace(
        specular=lossless, textures=textures, materials=black, scattering=None
    )
    return fraction_going_on(specular_alone, bands, SCOUTS, LINGERING, key)


def _pilot_size(lingering: float) -> int:
    """Return how many photons find specular surfaces."""
    fitting = PILOT_REFLECTIONS / max(lingering * LONGEST_CHAIN, 1.0)
    return int(np.clip(fitting, PILOT // 16, PILOT))


def _build_guide(origins: NDArray[np.float32]) -> EmissionGuide:
    """Return where to send photons: in part as those of a pilot that arrived, in part anywhere."""
    tables = []
    for columns in (slice(0, 2), slice(2, 4)):
        boxes = np.minimum((origins[:, columns] * BOXES).astype(int), BOXES - 1)
        density = np.full((BOXES, BOXES), 1.0 / BOXES**2)
        if len(origins):
            counts = np.zeros((BOXES, BOXES))
            np.add.at(counts, tuple(boxes.T), 1.0)
            density = ANYWHERE * density + (1.0 - ANYWHERE) * counts / len(origins)
        tables += [make_cdf(density.sum(axis=1)), make_cdf(density)]
    return EmissionGuide(*tables)


def _first_radius(positions: NDArray[np.float32], arriving: float) -> float:
    """Return the radius within which about `WANTED` of the arriving photons lie."""
    from scipy.spatial import cKDTree

    if len(positions) <= WANTED:
        return LARGEST
    some = positions[:: max(len(positions) // 512, 1)]
    distances = cKDTree(positions).query(some, k=WANTED + 1)[0][:, -1]
    denser = max(arriving / len(positions), 1e-3)
    return float(min(np.median(distances) / np.sqrt(denser), LARGEST))


def _sort(photons: CausticPhotons, radius: float) -> CausticMap:
    """Sort photons by buckets of boxes as wide as the disk."""
    positions, arrivals = photons.positions, photons.arrivals
    count = max(2 * len(positions), 1)
    buckets = np.empty(len(positions), np.int32)
    fill_buckets(positions, 2.0 * radius, 0, len(positions), count, buckets)
    order = np.argsort(buckets, kind="stable")
    starts = np.zeros(count + 1, np.int32)
    np.cumsum(np.bincount(buckets, minlength=count), out=starts[1:])
    arrivals = arrivals[order] if len(arrivals) else arrivals
    return CausticMap(positions[order], arrivals, photons.flux[order], starts, radius)
