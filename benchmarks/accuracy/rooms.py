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
from benchmarks.accuracy.cornell import LEVELS, MARK, Point, shown, time_to
from benchmarks.accuracy.mitsuba_client import DENOISED, LLVM, SCALAR, Mitsuba, start_mitsuba
from benchmarks.accuracy.mitsuba_export import export_scene
from benchmarks.accuracy.room_scenes import scenes
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Cell, Table
from photonmap.film.bias import is_repeated
from photonmap.film.relative_error import relative_squares, valid_pixels

FEW = ((1, 0.25), (2, 0.25), (1, 1.0), (4, 1.0))
"""Passes and `pass_samples` of the first renders, which are compared with the longest one;"""
SOME = 16
"""of the next, whose own errors count,"""
LONGEST = 60.0
"""and processor seconds of the longest, about, unless it reaches the last level sooner."""
LEAST = 1
"""Passes of the smallest budget, which cannot be divided."""
PATH_PASSES = 4
SAMPLES, RENDERS = 64, 4
"""Samples per pixel of one Mitsuba render, and number of renders."""
DENOISED_SAMPLES = (1, 4, 16, 64, 256)
"""Samples per pixel of renders that are denoised: their error does not fall as 1 / time."""
SCALAR_TO_LLVM = 3.2
"""Mitsuba's scalar path tracer to the one compiled for vectors: docs/performance.md."""

Settings = dict[str, Any]


@dataclass
class Ours:
    """What photon mapping took on one scene."""

    points: list[Point]
    """processor seconds and relMSE, which the bias is part of"""
    bias: float
    """share of the error of the longest render"""
    mean: float
    """radiance over valid pixels,"""
    mean_error: float
    """and its relative standard error"""
    valid: NDArray[np.bool_]
    """(H, W), as `valid_pixels`"""
    rays: dict[str, float]
    """by kind, a pixel and pass,"""
    microseconds: float
    """and what such a pixel takes"""
    truth: NDArray[np.float64]
    """(V, N) radiance of valid pixels in the longest render,"""
    noise: float
    """and its relMSE without the bias"""
    calibration: list[Cell]
    """of `SOME` passes against the longest: within 1.96 standard errors, beyond 5, blocks' worst"""


@dataclass
class Compared:
    """One scene by all."""

    name: str
    times: list[Cell]
    """row of the first table"""
    ratios: list[float]
    """of the path tracers' times to photon mapping's: our own at each level, then Mitsuba's"""
    variant: str
    """of Mitsuba, empty if there is none"""
    reason: str
    """why there is none"""
    rays: dict[str, float]
    microseconds: float
    calibration: list[Cell]
    """as in `Ours`"""
    denoised: list[Point]
    """processor seconds and relMSE of Mitsuba's denoised renders, by `DENOISED_SAMPLES`; or none"""


def run(options: Options) -> list[Table]:
    """Render each scene by all, one after the other."""
    found = []
    for name, (make, usual) in _choose(options.scenes).items():
        found.append(_compare(name, make(), options.size or usual, options))
        texts = ", ".join(f"{ratio:.3g}" for ratio in found[-1].ratios)
        print(f"rooms: {', '.join(map(str, found[-1].times))}; ratios {texts}", flush=True)
    levels = [f"{level:.0e}" for level in LEVELS]
    variant = found[0].variant
    title = f"rooms: processor seconds to a relMSE, RGB, {variant or 'without Mitsuba'}"
    times = Table(title, ["scene", *levels, "bias / error", "mean − Mitsuba's", "±"])
    times.rows = [each.times for each in found]
    times.notes = _notes(options, variant, found[0].reason)
    who = ("path", "Mitsuba", "Mitsuba, denoised or not")
    ratios = Table(
        "rooms: times as many processor seconds as photon mapping",
        ["scene", *(f"{each}, {level}" for each in who for level in levels)],
    )
    ratios.rows = [[each.name, *each.ratios] for each in found]
    means = map(statistics.geometric_mean, zip(*(each.ratios for each in found), strict=True))
    ratios.rows.append(["geometric mean", *means])
    return [times, ratios, _denoised(found), _calibrated(found), _rays(found)]


