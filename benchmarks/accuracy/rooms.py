"""Time to an error in twelve scenes of every kind: photon mapping, path tracing and Mitsuba 3."""

from __future__ import annotations

import math
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks.accuracy.calibration import COLUMNS, calibration, pixel_kinds, watched_prepass
from benchmarks.accuracy.cornell import LEVELS, MARK, Point, shown, time_to
from benchmarks.accuracy.mitsuba_client import LLVM, SCALAR, start_mitsuba
from benchmarks.accuracy.mitsuba_export import export_scene
from benchmarks.accuracy.room_mitsuba import DENOISED, RENDERS, SAMPLES, Rendered, render_or_read
from benchmarks.accuracy.room_scenes import scenes
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Cell, Table
from photonmap.film.bias import is_repeated
from photonmap.film.blocks import SIDE
from photonmap.film.budget import LEAST_PASSES, usual_photons
from photonmap.film.relative_error import relative_squares, valid_pixels

FEW = (
    (1, 0.125), (4, 0.125), (1, 0.25), (2, 0.25), (4, 0.25), (8, 0.25),
    (1, 0.5), (2, 0.5), (4, 0.5), (8, 0.5), (1, 1.0), (2, 1.0), (4, 1.0),
)  # fmt: skip
"""Passes and `pass_samples` of the first renders, which are compared with the longest one;"""
AIMED = math.sqrt(LEVELS[1])
"""the error that another one aims at, which chooses both;"""
SOME = 16
"""of the next, whose own errors count,"""
LONGEST = 60.0
"""and processor seconds of the longest, about, unless it reaches the last level sooner."""
LEAST = 1
"""Passes of the smallest budget, which cannot be divided."""
PATH_PASSES = 4
UNBIASED, SMALLER = 128, 4
"""Passes of the truth without bias, and by how much its image is narrower and lower."""
SCALAR_TO_LLVM = "2.7 and 1.9"
"""Mitsuba's scalar path tracer to the one compiled for vectors: docs/performance.md."""
RATIOS = ("path", "Mitsuba", "Mitsuba, denoised or not")

Settings = dict[str, Any]
Times = list[tuple[float, bool]]
"""Processor seconds to each level, infinite where it is never reached; whether extrapolated"""


@dataclass
class Ours:
    """What photon mapping took on one scene."""

    points: list[Point]
    """processor seconds and relMSE, which the bias is part of"""
    bias: float
    """share of the error of the longest render"""
    longest: pm.Result
    valid: NDArray[np.bool_]
    """(H, W), as `valid_pixels`"""
    rays: dict[str, float]
    """by kind, a pixel and pass,"""
    microseconds: float
    """and what such a pixel takes"""
    calibration: list[Cell]
    """of `SOME` passes against the longest: see `calibration.COLUMNS`"""

    def mean_of(self, name: str) -> tuple[float, float]:
        """Return the mean of "radiance" or "indirect" over valid pixels, and its standard error.

        Pixels share light, so its error is that of blocks; bands are taken to err alike.
        """
        parts = ("indirect", "direct") if name == "radiance" else ("indirect",)
        blocks = [self.longest.block_error(part).astype(float) * SIDE**2 for part in parts]
        squares = np.square(blocks).mean(axis=-1).sum()
        image = self.longest.buffers[name][self.valid]
        return float(image.mean(dtype=float)), float(math.sqrt(squares) / len(image))


@dataclass
class Compared:
    """One scene by all."""

    name: str
    own: Ours
    times: dict[str, Times]
    """of "ours", "path" and, if there is a Mitsuba, "Mitsuba" and "denoised\""""
    means: list[Cell]
    """bias, and differences from Mitsuba's means"""
    denoised: list[Point]
    """processor seconds and relMSE of Mitsuba's denoised renders, by `DENOISED`; or none"""
    small: list[Cell]
    """`calibration.COLUMNS` of a small image against one without bias, if there can be one"""
    variant: str = ""
    """of Mitsuba, empty if there is none"""
    reason: str = ""
    """why there is none"""

    @property
    def ratios(self) -> list[float]:
        """Of others' times to ours, at each level: `RATIOS`."""
        own, path, *others = ([time for time, _ in self.times[each]] for each in self.times)
        groups = [path, *others[:1]] + ([list(map(min, *others))] if others else [])
        return [time / least for each in groups for time, least in zip(each, own, strict=True)]


