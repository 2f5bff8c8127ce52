"""Plain path tracing over the same scene: slow and unbiased, the reference for photon mapping."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from photonmap.integrators.base import (
    Counters,
    PassSetup,
    empty_cache,
    empty_estimate,
    leave_out,
)
from photonmap.integrators.photon_mapping.pilot import truncated_fraction
from photonmap.integrators.sampling_plan import SAMPLES, plan_sampling
from photonmap.kernels.core.passes import (
    MAX_BOUNCES,
    CameraPass,
    Estimate,
    PhotonMaps,
    SamplingPlan,
)
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.integrators.camera_pass import path_pass


class PathIntegrator:
    """Estimates pixels by path tracing with next-event estimation; see `Integrator`."""

    many_lights = shares = has_supports = adapts = False
    setup_seconds = 0.0
    sample_scales: np.ndarray | None = None

    def __init__(self, setup: PassSetup) -> None:
        self._setup = setup
        self._estimate = empty_estimate(setup)
        self.counters = Counters()

    def estimate(self, index: int, wider: int = 0) -> Estimate:
        """Run pass `index`, as `Integrator.estimate` says; there are no supports to widen."""
        setup = self._setup
        key = setup.key(index, Domain.CAMERA)
        photon_maps = PhotonMaps(empty_cache(setup.bands), None)
        job = CameraPass(setup.scene(index), photon_maps, setup.view, NO_PLAN, key)
        bounces = MAX_BOUNCES if setup.simulates("indirect") else 1
        rays = setup.render_pixels(
            lambda span, own: path_pass(job, SAMPLES, bounces, span, own, self._estimate)
        )
        self.counters.add_rays(path=rays.pop("walk"), **rays)
        return leave_out(setup, self._estimate)

    def resize_passes(self, size: float) -> None:
        """Do nothing: a pass is one path for each sample."""

    @cached_property
    def plan(self) -> SamplingPlan:
        """How many samples photon mapping would take."""
        return plan_sampling(self._setup)

    @property
    def surfaces(self) -> np.ndarray:
        """Zeros: nothing is shared by planes."""
        return np.zeros((self._setup.pixels, 7), np.float32)

    @property
    def stores_photons(self) -> bool:
        """Whether photons are stored, so that a pixel that found none is unresolved."""
        return self.counters.stores > 0

    @property
    def effect_seconds(self) -> dict[str, float]:
        """Seconds of the effects that are timed apart: none."""
        return {}

    def truncated_fraction(self) -> float:
        """Return about which fraction of paths is truncated."""
        if not self._setup.simulates("indirect"):
            return 0.0
        key = self._setup.key(0, Domain.TRUNCATION)
        return truncated_fraction(self._setup.compiled, self._setup.bands, MAX_BOUNCES, key)

    def compile_camera_pass(self) -> None:
        """Compile the path tracer."""
        self.estimate(0)

    def compile_other_kernels(self) -> Estimate:
        """Return an empty estimate: there are none."""
        return self._estimate


NO_PLAN = SamplingPlan(*np.zeros((3, 0), np.uint8), np.zeros(0, np.float32))