def _denoised(found: list[Compared]) -> Table:
    """Return what denoising leaves of the error: it stops falling."""
    columns = [f"{count} {what}" for count in DENOISED_SAMPLES for what in ("spp, s", "relMSE")]
    table = Table("rooms: Mitsuba with Open Image Denoise (albedo, normals)", ["scene", *columns])
    for each in found:
        table.rows.append([each.name, *(part for point in each.denoised for part in point)])
    return table


def _calibrated(found: list[Compared]) -> Table:
    columns = ["scene", "within 1.96 standard errors", "beyond 5", "indirect light, worst 8×8"]
    rows: list[list[Cell]] = [[each.name, *each.calibration] for each in found]
    return Table(f"rooms: errors that {SOME} passes state, against the longest", columns, rows)


def _rays(found: list[Compared]) -> Table:
    """Return how many rays of each kind a pixel costs."""
    kinds = list(dict.fromkeys(kind for each in found for kind in each.rays))
    table = Table(
        "rooms: rays a pixel and pass, by kind, and what all of it takes",
        ["scene", *kinds, "processor time, µs"],
    )
    for each in found:
        counts = [each.rays.get(kind) for kind in kinds]
        table.rows.append([each.name, *counts, each.microseconds])
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
    spent = [time_to(level, own.points, LEAST) for level in LEVELS]

    def over(cost: float) -> list[float]:
        return [cost / level / each for level, (each, _) in zip(LEVELS, spent, strict=True)]

    times: list[Cell] = [name, *(shown(*each) for each in spent), f"{own.bias:.0%}"]
    ratios = over(path_cost(scene, settings))
    about_rays = own.rays, own.microseconds, own.calibration
    with tempfile.TemporaryDirectory() as folder:
        file, power = export_scene(scene, size, Path(folder))
        other = start_mitsuba(options, file)
        if isinstance(other, str):
            return Compared(name, [*times, None, None], ratios, "", other, *about_rays, [])
        with other:
            cost, mean, error = measure_mitsuba(other, own.valid, power)
            denoised = measure_denoised(other, own, power)
    ratios += over(cost)
    ratios += [
        min(ratio, time_to_denoised(level, denoised) / each)
        for level, (each, _), ratio in zip(LEVELS, spent, over(cost), strict=True)
    ]
    times += [f"{own.mean / mean - 1.0:+.2%}", f"{math.hypot(error, own.mean_error):.2%}"]
    variant = f"Mitsuba {other.version}, {other.variant} path"
    return Compared(name, times, ratios, variant, "", *about_rays, denoised)


def measure_photons(scene: pm.Scene, settings: Settings) -> Ours:
    """Render with more and more passes, until the last level or `LONGEST` is reached."""
    ours.warm_up(scene, **settings)
    few = [
        _render(scene, passes=passes, pass_samples=size, seed=seed, **settings)
        for seed, (passes, size) in enumerate(FEW)
    ]
    some, spent = _render(scene, passes=SOME, seed=8, **settings)
    points = [(spent, some.record["error"] ** 2)]
    needed = SOME * max(1.3 * points[0][1] / LEVELS[-1], 2.0)
    passes = max(min(round(needed), int(SOME * LONGEST / spent)), SOME)
    last, seconds = _render(scene, passes=passes, seed=9, **settings)
    record = last.record
    points.append((seconds, record["error"] ** 2))
    valid = valid_pixels(last.coverage, last.emission, last.unresolved)
    truth = last.radiance[valid].astype(float)
    noise = record["standard_error"] ** 2
    for result, time_spent in few:
        squares = (result.radiance[valid] - truth) ** 2
        error = float(relative_squares(squares, truth).mean()) - noise
        points.append((time_spent, max(error, points[0][1])))
    standard_error = last.standard_error("radiance")[valid].astype(float)
    spread = math.sqrt((standard_error**2).sum()) / truth.sum()
    bias = (record["bias"] or 0.0) / record["error"]
    worth = (SOME + sum(map(is_repeated, range(SOME)))) * valid.size
    rays = {kind: count / worth for kind, count in some.record["rays_by_kind"].items()}
    return Ours(
        points, bias, float(truth.mean()), spread, valid, rays, 1e6 * spent / worth, truth, noise,
        _calibration(some, last, valid),
    )  # fmt: skip