def run(options: Options) -> list[Table]:
    """Render each scene by all, one after the other."""
    found = []
    for name, (make, usual) in _choose(options.scenes).items():
        found.append(_compare(name, make(), options.size or usual, options))
        if options.size not in (None, usual):
            found[-1].name += f", {options.size[0]}×{options.size[1]}"
        print(f"rooms: {', '.join(map(str, _row(found[-1])))}", flush=True)
        texts = ", ".join(f"{ratio:.3g}" for ratio in found[-1].ratios)
        print(f"rooms: {found[-1].name}: ratios {texts}", flush=True)
    return tables(found, options)


def tables(found: list[Compared], options: Options) -> list[Table]:
    """Return what was measured of all scenes."""
    levels = ", ".join(f"{level:.0e}" for level in LEVELS)
    variant = found[0].variant
    times = Table(
        f"rooms: processor seconds to a relMSE, RGB, {variant or 'without Mitsuba'}",
        ["scene", *(f"{who}: {levels}" for who in found[0].times), "our least pass: relMSE"],
        [_row(each) for each in found],
        _notes(options, variant, found[0].reason),
    )
    differences = Table(
        "rooms: means over pixels without emission",
        ["scene", "bias / error", "mean − Mitsuba's", "±", "indirect light's", "±"],
        [[each.name, *each.means] for each in found],
    )
    calibrated = Table(
        f"rooms: 95% intervals that {SOME} passes state, against the longest",
        ["scene", *COLUMNS],
        [[each.name, *each.own.calibration] for each in found],
        ["pixels share light, so that shares of one pair of renders scatter by 1 or 2%"],
    )
    small = Table(
        f"rooms: the same at a quarter of the size, against {UNBIASED} passes without bias",
        ["scene", *COLUMNS],
        [[each.name, *each.small] for each in found if each.small],
    )
    denoised = _denoised(found)
    return [times, _ratios(found), differences, denoised, calibrated, small, _rays(found)]


def _ratios(found: list[Compared]) -> Table:
    """Return how many times our processor seconds others take."""
    columns = [f"{who}, {level:.0e}" for who in RATIOS for level in LEVELS]
    table = Table("rooms: times as many processor seconds as photon mapping", ["scene", *columns])
    table.rows = [[each.name, *each.ratios] for each in found]
    means = map(statistics.geometric_mean, zip(*(each.ratios for each in found), strict=True))
    table.rows.append(["geometric mean", *means])
    return table


def _row(each: Compared) -> list[Cell]:
    """Return the processor seconds of a scene, as text."""
    texts = [
        " / ".join(shown(*pair) if pair[0] < math.inf else "never" for pair in times)
        for times in each.times.values()
    ]
    return [each.name, *texts, f"{min(each.own.points)[1]:.1e}"]


def _denoised(found: list[Compared]) -> Table:
    """Return what denoising leaves of the error: it stops falling."""
    columns = [f"{count} {what}" for count in DENOISED for what in ("spp, s", "relMSE")]
    table = Table("rooms: Mitsuba with Open Image Denoise (albedo, normals)", ["scene", *columns])
    for each in found:
        table.rows.append([each.name, *(part for point in each.denoised for part in point)])
    return table


def _rays(found: list[Compared]) -> Table:
    """Return how many rays of each kind a pixel costs."""
    kinds = list(dict.fromkeys(kind for each in found for kind in each.own.rays))
    table = Table(
        "rooms: rays a pixel and pass, by kind, and what all of it takes",
        ["scene", *kinds, "processor time, µs"],
    )
    for each in found:
        counts = [each.own.rays.get(kind) for kind in kinds]
        table.rows.append([each.name, *counts, each.own.microseconds])
    return table


