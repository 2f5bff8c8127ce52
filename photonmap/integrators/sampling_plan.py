"""Decide how many samples each pixel gets, by a sampling pre-pass before the passes."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.integrators.base import PassSetup
from photonmap.kernels.core.passes import Film, Prepass, SamplingPlan, Span
from photonmap.kernels.core.records import Lights, SceneArrays
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.film.irradiance_sharing import Footprint, count_footprints, cut_strip
from photonmap.kernels.film.linked_pixels import link_pixels
from photonmap.kernels.film.pixels import FLAT
from photonmap.kernels.integrators.prepass import (
    AROUND,
    COLUMNS,
    MOST_AROUND,
    look_around,
    run_prepass,
)
from photonmap.kernels.lights.selection import SCRATCH

SAMPLES = 4
"""Camera samples of a pixel in a pass; a power of two, as coverage sums to 1."""
EDGE_SAMPLES = 16
"""The same where a pixel shows several surfaces, or a specular one."""


class LightSamples(NamedTuple):
    """Light samples of a pixel in a pass."""

    plain: int
    """where all reach their emitters, or none does"""
    penumbra: int
    """where some are occluded and some are not"""


LIGHT_SAMPLES = LightSamples(16, 64)
SKY_SAMPLES = LightSamples(64, 128)
"""The same with a sky among the emitters, whose light varies with what hides it."""
MANY_LIGHTS_SAMPLES = LightSamples(32, 64)
"""The same where a light tree chooses among many emitters."""
GATHERS, MOST_GATHERS = 8, 64
"""Gather rays of a pixel, and where few neighbours share their indirect light with it."""
MOST_LINKED_GATHERS, EDGE_GATHERS = 16, 32
"""The most of pixels that share by differences, which reach everywhere, and those at edges."""
SHARED_GATHERS = 256
"""Gather rays of all pixels of a footprint, where a pixel's own are not too many."""
FOOTPRINT_PIXELS = 6.0
"""Radius of the first pass's sharing footprints, pixels."""
FOOTPRINT_TURN = 0.08
"""Angle between the normals of pixels that share in the first passes, at most, radians."""
REACHES = 0.18, 0.28
"""Radius in space in images of 64 lines and of 240, in units of the root of 1 / (mean of 1 /
distance² to the surfaces around): see `footprint_reach`."""


def footprint_reach(film: Film) -> float:
    """Return how far footprints reach towards what is near, between `REACHES`.

    Pairs of pixels cancel the gradient of irradiance, whose measure is the mean of 1 / distance
    (Ward 1988). Second derivatives remain, as a bias that goes as (radius / distance)². Where an
    image has few lines, most of its pixels are limited by it.
    """
    least, most = REACHES
    return min(max(least * (min(film.width, film.height) / 64.0) ** (1.0 / 3.0), least), most)


