"""Photon mapping: photons → radiosity cache and caustic map → camera pass → irradiance sharing.

A pass depends on the seed and its own number alone, and is the same for any number of threads. Its
photons are its own; the samples of a pixel go on through the passes of a replicate. From pass to
pass, cells, disks and footprints shrink, so the answer converges to the truth (Knaus and Zwicker
2011).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property

import numpy as np

from photonmap.film.bias import REACH_HOLDS, footprint_width
from photonmap.film.replicates import replicate_place, replicate_size
from photonmap.integrators.adaptive_sampling import are_many, photons_of, resize, scale_plan
from photonmap.integrators.base import (
    Counters,
    PassSetup,
    empty_cache,
    empty_estimate,
    leave_out,
)
from photonmap.integrators.photon_mapping.caustics import connect, no_caustics
from photonmap.integrators.photon_mapping.photon_tracer import PhotonTracer, tracer_of
from photonmap.integrators.sampling_plan import (
    FOOTPRINT_PIXELS,
    FOOTPRINT_TURN,
    SharingRadii,
    plan_sampling,
)
from photonmap.kernels.core.passes import (
    CameraPass,
    CausticMap,
    Estimate,
    PhotonMaps,
    Pixels,
    SamplingPlan,
    Span,
)
from photonmap.kernels.core.record_types import absent
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.film.irradiance_sharing import (
    Footprint,
    cut_strip,
    fill_centre_fluorophores,
    share_fluorescence,
    share_irradiance,
)
from photonmap.kernels.film.pixels import FLAT
from photonmap.kernels.integrators.camera_pass import Turn, camera_pass
from photonmap.kernels.lights.selection import FEW_EMITTERS


class PhotonIntegrator:
    """Estimates pixels by photon mapping with final gathering; see `Integrator`."""

    adapts = True

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        self._specular = setup.compiled.specular is not None
        self._size = 1.0
        self._estimate = empty_estimate(setup)
        self._shared = setup.storage.zeros((setup.pixels, setup.bands))
        self.counters = Counters()
        self.setup_seconds = 0.0
        self.sample_scales: np.ndarray | None = None

    def estimate(self, index: int, wider: int = 0) -> Estimate:
        """Run pass `index`, as `Integrator.estimate` says."""
        photon_maps = self.trace_photons(index, wider)
        estimate = self.run_camera_pass(index, photon_maps)
        if self.shares:
            estimate = self.share(index, estimate, wider)
        return leave_out(self._setup, estimate)

    @property
    def shares(self) -> bool:
        """Whether pixels share their indirect light with neighbours."""
        return self._setup.simulates("indirect")

    @property
    def many_lights(self) -> bool:
        """Whether emitters are many."""
        return are_many(self._emitters)

    @property
    def _emitters(self) -> int:
        return len(self._setup.compiled.lights.cdf)

    @property
    def has_supports(self) -> bool:
        """Whether light is averaged over cells, footprints or disks."""
        return self.shares or (self._specular and self._setup.simulates("caustics"))

    @property
    def stores_photons(self) -> bool:
        """Whether photons are stored, so that a pixel that found none is unresolved."""
        return self.counters.stores > 0

    @property
    def effect_seconds(self) -> dict[str, float]:
        """Seconds of the effects that are timed apart: of their photons."""
        counters = self.counters
        spent = {"indirect": counters.photon_seconds - counters.caustic_seconds}
        return spent | ({"caustics": counters.caustic_seconds} if self._specular else {})

    def trace_photons(self, index: int, wider: int = 0) -> PhotonMaps:
        """Return the photons of a pass: its radiosity cache, and its caustic map if it has one."""
        before = self._tracer.setup_seconds
        maps, counters = self._tracer.trace(index, wider)
        self.setup_seconds += self._tracer.setup_seconds - before
        self.counters.add(counters)
        return maps

    def run_camera_pass(self, index: int, photon_maps: PhotonMaps) -> Estimate:
        """Run the camera pass: direct light, final gathering, specular chains."""
        setup = self._setup
        with self._setting_up():
            plan = self._scaled_plan(index)
        job = self._job(index, photon_maps, plan)
        turn = Turn(replicate_place(index), replicate_size(index))
        rays = setup.render_pixels(
            lambda span, own: camera_pass(job, turn, span, own, self._estimate)
        )
        self.counters.add_rays(**rays)
        if photon_maps.caustics is not None and photon_maps.caustics.connected > 0.0:
            self.counters.add_rays(shadow=connect(setup, job, self._estimate))
        return self._estimate

    def _job(self, index: int, photon_maps: PhotonMaps, plan: SamplingPlan) -> CameraPass:
        setup = self._setup
        first, scene = index - replicate_place(index), setup.scene(index)
        if photon_maps.caustics is None and scene.specular is not None:
            photon_maps = photon_maps._replace(caustics=absent(CausticMap))
        return CameraPass(scene, photon_maps, setup.view, plan, setup.key(first, Domain.CAMERA))

    def share(self, index: int, estimate: Estimate, wider: int = 0) -> Estimate:
        """Share indirect irradiance between neighbouring pixels of one surface."""
        scale, pixels = footprint_width(index) * 2.0**wider, estimate.pixels
        with self._setting_up():
            radius = self._radii.of_pass(int(index * self._size))
        reach = footprint_width(index, REACH_HOLDS) * 2.0**wider
        footprint = Footprint(
            pixels.plane, radius, reach, FOOTPRINT_PIXELS * scale, FOOTPRINT_TURN * scale
        )
        self._setup.over_lines(lambda lines: self._share_lines(footprint, lines, pixels))
        self.share_fluorescence(pixels.irradiance_indirect, self._shared, estimate)
        return estimate._replace(pixels=pixels._replace(irradiance_indirect=self._shared))

    def _share_lines(self, footprint: Footprint, lines: Span, pixels: Pixels) -> None:
        """Share the indirect irradiance of a span of lines, as `share_irradiance`."""
        strip, scratch = cut_strip(self._setup.film, footprint, lines, pixels.irradiance_indirect)
        share_irradiance(strip, lines, scratch, pixels, self._shared)

    def share_fluorescence(self, own: np.ndarray, shared: np.ndarray, estimate: Estimate) -> None:
        """Change what fluoresces as sharing changed indirect irradiance, (P, N)."""
        setup, fluorescence = self._setup, self._setup.compiled.fluorescence
        if fluorescence is not None:
            centre, via = self._centre_fluorophores, estimate.via_specular
            setup.over_pixels(
                lambda span: share_fluorescence(fluorescence, centre, span, own, shared, via)
            )

    @cached_property
    def _centre_fluorophores(self) -> np.ndarray:
        setup = self._setup
        centre, scene = setup.storage.zeros((2, setup.pixels)), setup.scene(0)
        with self._setting_up():
            setup.over_pixels(
                lambda span: fill_centre_fluorophores(scene, setup.view, span, centre)
            )
        return centre

    def resize_passes(self, size: float) -> None:
        """Take this fraction of the usual samples from now on, and photons to match."""
        self._size = size
        vars(self).pop("_tracer", None)
        with self._setting_up():
            flat = self.surfaces[:, FLAT]
            self.plan = resize(self._usual_plan, size, flat, self._emitters)

    @cached_property
    def plan(self) -> SamplingPlan:
        """How many samples each pixel gets before they are scaled."""
        return self._usual_plan

    @property
    def surfaces(self) -> np.ndarray:
        """The plane that each pixel shows, (P, 7), as the sampling pre-pass sees it."""
        assert self._usual_plan
        return self._radii.plane

    @cached_property
    def _tracer(self) -> PhotonTracer:
        setup = self._setup
        return tracer_of(replace(setup, photons=photons_of(setup.photons, self._size)))

    @cached_property
    def _radii(self) -> SharingRadii:
        return SharingRadii(self._setup)

    @cached_property
    def _usual_plan(self) -> SamplingPlan:
        plan = plan_sampling(self._setup, self._radii)
        if not self._setup.simulates("indirect"):
            plan = plan._replace(gathers=np.zeros_like(plan.gathers))
        if not self._setup.simulates("soft_shadows") and self._emitters <= FEW_EMITTERS:
            plan = plan._replace(lights=np.ones_like(plan.lights))
        return plan

    def _scaled_plan(self, index: int) -> SamplingPlan:
        """Return the plan of pass `index`."""
        scales = self.sample_scales
        half = index // replicate_size(index) % 2
        if scales is None or not scales[half].any():
            return self.plan
        return scale_plan(self.plan, scales[half], self._setup.spreads)

    def truncated_fraction(self) -> float:
        """Return 0: camera rays end in the cache, and truncated photons are counted."""
        return 0.0

    def compile_camera_pass(self) -> None:
        """Compile the sampling pre-pass, and the camera pass, which has most of its code.

        One sample, on photon maps that hold nothing.
        """
        plan_sampling(self._setup)
        self.plan = _one_sample(self._setup)
        bands = self._setup.bands
        caustics = no_caustics(bands) if self._specular else None
        self.run_camera_pass(0, PhotonMaps(empty_cache(bands), caustics))

    def compile_other_kernels(self) -> Estimate:
        """Compile the kernels of the photon pass and of sharing."""
        self.plan = _one_sample(self._setup)
        photon_maps = self.trace_photons(0)
        if photon_maps.caustics is not None:
            connect(self._setup, self._job(0, photon_maps, self.plan), self._estimate)
        return self.share(0, self._estimate)

    @contextmanager
    def _setting_up(self) -> Iterator[None]:
        """Take the time of what is done once, in the first pass."""
        start = time.perf_counter()
        yield
        self.setup_seconds += time.perf_counter() - start


def _one_sample(setup: PassSetup) -> SamplingPlan:
    """Return the plan of an image of one pixel."""
    links = np.zeros(1, np.uint8) if setup.has_differences else None
    return SamplingPlan(*np.ones((3, 1), np.uint8), np.ones(1, np.float32), links)