def _choose(names: tuple[str, ...]) -> dict[str, Any]:
    every = scenes()
    unknown = [name for name in names if name not in every]
    if unknown:
        raise SystemExit(f"there is no scene {unknown[0]!r}; choose from {', '.join(every)}")
    return {name: every[name] for name in names or every}


def _compare(name: str, scene: pm.Scene, size: tuple[int, int], options: Options) -> Compared:
    """Measure one scene."""
    settings: Settings = {"bands": "rgb", "size": size, "threads": options.threads}
    own = measure_photons(scene, settings)
    times = {
        "ours": [time_to(level, own.points, LEAST) for level in LEVELS],
        "path": times_at(path_cost(scene, settings)),
    }
    means: list[Cell] = [f"{own.bias:.0%}", None, None, None, None]
    compared = Compared(name, own, times, means, [], small_calibration(scene, settings))
    with tempfile.TemporaryDirectory() as folder:
        exported = export_scene(scene, size, Path(folder))
        other = start_mitsuba(options, exported[0])
        if isinstance(other, str):
            compared.reason = other
            return compared
        with other:
            rendered = render_or_read(other, exported, f"{name}-{size[0]}x{size[1]}", options.kept)
        compared.variant = f"Mitsuba {other.version}, {other.variant} path"
    times["Mitsuba"] = times_at(rendered.cost(own.valid))
    compared.denoised = denoised_points(rendered, own)
    times["denoised"] = [time_to_denoised(level, compared.denoised) for level in LEVELS]
    compared.means[1:] = [
        *mean_difference(own, rendered, "radiance"),
        *mean_difference(own, rendered, "indirect"),
    ]
    return compared


def mean_difference(own: Ours, rendered: Rendered, name: str) -> list[Cell]:
    """Return by how much our mean differs from Mitsuba's, and the standard error of that.

    Where specular surfaces are, what is direct light by one renderer is indirect by the other.
    """
    if name == "indirect" and "caustics" in own.longest.buffers:
        return [None, None]
    mean, error = own.mean_of(name)
    other, of_other = rendered.mean_of(name, own.valid)
    return [f"{mean / other - 1.0:+.2%}", f"{math.hypot(error, of_other) / other:.2%}"]


def times_at(cost: float) -> Times:
    """Return the processor seconds to each level at which variance × time is `cost`."""
    return [(cost / level, False) for level in LEVELS]


def measure_photons(scene: pm.Scene, settings: Settings) -> Ours:
    """Render with more and more passes, until the last level or `LONGEST` is reached."""
    with watched_prepass() as prepasses:
        ours.warm_up(scene, **settings, passes=LEAST_PASSES, pass_samples=0.125)
    kinds = pixel_kinds(prepasses[-1], settings["size"])
    few = [
        _render(scene, passes=passes, pass_samples=size, seed=seed, **settings)
        for seed, (passes, size) in enumerate(FEW, start=10)
    ]
    few.append(_render(scene, error=AIMED, seed=7, **settings))
    some, spent = _render(scene, passes=SOME, seed=8, **settings)
    points = [(spent, some.record["error"] ** 2)]
    needed = SOME * max(1.3 * points[0][1] / LEVELS[-1], 2.0)
    passes = max(min(round(needed), int(SOME * LONGEST / spent)), SOME)
    last, seconds = _render(scene, passes=passes, seed=9, **settings)
    points.append((seconds, last.record["error"] ** 2))
    valid = valid_pixels(last.coverage, last.emission, last.unresolved)
    for result, time_spent in few:
        error = distance(result.radiance[valid], last, valid)
        points.append((time_spent, max(error, points[0][1])))
    bias = (last.record["bias"] or 0.0) / last.record["error"]
    worth = (SOME + sum(map(is_repeated, range(SOME)))) * valid.size
    rays = {kind: count / worth for kind, count in some.record["rays_by_kind"].items()}
    held = calibration(some, last, valid, kinds)
    return Ours(points, bias, last, valid, rays, 1e6 * spent / worth, held)


