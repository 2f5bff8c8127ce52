"""What integrators share: the setup of passes, their counters, and the arrays of an estimate."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from photonmap.compile.effects import EffectPlan
from photonmap.compile.scene_arrays import CompiledScene
from photonmap.kernels.core.passes import (
    CAUSTIC,
    CAUSTIC_IRRADIANCE,
    EXCITATION_DIRECT,
    EXCITATION_INDIRECT,
    FIRST_CAUSTIC,
    FLUORESCENT_DIRECT,
    FLUORESCENT_INDIRECT,
    LANES,
    RAY_KINDS,
    VIA_CAUSTIC,
    VIA_DIRECT,
    VIA_INDIRECT,
    CacheCells,
    Estimate,
    Film,
    Levels,
    Pixels,
    RadiosityCache,
    SamplingPlan,
    Scratch,
    Scratches,
    Span,
    View,
)
from photonmap.kernels.core.records import SceneArrays
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.lights.selection import SCRATCH
from photonmap.runtime.storage import RAM, Storage
from photonmap.runtime.workers import Workers

if TYPE_CHECKING:
    from photonmap.integrators.shared_work import SharedWork

TILE = 1024
"""Pixels of a span."""
LINES = 16
"""Lines of the image that are looked at, or share, at a time."""
LEVELS = 64
"""Fluorescent surfaces that a path may nest; at each, its probability to nest is at most 3/4."""


@dataclass(frozen=True)
class PassSetup:
    """What passes are made of."""

    compiled: CompiledScene  # the scene
    film: Film  # the image
    bands: int  # N, columns that passes carry
    photons: int  # emitted in each pass
    seed: int  # of all random numbers
    workers: Workers  # that share the work
    effects: EffectPlan | None = None  # which are simulated; None for all
    storage: Storage = RAM  # where the arrays lie
    unbiased: bool = False  # whether the mean of passes is to be exact
    shared: SharedWork | None = None  # by the views of a scene; None where there is one
    light: Hashable = None  # of these, what decides the photons

    @property
    def pixels(self) -> int:
        """P."""
        return self.film.width * self.film.height

    @cached_property
    def view(self) -> View:
        """The camera over the film."""
        return View(self.compiled.film_camera(self.film.width, self.film.height), self.film)

    @property
    def spreads(self) -> bool:
        """Whether the camera samples of a pixel differ: over its area, or over a lens."""
        optics = self.view.camera.optics
        return self.film.jitter or bool(optics and optics.lens.is_open)

    @property
    def has_differences(self) -> bool:
        """Whether pixels share by differences: see `kernels.integrators.irradiance_differences`.

        A surface that is partly transparent would be seen by one ray and not by another.
        """
        return self.unbiased and self.compiled.geometry.alpha is None

    def simulates(self, effect: str) -> bool:
        """Return whether an effect is simulated."""
        return self.effects is None or self.effects.on(effect)

    def key(self, index: int, domain: Domain) -> np.uint64:
        """Return the key of a family of random streams of pass `index`."""
        return stream_key(self.seed, index, domain)

    def scene(self, index: int) -> SceneArrays:
        """Return the scene of pass `index`, which chooses a wavelength in each band for glass."""
        arrays, specular = self.compiled.arrays, self.compiled.specular
        if specular is None or specular.media is None or specular.media.dispersion is None:
            return arrays
        media = arrays.specular.media
        steps = media.dispersion.steps
        step = int(self.key(index, Domain.WAVELENGTHS) % np.uint64(len(steps)))
        media = media._replace(dispersion=media.dispersion._replace(ior=steps[step]))
        return arrays._replace(specular=arrays.specular._replace(media=media))

    def over_pixels(self, task: Callable[[Span], object]) -> None:
        """Run a task over spans of pixels."""
        self.workers.ranges(lambda first, last: task(Span(first, last)), self.pixels, TILE)

    def over_lines(self, task: Callable[[Span], object]) -> None:
        """Run a task over spans of lines of the image."""
        self.workers.ranges(lambda first, last: task(Span(first, last)), self.film.height, LINES)

    def render_pixels(self, task: Callable[[Span, Scratches], object]) -> dict[str, int]:
        """Run a camera pass over spans of pixels; return the rays that it cast, by kind."""
        counts = []

        def render(span: Span) -> None:
            scratches = make_scratches(self.compiled, self.bands, self.unbiased)
            task(span, scratches)
            counts.append(scratches.own.rays)

        self.over_pixels(render)
        return dict(zip(RAY_KINDS, np.sum(counts, axis=0).tolist(), strict=True))


@dataclass
class Counters:
    """All that passes leave behind in an integrator; each is else a function of seed and index."""

    photons: int = 0
    """emitted"""
    stores: int = 0
    """entries of photons in radiosity caches"""
    truncated: int = 0
    """photons truncated after `MAX_BOUNCES`"""
    photon_seconds: float = 0.0
    caustic_seconds: float = 0.0
    reused: int = 0
    """of the photons, those that were traced for an earlier view of the scene"""
    rays_by_kind: dict[str, int] = field(default_factory=dict)
    """cast in passes: those of `RAY_KINDS`, `photon` and `caustic`; in path tracing `path`"""

    @property
    def rays(self) -> int:
        """Rays of all kinds."""
        return sum(self.rays_by_kind.values())

    def add_rays(self, **counts: int) -> None:
        """Add numbers of rays by kind; a kind of which there are none is not named."""
        for kind, count in counts.items():
            if count:
                self.rays_by_kind[kind] = self.rays_by_kind.get(kind, 0) + count

    def add(self, other: Counters) -> None:
        """Add what is counted elsewhere."""
        self.add_rays(**other.rays_by_kind)
        for name, value in asdict(other).items():
            if name != "rays_by_kind":
                setattr(self, name, getattr(self, name) + value)

    def describe(self) -> dict[str, Any]:
        """Return what the run record says of them."""
        return {
            "photons": self.photons,
            "photons_reused": self.reused,
            "photons_stored": self.stores,
            "rays": self.rays,
            "rays_by_kind": dict(self.rays_by_kind),
        }

    def restore(self, counters: dict[str, Any]) -> None:
        """Go on from the counters of earlier passes."""
        for name, value in asdict(Counters(**counters)).items():
            setattr(self, name, value)


class Integrator(Protocol):
    """Estimates every pixel, pass by pass; replicates are independent of each other.

    A new integrator implements this, and is entered in `METHODS`.
    """

    counters: Counters
    setup_seconds: float
    """spent on what is done once"""
    sample_scales: np.ndarray | None
    """(2, 2, P), of later passes of either half: log2 of the factors on light samples and on gather
    rays; None for none"""

    adapts: bool
    """whether passes follow `sample_scales`, can be resized, and go on within replicates"""

    def estimate(self, index: int, wider: int = 0) -> Estimate:
        """Run pass `index` (from 0); the next one overwrites the arrays.

        Supports (cells, footprints, disks) are `wider` times doubled in width, with the same random
        numbers.
        """

    @property
    def plan(self) -> SamplingPlan:
        """How many samples each pixel gets before they are scaled."""

    @property
    def surfaces(self) -> np.ndarray:
        """The plane that each pixel shows, (P, 7), by geometry alone; zeros where it is not flat.

        `kernels.film.pixels` says what is in it.
        """

    @property
    def shares(self) -> bool:
        """Whether pixels share their indirect light with neighbours."""

    @property
    def many_lights(self) -> bool:
        """Whether emitters are many, so that small passes need more samples."""

    @property
    def has_supports(self) -> bool:
        """Whether light is averaged over cells, footprints or disks, which biases it."""

    @property
    def stores_photons(self) -> bool:
        """Whether photons are stored, so that a pixel that found none is unresolved."""

    @property
    def effect_seconds(self) -> dict[str, float]:
        """Seconds of the effects that are timed apart."""

    def truncated_fraction(self) -> float:
        """Return about which fraction of camera paths is truncated."""

    def resize_passes(self, size: float) -> None:
        """Take this fraction of the usual samples in passes from now on, if passes adapt."""

    def compile_camera_pass(self) -> None:
        """Compile the kernel of the camera pass by a call, on a scene of one triangle."""

    def compile_other_kernels(self) -> Estimate:
        """Compile the other kernels of a pass by a call each; return an estimate of any values."""


def stream_key(seed: int, index: int, domain: Domain) -> np.uint64:
    """Return the key of an independent family of random streams."""
    text = f"{seed} {index} {int(domain)}".encode()
    return np.uint64(int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little"))


def make_scratches(compiled: CompiledScene, bands: int, unbiased: bool = False) -> Scratches:
    """Make what a kernel needs for one sample."""
    throughput, chain, response, walk = np.empty((4, bands), np.float32)
    rows = CAUSTIC + 1 if compiled.specular is not None else CAUSTIC
    scattered = rows if compiled.scattering is not None else 0
    levels = LEVELS if compiled.fluorescence is not None else 0
    own = Scratch(
        throughput,
        chain,
        np.empty((rows, bands), np.float32),
        np.empty((2, LANES)),
        np.empty((3, LANES)),
        response,
        walk,
        np.empty(SCRATCH),
        np.zeros(len(RAY_KINDS), np.int64),
        np.empty((4, 11)),
        Levels(
            np.zeros(2, np.int64),
            np.empty(levels, np.int64),
            np.empty(levels),
            np.empty((levels, 3, bands), np.float32),
        ),
    )
    incident = np.empty((rows if unbiased else scattered, bands), np.float32)
    beyond = np.empty((scattered, bands), np.float32)
    excited = np.empty((scattered if levels else 0, bands), np.float32)
    return Scratches(
        own,
        own._replace(irradiance=incident),
        own._replace(irradiance=beyond),
        own._replace(irradiance=excited),
    )


def empty_cache(bands: int) -> RadiosityCache:
    """Make a radiosity cache that never answers."""
    none = np.zeros((0, 2), np.int32), np.zeros(0, np.int32), np.zeros((0, 2), np.float32)
    cells = CacheCells(*none, np.zeros(0, np.int32), *np.zeros((2, 0), np.bool_), 1)
    return RadiosityCache(cells, np.zeros((0, bands), np.float32))


def empty_estimate(setup: PassSetup) -> Estimate:
    """Make the arrays of a pass."""
    size, bands, storage = setup.pixels, setup.bands, setup.storage
    pixels = Pixels(
        *storage.zeros((6, size, bands)),
        coverage=storage.zeros(size),
        lookups=storage.zeros(size, np.uint8),
        plane=storage.zeros((size, 7)),
    )
    fluorescent = setup.compiled.fluorescence is not None
    has_via = fluorescent or setup.compiled.has_residual
    via = storage.zeros((9 if fluorescent else 5, size, bands)) if has_via else None
    differences = storage.zeros((5, size, bands)) if setup.has_differences else None
    return Estimate(pixels, via, differences)


def leave_out(setup: PassSetup, estimate: Estimate) -> Estimate:
    """Clear what was estimated along the way, though its effect is left out."""
    of_direct: tuple[int, ...] = ()
    of_indirect: tuple[int, ...] = ()
    if setup.compiled.fluorescence is not None:
        of_direct = FLUORESCENT_DIRECT, EXCITATION_DIRECT
        of_indirect = FLUORESCENT_INDIRECT, EXCITATION_INDIRECT
    for effect, names, rows in (
        ("emission", ("emission",), ()),
        ("direct", ("direct", "irradiance_direct"), (VIA_DIRECT, *of_direct)),
        ("indirect", ("indirect", "irradiance_indirect"), (VIA_INDIRECT, *of_indirect)),
        ("caustics", (), (FIRST_CAUSTIC, CAUSTIC_IRRADIANCE, VIA_CAUSTIC)),
    ):
        if not setup.simulates(effect):
            for name in names:
                getattr(estimate.pixels, name)[:] = 0.0
            if estimate.via_specular is not None:
                estimate.via_specular[list(rows)] = 0.0
    return estimate
