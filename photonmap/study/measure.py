"""Render the points of sweeps, measure them, and keep them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from photonmap.render import render
from photonmap.results.result import Result
from photonmap.runtime.progress import Progress
from photonmap.scene.scene import Scene
from photonmap.spectra.bands import Bands
from photonmap.spectra.sensitivities import Limits
from photonmap.study.color_error import color_error
from photonmap.study.error_maps import ErrorMap, delta_map, picture, stated_map, true_map
from photonmap.study.metrics import BUFFERS, counted_pixels, mean_error, stated_error
from photonmap.study.point import Point, Settings
from photonmap.study.reference import Reference


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
    scene : to render
    base : settings from which sweeps start
    within : range of the bands, nm; None for the usual one
    progress : is notified of every render
    log : is called with a line for each point
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
        self.reference: Reference | None = None
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

    def of(self, sweep: str) -> list[Point]:
        """Return the points of a sweep."""
        return [point for point in self.points if point.sweep == sweep]

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
        """Render a point, measure it and keep it.

        Parameters
        ----------
        sweep, label : names of the sweep and of the point in it
        settings : of the render
        truth : a render of `REFERENCE_BANDS` with equal seed and passes, for colour errors

        Raises
        ------
        KeyboardInterrupt
            if Ctrl-C ended the render; the passes before it are a point nevertheless
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
        """Repeat the last points in turns, and keep the shortest time of each.

        Parameters
        ----------
        last : number of points
        times : number of repetitions

        Raises
        ------
        KeyboardInterrupt
            at Ctrl-C; the points that were not repeated stay as they are
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
        """Return the most telling error map: of colour, else of the true, else the stated error."""
        assert self.reference is not None
        if truth is not None:
            return delta_map(result, truth)
        if self.reference.fits(result):
            return true_map(result, self.reference)
        return stated_map(result)