def small_calibration(scene: pm.Scene, settings: Settings) -> list[Cell]:
    """Return `calibration.COLUMNS` of a small image against one without bias, if there can be one.

    It has as many photons as one of the usual size, and so cells as large.
    """
    width, height = settings["size"]
    size = max(width // SMALLER, 1), max(height // SMALLER, 1)
    photons = usual_photons(width * height)
    small: Settings = settings | {"size": size, "photons": photons}
    with watched_prepass() as prepasses:
        some = pm.render(scene, passes=SOME, seed=8, **small)
    if "caustics" in some.buffers:
        return []
    truth = pm.render(scene, passes=UNBIASED, seed=9, unbiased=True, **small)
    valid = valid_pixels(truth.coverage, truth.emission, truth.unresolved)
    return calibration(some, truth, valid, pixel_kinds(prepasses[-1], size))


def distance(values: NDArray[Any], longest: pm.Result, valid: NDArray[np.bool_]) -> float:
    """Return the relMSE of radiance at valid pixels, (V, N), without the longest render's noise."""
    truth = longest.radiance[valid].astype(float)
    squares = relative_squares((values - truth) ** 2, truth)
    return float(squares.mean()) - longest.record["standard_error"] ** 2


def _render(scene: pm.Scene, **settings: Any) -> tuple[pm.Result, float]:
    """Render; return the result, and its processor seconds without loading and compiling."""
    start = time.process_time()
    result = pm.render(scene, **settings)
    spent = result.record["seconds"]
    return result, time.process_time() - start - spent["load"] - spent["compile"]


def path_cost(scene: pm.Scene, settings: Settings) -> float:
    """Return processor seconds × relMSE of our own path tracer."""
    ours.warm_up(scene, **settings, method="path")
    result, seconds = _render(scene, **settings, method="path", passes=PATH_PASSES)
    return seconds * result.record["standard_error"] ** 2


def denoised_points(rendered: Rendered, own: Ours) -> list[Point]:
    """Return processor seconds and relMSE of denoised renders; none where there are none."""
    return [
        (float(seconds), distance(image[own.valid], own.longest, own.valid))
        for image, seconds in zip(rendered.denoised, rendered.denoised_seconds, strict=True)
    ]


def time_to_denoised(level: float, points: list[Point]) -> tuple[float, bool]:
    """Return the seconds to a relMSE, infinite where no budget reaches it; never extrapolated."""
    reached = [at for at, (_, error) in enumerate(points) if error <= level]
    if not reached:
        return math.inf, False
    first = reached[0]
    if first == 0:
        return points[0][0], False
    return time_to(level, points[first - 1 : first + 1], LEAST)


def _notes(options: Options, variant: str, reason: str) -> list[str]:
    notes = [
        f"{options.threads} threads; without loading and compiling; {MARK} extrapolated, with"
        " variance inversely proportional to time; the least is a pass of a quarter of the samples",
        "relMSE is mean(d² / (v² + 0.01 m²)) over pixels without emission: of photon mapping the"
        f" estimated error with its bias from {SOME} passes on, before that the distance to the"
        " longest render; of the path tracers their own variance; of denoised images the distance"
        f" to our longest render: never, if {DENOISED[-1]} samples do not reach it",
    ]
    if reason:
        return [*notes, reason]
    notes.append(f"Mitsuba's variance and mean are of {RENDERS} renders of {SAMPLES} samples")
    if options.kept:
        notes[-1] += ", kept from an earlier run, if there was one; its times are of this run"
    if SCALAR in variant:
        notes.append(
            f"{LLVM} does not run on this machine; where both ran, on the Cornell box without and"
            f" with balls, {SCALAR} took {SCALAR_TO_LLVM} times as long: divide by that to compare"
        )
    return notes