def _calibration(some: pm.Result, last: pm.Result, valid: NDArray[np.bool_]) -> list[Cell]:
    """Return how far `some` is from `last` in their standard errors: see `Ours.calibration`."""
    error = np.hypot(some.standard_error("radiance"), last.standard_error("radiance"))[valid]
    far = np.abs(some.radiance - last.radiance)[valid] / np.maximum(error, 1e-30)
    own, others = some.block_error("indirect"), last.block_error("indirect")
    apart = np.abs(some.block_mean("indirect") - last.block_mean("indirect"))
    worst = (apart / np.maximum(np.hypot(own, others), 1e-30)).max()
    return [f"{(far < 1.96).mean():.1%}", f"{(far > 5.0).mean():.4%}", float(worst)]


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


def measure_mitsuba(
    other: Mitsuba, valid: NDArray[np.bool_], power: float
) -> tuple[float, float, float]:
    """Return processor seconds × relMSE, mean radiance, and its relative standard error."""
    images, seconds = [], []
    for seed in range(RENDERS):
        image, _ = other.render(SAMPLES, seed + 1)
        images.append(image[valid].astype(float) * power)
        seconds.append(other.processor)
    mean, variance = np.mean(images, axis=0), np.var(images, axis=0, ddof=1)
    error = math.sqrt(variance.sum() / RENDERS) / mean.sum()
    cost = statistics.mean(seconds) * float(relative_squares(variance, mean).mean())
    return cost, float(mean.mean()), error


def measure_denoised(other: Mitsuba, own: Ours, power: float) -> list[Point]:
    """Return processor seconds and relMSE of denoised renders; none where they cannot be made."""
    points = []
    for samples in DENOISED_SAMPLES:
        try:
            image, _ = other.render(samples, 1, DENOISED)
        except RuntimeError as error:
            print(f"rooms: not denoised: {str(error).strip().splitlines()[-1]}", flush=True)
            return []
        squares = (image[own.valid].astype(float) * power - own.truth) ** 2
        found = float(relative_squares(squares, own.truth).mean()) - own.noise
        points.append((other.processor, found))
    return points


def time_to_denoised(level: float, points: list[Point]) -> float:
    """Return the seconds to a relMSE, infinite where no budget reaches it."""
    reached = [at for at, (_, error) in enumerate(points) if error <= level]
    if not reached:
        return math.inf
    first = reached[0]
    return points[0][0] if first == 0 else time_to(level, points[first - 1 : first + 1], LEAST)[0]


def _notes(options: Options, variant: str, reason: str) -> list[str]:
    notes = [
        f"{options.threads} threads; without loading and compiling; {MARK} extrapolated, with"
        " variance inversely proportional to time; the least is a pass of a quarter of the samples",
        "relMSE is mean(d² / (v² + 0.01 m²)) over pixels without emission: of photon mapping the"
        f" estimated error with its bias from {SOME} passes on, before that the distance to the"
        " longest render; of the path tracers their own variance",
    ]
    if reason:
        notes.append(reason)
    elif SCALAR in variant:
        notes.append(
            f"{LLVM} does not run on this machine; where both ran, on the Cornell box, {SCALAR}"
            f" took {SCALAR_TO_LLVM} times as long: divide by that to compare with {LLVM}"
        )
    return notes
