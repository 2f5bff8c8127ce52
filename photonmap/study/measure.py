"""Points: renders of sweeps, measured and kept; and what their timings depend on."""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import psutil

from photonmap.render import render
from photonmap.results.record import describe_versions
from photonmap.results.result import Result
from photonmap.runtime.progress import Progress
from photonmap.scene.scene import Scene
from photonmap.settings import Options
from photonmap.spectra.bands import Bands
from photonmap.spectra.sensitivities import Limits
from photonmap.study import errors


@dataclass(frozen=True, kw_only=True)
class Settings(Options):
    """The options of a render, those that a study varies as they are written."""

    bands: str = "6"
    size: tuple[int, int] = (128, 128)
    passes: int = 16
    effects: str = "auto"


@dataclass(frozen=True)
class Point:
    """A measured render."""

    sweep: str  # the sweep that it belongs to
    label: str  # what distinguishes it within the sweep
    settings: Settings  # of the render; `passes` is the number that was completed
    wall: float  # wall-clock seconds of rendering, without loading and compiling
    processor: float  # processor seconds of rendering, over all threads
    seconds: float  # the time to use, by one of these two clocks
    rays: int | None  # number of rays; None where they are not counted
    photons: int  # number of photons emitted in all passes
    # relative errors by buffer, as the render states them; nan after a single pass
    stated: dict[str, float]
    # relative errors by buffer, against the reference; empty if it does not fit
    true: dict[str, float] = field(default_factory=dict)
    # relative difference of mean radiance from the reference; nan if it does not fit
    mean_difference: float = math.nan
    # relative standard error of mean radiance; nan except for path tracing, whose pixels are
    # independent
    mean_error: float = math.nan
    # colour errors against many bands; None without a render of those
    color: errors.ColorError | None = None
    picture: str = ""  # the image as a data URI
    error_map: errors.ErrorMap | None = None  # map of the errors; None without an estimate

    def row(self) -> dict[str, object]:
        """Return the point as a row of the table, by `COLUMNS`; unknown values are empty."""
        options = self.settings
        values = (
            *(self.sweep, self.label, options.method, options.bands, *options.size),
            *(options.pixel, options.photons, options.passes, options.effects, options.seed),
            *(self.seconds, self.wall, self.processor, self.rays, self.photons),
            *(self.stated.get(buffer) for buffer in errors.BUFFERS),
            *(self.true.get(buffer) for buffer in errors.BUFFERS),
            *(self.mean_difference, self.mean_error),
            *(getattr(self.color, name, None) for name in _COLORS.values()),
        )
        return dict(zip(COLUMNS, map(_cell, values), strict=True))


_COLORS = {
    "delta_e_mean": "delta_mean",
    "delta_e_p95": "delta_p95",
    "delta_e_indirect_mean": "indirect_mean",
    "delta_e_indirect_p95": "indirect_p95",
    "spectral_luminance": "luminance",
    "spectral_radiance": "radiance",
    "spectral_shading": "shading",
    "spectral_indirect": "indirect",
}
COLUMNS = (
    *("sweep", "label", "method", "bands", "width", "height"),
    *("pixel", "photons_per_pass", "passes", "effects", "seed"),
    *("seconds", "wall_seconds", "processor_seconds", "rays", "photons"),
    *(f"stated_{buffer}" for buffer in errors.BUFFERS),
    *(f"true_{buffer}" for buffer in errors.BUFFERS),
    *("mean_difference", "mean_error"),
    *_COLORS,
)
"""Columns of the table; errors and differences are fractions, not percent."""


def _cell(value: object) -> object:
    """Return a number to six digits, and an empty cell for None and nan."""
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return "" if value is None else value


class _Clocked:
    """A progress that also records the processor time at which rendering began, in seconds."""

    began = 0.0

    def __init__(self, inner: Progress) -> None:
        self._inner = inner
        self.update, self.close = inner.update, inner.close

    def stage(self, name: str) -> None:
        """Begin a stage of a render."""
        if name == "render":
            self.began = time.process_time()
        self._inner.stage(name)