class SharingRadii:
    """How far pixels share: the less, the nearer surfaces around are; as more and more rays say.

    The rays of a first pass are few, as they cost as much as half of it. What is wrong by their
    noise is so in each pass alike, and is not seen in their spread: as this falls, there are more.
    """

    def __init__(self, setup: PassSetup) -> None:
        self._setup, self._rays = setup, 0
        self.nearness, self._radii = (setup.storage.zeros(setup.pixels) for _ in range(2))
        self.plane = setup.storage.zeros((setup.pixels, 7))
        """That each pixel shows, if it is flat, as the pre-pass sees it"""

    def of_pass(self, index: int) -> NDArray[np.float32]:
        """Return the radii in full pass `index`, (P,), in space; the next call overwrites them."""
        return self.by(min(AROUND << max(index.bit_length() - 1, 0), MOST_AROUND))

    def by(self, rays: int) -> NDArray[np.float32]:
        """Return them by so many rays of each corner, `AROUND` or twice, 4 times, … as many."""
        if rays < self._rays:
            self.nearness[:], self._rays = 0.0, 0
        while self._rays < rays:
            self._look_around(max(2 * self._rays, AROUND))
        return self._radii

    def _look_around(self, rays: int) -> None:
        setup, view, span = self._setup, self._setup.view, Span(self._rays, rays)
        scene, key, nearness = setup.compiled.arrays, setup.key(0, Domain.PREPASS), self.nearness

        def look(lines: Span) -> None:
            sums = np.empty((2, 2 * view.film.width + 1))
            look_around(scene, view, key, span, lines, sums, nearness)

        setup.over_lines(look)
        self.take_in(rays)

    def take_in(self, rays: int) -> None:
        """Take in `nearness`, (P,), to which the last of so many rays of each corner were added."""
        self._rays = rays
        self._setup.over_lines(self._fill)

    def _fill(self, span: Span) -> None:
        """Fill the radii of the pixels of a span of lines."""
        film = self._setup.film
        nearness = _neighbours(self.nearness, film, span).mean(axis=0) / np.float32(self._rays)
        lines = slice(span.first * film.width, span.last * film.width)
        self._radii[lines] = footprint_reach(film) / np.sqrt(np.maximum(nearness, 1e-24))


def plan_sampling(setup: PassSetup, radii: SharingRadii | None = None) -> SamplingPlan:
    """Run the pre-pass over every pixel, and plan its sampling; radii know nothing before.

    The pre-pass looks at geometry and visibility alone, with random numbers of its own, so the
    passes that follow are neither biased nor correlated by what is decided here.
    """
    radii = radii or SharingRadii(setup)
    scene, view, storage, pixels = setup.compiled.arrays, setup.view, setup.storage, setup.pixels
    textured, key = _textured_materials(scene), setup.key(0, Domain.PREPASS)
    prepass = Prepass(*(storage.zeros(pixels, np.uint8) for _ in Prepass._fields))
    plane = radii.plane

    def run(span: Span) -> None:
        scratch = np.empty(SCRATCH), np.empty((2, 2 * view.film.width + 1, COLUMNS))
        run_prepass(scene, textured, view, key, span, scratch, (plane, radii.nearness), prepass)

    setup.over_lines(run)
    radii.take_in(AROUND)
    counts = (storage.zeros(pixels, np.uint8) for _ in range(3))
    rays = MOST_AROUND if setup.has_differences else AROUND
    plan = SamplingPlan(*counts, radii.by(rays))
    partners, enough = storage.zeros(pixels, np.uint8), SHARED_GATHERS / GATHERS
    footprint = Footprint(plane, plan.sharing_radius, 1.0, FOOTPRINT_PIXELS, FOOTPRINT_TURN)
    nothing = np.zeros((pixels, 0), np.float32)

    def count(lines: Span) -> None:
        strip, scratch = cut_strip(view.film, footprint, lines, nothing)
        count_footprints(strip, lines, scratch, enough, partners)

    setup.over_lines(count)
    if setup.has_differences:
        plan = plan._replace(links=_link(setup, plane, prepass.flat, plan.sharing_radius))
    planner = _Planner(
        view.film,
        prepass,
        partners,
        _light_samples(scene.lights),
        SAMPLES if scene.specular else 1,  # caustics vary within a pixel
        setup.spreads,
        (MOST_LINKED_GATHERS, EDGE_GATHERS) if setup.has_differences else (MOST_GATHERS,) * 2,
    )
    setup.over_lines(lambda span: planner.plan(span, plan))
    plane[:, FLAT] = prepass.flat
    return plan


def _light_samples(lights: Lights) -> LightSamples:
    """Return how many light samples the emitters of a scene call for."""
    if lights.environment and lights.dome >= 0:
        return SKY_SAMPLES
    return MANY_LIGHTS_SAMPLES if lights.tree else LIGHT_SAMPLES


