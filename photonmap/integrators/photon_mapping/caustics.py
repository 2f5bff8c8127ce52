"""Caustic photons of each pass: guided to specular surfaces, and counted over shrinking disks.

A pilot run suggests where they leave emitters. Where pixels are large against the disks, photons
are connected to the camera instead, and sorted by pixel: light tracing.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.lights.probabilities import make_cdf
from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.pilot import count_photons
from photonmap.integrators.photon_mapping.specular_bounds import bound_specular_surfaces
from photonmap.kernels.bsdf.models import LAMBERTIAN
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN
from photonmap.kernels.camera.cameras import WITHOUT_FILM_POINTS
from photonmap.kernels.caustics.light_tracing import add_connected, connect_photons
from photonmap.kernels.caustics.photon_map import fill_buckets, sort_by_key, trace_caustics
from photonmap.kernels.core.passes import (
    CameraPass,
    CausticMap,
    CausticPhotons,
    Connections,
    EmissionGuide,
    Estimate,
    Span,
    View,
)
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.core.streams import Domain

Floats = NDArray[np.float64]

BOXES = 32
"""Of a guide, along each side of a unit square."""
PRIOR = 8
"""Photons by which a box or sphere is taken to be like all others, beside those it sent."""
DARK = 0.05
"""Least flux that a box is taken to emit, in means over the boxes."""


def even_guide(spheres: Floats) -> EmissionGuide:
    """Return a guide that prefers no position, for spheres, (K, 4), to aim at."""
    even = _tables(np.ones(BOXES**2))
    return EmissionGuide(*even, *even, spheres, np.ones(len(spheres)))


def learn(guide: EmissionGuide, pilot: CausticPhotons) -> EmissionGuide:
    """Return a guide by photons traced with an even one.

    The variance is least where the density follows the root of the mean square: of photons that
    arrive with the flux they left with, this is their flux times the root of their fraction.
    """
    boxes = np.minimum((pilot.origins[:, :4] * BOXES).astype(int), BOXES - 1)
    squares = (_density(boxes[:, axes] @ [BOXES, 1], pilot) for axes in ([0, 1], [2, 3]))
    spheres = pilot.origins[:, 4].astype(int)
    importance = _arriving(spheres, pilot.arrived, len(guide.spheres))
    position, aim = map(_tables, squares)
    return EmissionGuide(*position, *aim, guide.spheres, importance / importance.max())


def _density(box: NDArray[np.int64], pilot: CausticPhotons) -> Floats:
    """Return how densely photons should leave, by boxes, (B²,)."""
    counts = np.maximum(np.bincount(box, minlength=BOXES**2), 1)
    sent = np.bincount(box, pilot.emitted, BOXES**2) / counts
    density = np.maximum(sent, DARK * sent.mean()) * _arriving(box, pilot.arrived, BOXES**2)
    return density if density.any() else np.ones_like(density)


def _arriving(groups: NDArray[np.int64], arrived: NDArray[np.bool_], size: int) -> Floats:
    """Return the root of the fraction of photons that arrive, by groups."""
    all_of_them = (arrived.sum() + 1) / (len(arrived) + 1)
    came = np.bincount(groups, arrived, size) + PRIOR * all_of_them
    return np.sqrt(came / (np.bincount(groups, minlength=size) + PRIOR))


def _tables(density: Floats) -> tuple[Floats, Floats]:
    """Return the CDF of rows, and of boxes within each row."""
    square = density.reshape(BOXES, BOXES)
    return make_cdf(square.sum(axis=1)), make_cdf(square)


BUNDLE = 8192
"""Photons that are traced at a time."""
PILOT = 1 << 16
"""Photons that find specular surfaces before the passes."""
PILOT_REFLECTIONS = 1 << 20
"""Reflections of the pilot's photons, at most: where many linger between specular surfaces, as in a
ball of mirrors, the pilot has fewer photons, a sixteenth at least."""
LINGER_PILOT_PHOTONS = 1024
"""Photons used to estimate the fraction that lingers between specular surfaces."""
LINGER_REFLECTIONS = 64
"""Reflections after which a photon lingers."""
PHOTONS_PER_DISK = 20
"""Photons within a disk of the first pass, about."""
LARGEST_RADIUS = 0.02
"""Radius of a disk at most, in sizes of the scene."""
MOST_PHOTONS_FACTOR = 4
"""Caustic photons at most, times those of the radiosity cache."""
MOST_RAYS_PER_PHOTON = 16
"""Rays of a caustic photon, on average, above which they are fewer."""
_OF_ARRIVALS = ("positions", "arrivals", "flux", "edge_correction", "triangles", "barycentrics")
"""Arrays of `CausticPhotons` with a row for each photon that arrived."""


class CausticTracer:
    """Traces the caustic photons of passes, with random numbers of their own.

    The scene has specular surfaces.
    """

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        self._connects = can_connect(setup.view)
        arrays = setup.scene(0)
        lingering = _lingering_fraction(arrays, setup.bands, setup.key(0, Domain.LINGERING))
        fitting = PILOT_REFLECTIONS / max(lingering * LONGEST_CHAIN, 1.0)
        pilot = int(np.clip(fitting, PILOT // 16, PILOT))
        self._guide = even_guide(bound_specular_surfaces(arrays))
        found, _ = self._trace(0, pilot, Domain.CAUSTIC_PILOT)
        self._guide = learn(self._guide, found)
        check, rays = self._trace(0, pilot // 4, Domain.CAUSTIC_CHECK)
        rate = max(check.arrived.sum(), 1) / (pilot // 4)
        photons, wanted = max(setup.photons, 1), setup.pixels
        most: float = MOST_PHOTONS_FACTOR if found.arrived.any() or check.arrived.any() else 1
        most *= min(1.0, MOST_RAYS_PER_PHOTON * (pilot // 4) / max(rays, 1))
        self.photons = int(np.clip(wanted / rate, min(wanted, photons), most * photons))
        """Photons emitted in a pass"""
        self._radius = _first_radius(check.positions[:, :3], self.photons * rate)

    def trace(self, index: int, wider: int = 0) -> tuple[CausticMap, int]:
        """Return the caustic map of pass `index`, disks `wider` times doubled, and its rays."""
        radius = self._radius * (1.0 + index) ** (-1.0 / 6.0)
        connected = densest_connected(radius) if self._connects else 0.0
        radius *= 2.0**wider
        photons, rays = self._trace(index, self.photons, Domain.CAUSTICS, radius)
        return _sort(photons, radius, connected), rays

    def _trace(
        self, index: int, total: int, domain: Domain, radius: float = 0.0
    ) -> tuple[CausticPhotons, int]:
        """Trace photons of a pass in bundles; return them, and the number of rays."""
        bundles, scene = -(-total // BUNDLE), self._setup.scene(index)
        key = self._setup.key(index, domain)
        needed = {"positions", "flux", "edge_correction"}
        needed |= {"arrivals"} if scene.scattering else set()
        needed |= {"triangles"} if scene.geometry.alpha or scene.specular.glass else set()
        needed |= {"triangles", "barycentrics"} if self._connects else set()

        def trace(bundle: int) -> tuple[CausticPhotons, int]:
            span = Span(bundle * total // bundles, (bundle + 1) * total // bundles)
            photons = _make_rows(span.last - span.first, self._setup.bands)
            sums = np.empty(len(self._guide.spheres))
            rays = trace_caustics(scene, self._guide, key, span, total, radius, sums, photons)
            return _leave_out_lost(photons, needed), rays

        traced, rays = zip(*self._setup.workers.map(trace, bundles), strict=True)
        return CausticPhotons(*map(np.concatenate, zip(*traced, strict=True))), sum(rays)


def _make_rows(count: int, bands: int) -> CausticPhotons:
    """Return rows for photons to be traced."""
    origins, positions, arrivals, flux, barycentrics = (
        np.empty((count, width), np.float32) for width in (5, 6, 3, bands, 2)
    )
    emitted, edge_correction = np.empty((2, count), np.float32)
    arrived, triangles = np.empty(count, bool), np.empty(count, np.int32)
    arriving = positions, arrivals, flux, edge_correction, triangles, barycentrics
    return CausticPhotons(origins, emitted, arrived, *arriving)


def _leave_out_lost(photons: CausticPhotons, needed: Collection[str]) -> CausticPhotons:
    """Return photons without the rows of those that did not arrive, in the arrays needed."""
    arrived = photons.arrived
    rows = {name: getattr(photons, name) for name in _OF_ARRIVALS}
    return photons._replace(
        **{name: row[arrived] if name in needed else row[:0] for name, row in rows.items()}
    )


def no_caustics(bands: int) -> CausticMap:
    """Return a map without photons."""
    nothing = _make_rows(0, bands)
    return _map_of(nothing, np.zeros(1, np.int32), 1.0, 0.0)


def _map_of(
    photons: CausticPhotons, starts: NDArray[np.int32], radius: float, connected: float
) -> CausticMap:
    counted, places = photons[3:7], photons[7:]
    return CausticMap(*counted, starts, radius, *places, connected)


def _lingering_fraction(scene: SceneArrays, bands: int, key: np.uint64) -> float:
    """Return the fraction of photons that specular surfaces alone keep after many reflections.

    Of photons that lose nothing by them, and end at the first surface of another kind.
    """
    specular, textures, materials = scene.specular, scene.textures, scene.materials
    scattering, fluorescence = scene.scattering, scene.fluorescence
    assert specular
    if fluorescence:
        fluorescence = fluorescence._replace(matrix=np.zeros_like(fluorescence.matrix))
    if textures:
        textures = textures._replace(basis=np.zeros_like(textures.basis))
    if scattering:
        scattering = scattering._replace(model=np.full_like(scattering.model, LAMBERTIAN))
    lossless = specular._replace(
        mirror=np.ones_like(specular.mirror),
        tint=np.ones_like(specular.tint),
        grazing=np.zeros_like(specular.grazing),
    )
    black = materials._replace(reflectance=np.zeros_like(materials.reflectance))
    specular_only = scene._replace(
        specular=lossless,
        textures=textures,
        materials=black,
        scattering=scattering,
        fluorescence=fluorescence,
    )
    return count_photons(specular_only, bands, LINGER_PILOT_PHOTONS, LINGER_REFLECTIONS, key)[1]


def _first_radius(positions: NDArray[np.float32], arriving: float) -> float:
    """Return the radius within which about `PHOTONS_PER_DISK` of the arriving photons lie."""
    from scipy.spatial import cKDTree

    if len(positions) <= PHOTONS_PER_DISK:
        return LARGEST_RADIUS
    some = positions[:: max(len(positions) // 512, 1)]
    distances = cKDTree(positions).query(some, k=PHOTONS_PER_DISK + 1)[0][:, -1]
    denser = max(arriving / len(positions), 1e-3)
    return float(min(np.median(distances) / np.sqrt(denser), LARGEST_RADIUS))


def _sort(photons: CausticPhotons, radius: float, connected: float) -> CausticMap:
    """Sort photons by buckets of boxes as wide as the disk."""
    arrived = len(photons.positions)
    count = max(2 * arrived, 1)
    buckets, order = np.empty((2, arrived), np.int32)
    fill_buckets(photons.positions, 2.0 * radius, 0, arrived, count, buckets)
    starts = np.zeros(count + 2, np.int32)
    sort_by_key(buckets, starts, order)
    rows = {name: getattr(photons, name) for name in _OF_ARRIVALS}
    by_bucket = {name: row[order] if len(row) else row for name, row in rows.items()}
    return _map_of(photons._replace(**by_bucket), starts[:-1], radius, connected)


CONNECTED_BUNDLE = 4096
"""Photons that are connected at a time."""
LARGER_DISKS = 4.0
"""How many times the variance of disks photons may have where they are connected: disks so much
larger than a pixel have a bias that weighs more."""


def can_connect(view: View) -> bool:
    """Return whether each point in view has one film point, and pixels have an area."""
    camera, optics = view.camera, view.camera.optics
    is_sharp = not (optics and optics.lens.is_open)
    return view.film.jitter and is_sharp and camera.kind not in WITHOUT_FILM_POINTS


def densest_connected(radius: float) -> float:
    """Return how many pixels see a unit of area, at most, where photons are connected.

    There, of pixels with one camera sample. A parabolic disk has the variance of 3/4 of its area.
    """
    return LARGER_DISKS / (0.75 * math.pi * radius * radius)


def connect(setup: PassSetup, job: CameraPass, estimate: Estimate) -> int:
    """Add the photons that the camera sees to the estimate of a pass; return the rays cast."""
    caustics = job.photon_maps.caustics
    assert caustics is not None
    photons = len(caustics.positions)
    pixels, order = np.empty((2, photons), np.int32)
    weights = np.empty(photons, np.float32)
    bundles = max(-(-photons // CONNECTED_BUNDLE), 1)

    def look_back(bundle: int) -> int:
        span = Span(bundle * photons // bundles, (bundle + 1) * photons // bundles)
        rays: int = connect_photons(job, caustics, span, pixels, weights)
        return rays

    rays = sum(setup.workers.map(look_back, bundles))
    starts = np.zeros(setup.pixels + 2, np.int32)
    sort_by_key(pixels, starts, order)
    connections = Connections(starts, order, weights)
    setup.render_pixels(
        lambda span, own: add_connected(job, caustics, connections, span, own, estimate)
    )
    return rays