class Study:
    """The points measured so far, and the reference that they are measured against.

    Parameters
    ----------
    base : settings from which sweeps start
    within : range of the bands, nm; None for the usual one
    progress, log : are notified of every render, and called with a line for each point
    """

    def __init__(
        self,
        scene: Scene,
        base: Settings,
        within: Limits | None,
        progress: Progress,
        log: Callable[[str], None],
    ) -> None:
        self._scene, self._within = scene, within
        self._progress = _Clocked(progress)
        self.base, self.log = base, log
        self.points: list[Point] = []
        self.reference: errors.Reference | None = None
        self.record: dict[str, Any] = {}
        self.spent = self.processor = 0.0

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._scene.name

    @property
    def faces(self) -> int:
        """Number of triangles in the scene."""
        return sum(len(mesh.faces) for mesh in self._scene.meshes)

    def render(self, settings: Settings) -> tuple[Result, float]:
        """Render, and count the seconds as spent; return the result and its processor seconds."""
        bands = Bands.parse(settings.bands, self._within)
        options = vars(settings) | {"bands": bands, "progress": self._progress}
        result = render(self._scene, **options)
        processor = time.process_time() - self._progress.began
        self.spent += result.record["seconds"]["render"]
        self.processor += processor
        self.record = self.record or result.record
        return result, processor

    def measure(
        self, sweep: str, label: str, settings: Settings, truth: Result | None = None
    ) -> Result:
        """Render a point, measure it and keep it, also one that Ctrl-C ended.

        `truth` is a render of `REFERENCE_BANDS` with equal seed and passes, for colour errors.
        """
        result, processor = self.render(settings)
        point = self._point(sweep, label, settings, result, processor, truth)
        self.points.append(point)
        error = f"error {point.stated['radiance']:.2%}"
        self.log(f"     {label}: {point.settings.passes} passes, {point.seconds:.2f} s, {error}")
        if result.record["interrupted"]:
            raise KeyboardInterrupt
        return result

    def time_again(self, last: int, times: int) -> None:
        """Repeat the last points in turns, and keep the shortest time of each."""
        for _ in range(times):
            for index in range(len(self.points) - last, len(self.points)):
                point = self.points[index]
                again, processor = self.render(point.settings)
                if again.record["interrupted"]:
                    raise KeyboardInterrupt
                wall = min(point.wall, again.record["seconds"]["render"])
                processor = min(point.processor, processor)
                self.points[index] = replace(point, wall=wall, processor=processor, seconds=wall)

    def _point(
        self,
        sweep: str,
        label: str,
        settings: Settings,
        result: Result,
        processor: float,
        truth: Result | None,
    ) -> Point:
        record, reference = result.record, self.reference
        assert reference is not None
        mask = errors.counted_pixels(result) if result.size != self.base.size else reference.mask
        point = Point(
            sweep=sweep,
            label=label,
            settings=replace(
                settings, passes=record["passes"], photons=record["arguments"]["photons"]
            ),
            wall=record["seconds"]["render"],
            processor=processor,
            seconds=record["seconds"]["render"],
            rays=record["rays"] or None,
            photons=record["photons"],
            stated={buffer: errors.stated_error(result, buffer, mask) for buffer in errors.BUFFERS},
            picture=errors.picture(result, reference.exposure),
            error_map=self._map(result, truth),
        )
        if truth is not None and not record["interrupted"]:
            point = replace(point, color=errors.color_error(result, truth, mask))
        if reference.fits(result):
            true = {buffer: reference.true_error(result, buffer) for buffer in errors.BUFFERS}
            difference = reference.mean_difference(result)
            error = errors.mean_error(result, mask) if settings.method == "path" else math.nan
            point = replace(point, true=true, mean_difference=difference, mean_error=error)
        return point

    def _map(self, result: Result, truth: Result | None) -> errors.ErrorMap | None:
        """Return the most telling error map: of colour, else of the true, else the stated error."""
        assert self.reference is not None
        if truth is not None:
            return errors.delta_map(result, truth)
        if self.reference.fits(result):
            return errors.true_map(result, self.reference)
        return errors.stated_map(result)


MAX_BACKGROUND_LOAD = 0.1
"""Fraction of all processors, taken by other programs, above which wall times are unreliable."""

_PROCESSORS = Path("/proc/cpuinfo")


def describe_machine() -> dict[str, Any]:
    """Return what timings depend on: system, processor, processors, load_before, versions."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "processors": os.cpu_count(),
        "load_before": psutil.getloadavg()[0],
        "versions": describe_versions(),
    }


def choose_clock(points: Sequence[Point], others: float, threads: int) -> list[Point]:
    """Return points timed by the wall clock, or by processor time on a loaded machine.

    `others` is the fraction of all processors that other programs took. On an idle machine, wall
    time is about processor time over the `threads` of the renders.
    """
    if others <= MAX_BACKGROUND_LOAD:
        return list(points)
    return [replace(point, seconds=point.processor / threads) for point in points]


class BackgroundLoad:
    """Measures the fraction of all processors that other programs take while it is entered."""

    share = 0.0

    def __enter__(self) -> Self:
        """Start to measure."""
        self._machine, self._own, self._wall = _busy(), _own(), time.perf_counter()
        return self

    def __exit__(self, *exception: object) -> None:
        """Set `share`; child processes count as own work once they have ended."""
        foreign = (_busy() - self._machine) - (_own() - self._own)
        span = (time.perf_counter() - self._wall) * (os.cpu_count() or 1)
        self.share = max(foreign / span, 0.0)


def _processor() -> str:
    """Return the name of the processor as the system reports it."""
    if _PROCESSORS.is_file():
        for line in _PROCESSORS.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _busy() -> float:
    """Return the processor seconds of all programs since the system started."""
    times = psutil.cpu_times()
    return times.user + times.system + getattr(times, "nice", 0.0)


def _own() -> float:
    """Return the processor seconds of this process and of its children that have ended."""
    return sum(os.times()[:4])