def _link(
    setup: PassSetup,
    plane: NDArray[np.float32],
    flat: NDArray[np.uint8],
    radius: NDArray[np.float32],
) -> NDArray[np.uint8]:
    """Return which neighbours show the same flat surface, however far away, of each pixel, (P,)."""
    links, film = setup.storage.zeros(setup.pixels, np.uint8), setup.film
    footprint = Footprint(
        plane, radius, 1.0 / footprint_reach(film), FOOTPRINT_PIXELS, FOOTPRINT_TURN
    )
    setup.over_pixels(lambda span: link_pixels(film, footprint, span, flat, links))
    return links


@dataclass(frozen=True)
class _Planner:
    """Decides on the samples of pixels."""

    film: Film
    prepass: Prepass
    partners: NDArray[np.uint8]  # (P,) pixels of each footprint, or enough for `GATHERS`
    light_samples: LightSamples  # of a pixel
    least: int  # camera samples of an even pixel
    spreads: bool  # whether the samples of a pixel differ
    most_gathers: tuple[int, int]
    """gather rays at most of pixels of a flat surface, and those of others"""

    def plan(self, span: Span, plan: SamplingPlan) -> None:
        """Fill the plan of the pixels of a span of lines."""
        lines = slice(span.first * self.film.width, span.last * self.film.width)
        prepass = self.prepass
        penumbra = _neighbours(prepass.penumbra, self.film, span).max(axis=0) != 0
        flat, even, specular = (
            part[lines] != 0 for part in (prepass.flat, prepass.even, prepass.specular)
        )
        gathers = 2 ** np.ceil(np.log2(SHARED_GATHERS / self.partners[lines])).astype(int)
        most, others = self.most_gathers
        gathers = np.where(specular | ~flat, others, np.clip(gathers, GATHERS, most))
        samples = np.where(flat & ~specular, SAMPLES, EDGE_SAMPLES)
        samples[even & ~penumbra & (gathers == GATHERS)] = self.least
        if not self.spreads:
            samples[:] = 1
        lights = np.where(penumbra, self.light_samples.penumbra, self.light_samples.plain)
        plan.samples[lines] = samples
        plan.lights[lines] = np.maximum(lights // samples, 1)
        plan.gathers[lines] = np.maximum(gathers // samples, 1)


def _textured_materials(scene: SceneArrays) -> NDArray[np.uint8]:
    """Return of each material, (M,), whether it varies over a surface."""
    geometry, lights, textures = scene.geometry, scene.lights, scene.textures
    textured = np.zeros(len(scene.materials.reflectance), bool)
    if textures:
        textured |= textures.reflectance >= 0
    if scene.scattering and scene.scattering.maps:
        lobes = scene.scattering.maps
        images = lobes.roughness, lobes.glossy, lobes.anisotropy, lobes.coat, lobes.coat_roughness
        textured |= np.greater_equal(images, 0).any(axis=0)
    if (coats := getattr(scene.scattering, "coats", None)) and coats.relief:
        textured |= coats.relief.image >= 0
    if (sheens := getattr(scene.scattering, "sheens", None)) and sheens.maps:
        textured |= sheens.image >= 0
    if geometry.relief:
        textured |= geometry.relief.image >= 0
    if geometry.alpha:
        textured |= geometry.alpha.image >= 0
    if lights.emission_textures:
        textured |= lights.emission_textures.slot[: len(textured)] >= 0
    return textured.astype(np.uint8)


def _neighbours(values: NDArray, film: Film, span: Span) -> NDArray:
    """Return the values of a span of lines and of all eight neighbours, (9, L), edges doubled."""
    lines = np.clip(np.arange(span.first - 1, span.last + 1), 0, film.height - 1)
    image = values.reshape(film.height, film.width)[lines]
    padded = np.pad(image, ((0, 0), (1, 1)), mode="edge")
    views = np.lib.stride_tricks.sliding_window_view(padded, (span.last - span.first, film.width))
    return views.reshape(9, -1)
