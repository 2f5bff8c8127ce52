"""Renders what a sweep asks for, measures it, and keeps the points."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import photonmap as pm
from photonmap.bands import Bands
from photonmap.progress import Progress
from photonmap.result import Result
from photonmap.scene import Scene
from photonmap.spectra.sensitivities import Limits
from photonmap.study.color import color_error
from photonmap.study.metrics import BUFFERS, counted_pixels, mean_error, stated_error
from photonmap.study.pictures import ErrorMap, delta_map, picture, stated_map, true_map
from photonmap.study.point import Point, Settings
from photonmap.study.reference import Reference


class _Clocked:
    """A progress that also notes the processor time at which rendering began, in seconds."""

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
    """The points measured so far, and what they are measured against.

    Parameters
    ----------
    scene : to render
    base : settings from which sweeps start
    within : range of the bands, nm; None for the usual one
    threads : None takes every processor
    progress : is told of every render
    tell : is called with a line for each point
    """

    def __init__(
        self,
        scene: Scene,
        base: Settings,
        within: Limits | None,
        threads: int | None,
        progress: Progress,
        tell: Callable[[str], None],
    ) -> None:
        self._scene, self._within, self._threads = scene, within, threads
        self._progress = _Clocked(progress)
        self.base, self.tell = base, tell
        self.points: list[Point] = []
        self.reference: Reference | None = None
        self.record: dict[str, Any] = {}
        self.spent = self.processor = 0.0

    @property
    def name(self) -> str:
        """What the scene is called."""
        return self._scene.name

    @property
    def faces(self) -> int:
        """Triangles of the scene."""
        return sum(len(mesh.faces) for mesh in self._scene.meshes)

    def of(self, sweep: str) -> list[Point]:
        """Return the points of a sweep."""
        return [point for point in self.points if point.sweep == sweep]

    def render(self, settings: Settings) -> tuple[Result, float]:
        """Render, count the seconds as spent; return what came out, and its processor seconds."""
        result = pm.render(
            self._scene,
            bands=Bands.parse(settings.bands, self._within),
            size=settings.size,
            pixel=settings.pixel,  # type: ignore[arg-type]
            passes=settings.passes,
            photons=settings.photons,
            seed=settings.seed,
            threads=self._threads,
            method=settings.method,  # type: ignore[arg-type]
            effects=settings.effects,
            progress=self._progress,
        )
        processor = time.process_time() - self._progress.began
        self.spent += result.record["seconds"]["render"]
        self.processor += processor
        self.record = self.record or result.record
        return result, processor

    def measure(
        self, sweep: str, label: str, settings: Settings, truth: Result | None = None
    ) -> Result:
        """Render and keep a point.

        Parameters
        ----------
        sweep, label : what the point is called
        settings : of the render
        truth : a render of many bands, of the same seed and passes

        Raises
        ------
        KeyboardInterrupt
            if Ctrl-C ended the render; what it did is a point nevertheless
        """
        result, processor = self.render(settings)
        point = self._point(sweep, label, settings, result, processor, truth)
        self.points.append(point)
        error = f"error {point.stated['radiance']:.2%}"
        self.tell(f"     {label}: {point.settings.passes} passes, {point.seconds:.2f} s, {error}")
        if result.record["interrupted"]:
            raise KeyboardInterrupt
        return result

    def time_again(self, last: int, times: int) -> None:
        """Repeat the last points, in turns, and keep the least seconds of each.

        Raises
        ------
        KeyboardInterrupt
            at Ctrl-C; the points stay as they were
        """
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
        photons = record["arguments"]["photons"]
        done = replace(settings, passes=record["passes"], photons=photons)
        mask = counted_pixels(result) if result.size != self.base.size else reference.mask
        point = Point(
            sweep=sweep,
            label=label,
            settings=done,
            wall=record["seconds"]["render"],
            processor=processor,
            seconds=record["seconds"]["render"],
            rays=record["rays"] or None,
            photons=record["photons"],
            stated={buffer: stated_error(result, buffer, mask) for buffer in BUFFERS},
            picture=picture(result, reference.exposure),
            error_map=self._map(result, truth),
        )
        if truth is not None and not record["interrupted"]:
            point = replace(point, color=color_error(result, truth, mask))
        if reference.fits(result):
            true = {buffer: reference.true_error(result, buffer) for buffer in BUFFERS}
            difference = reference.mean_difference(result)
            error = mean_error(result, mask) if settings.method == "path" else math.nan
            point = replace(point, true=true, mean_difference=difference, mean_error=error)
        return point

    def _map(self, result: Result, truth: Result | None) -> ErrorMap | None:
        """Map what says most: what bands cost, or the true error, or else the stated one."""
        assert self.reference is not None
        if truth is not None:
            return delta_map(result, truth)
        if self.reference.fits(result):
            return true_map(result, self.reference)
        return stated_map(result)
