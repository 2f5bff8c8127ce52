"""The figures: error against time, errors of bands, the Pareto front, other choices."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from photonmap.report import plots
from photonmap.study.convergence import Findings, Indexed, Law, fit_power
from photonmap.study.errors import REFERENCE_BANDS
from photonmap.study.sweeps import bands_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EXTRAPOLATION = 16.0  # factor of the longest time up to which laws are drawn
_DELTAS = (
    ("delta_mean", "radiance, mean", plots.BLUE),
    ("delta_p95", "radiance, 95%", plots.SKY),
    ("indirect_mean", "indirect light, mean", plots.ORANGE),
    ("indirect_p95", "indirect light, 95%", plots.YELLOW),
)
_SWEEPS = (("passes", "photon mapping", plots.BLUE), ("path", "path tracing", plots.ORANGE))


def error_against_time(found: Findings) -> Figure:
    """Draw true and stated errors of radiance and shading, slopes, and the reference's error."""
    figure, panels = plots.new_figure(9.4, 3.9, (1.0, 1.0))
    for axes, buffer in zip(panels, ("radiance", "shading"), strict=True):
        for sweep, name, color in _SWEEPS:
            _draw_sweep(axes, found, sweep, name, color, buffer)
        floor = 100.0 * found.own_errors[buffer]
        axes.axhline(floor, color="#888888", lw=1.0, ls=":")
        axes.annotate(
            f"the reference's own error, {floor:.2g}%", (0.02, floor),
            xycoords=axes.get_yaxis_transform(), xytext=(0, 3), textcoords="offset points",
            fontsize=7.5, color="#666666",
        )  # fmt: skip
        plots.style(axes, f"error of {buffer}", "seconds", "%")
    return figure


def _draw_sweep(
    axes: Axes, found: Findings, sweep: str, name: str, color: str, buffer: str
) -> None:
    """Draw a method: true errors filled, stated errors hollow, and its power law."""
    for index, point in found.of(sweep):
        true = 100.0 * point.true[buffer]
        if true > 0.0:
            plots.mark(axes, point.seconds, true, index, color=color)
        plots.mark(
            axes, point.seconds, 100.0 * point.stated[buffer], index, color=color, mfc="none"
        )
    law = found.slope(sweep, buffer)
    if law is None:
        return
    seconds = [point.seconds for _, point in found.of(sweep) if found.is_significant(point, buffer)]
    ends = min(seconds), max(seconds)
    axes.plot(ends, [100.0 * law.at(end) for end in ends], color=color, lw=1.2, alpha=0.6)
    middle = math.sqrt(ends[0] * ends[1])
    text = f"{name}\nslope {law.exponent:.2f}".replace("-", "−")
    plots.write(axes, text, middle, 100.0 * law.at(middle), color, xytext=(10, 12))


def colors_by_bands(found: Findings) -> Figure:
    """Draw colour errors by bands, and against seconds."""
    figure, (left, right) = plots.new_figure(9.4, 3.7, (1.0, 1.0))
    points = [(index, point) for index, point in found.most_passes("bands") if point.color]
    _draw_deltas(left, points)
    for index, point in points:
        for name, label, color, place in (
            ("shading", "shading", plots.BLUE, {"xytext": (-7, 0), "ha": "right"}),
            ("indirect", "indirect light", plots.ORANGE, {}),
        ):
            off = 100.0 * getattr(point.color, name)
            plots.mark(right, point.seconds, off, index, color=color, label=label)
            plots.write(right, point.settings.bands, point.seconds, off, color, **place)
    plots.style(right, "colour error against time", "seconds", "relative distance in XYZ, %", "y")
    right.set_xlim(left=0.0)
    for axes in (left, right):
        plots.legend(axes)
    return figure


def _draw_deltas(axes: Axes, points: Indexed) -> None:
    """Draw ΔE2000 for each number of bands."""
    places = range(len(points))
    for name, label, color in _DELTAS:
        values = [getattr(point.color, name) for _, point in points]
        axes.plot(places, values, color=color, lw=1.3, label=label)
        for place, value, (index, _) in zip(places, values, points, strict=True):
            plots.mark(axes, place, value, index, color=color)
    plots.style(axes, f"colour error against {REFERENCE_BANDS} bands", "bands", "ΔE2000", "y")
    axes.set_xticks(places, [point.settings.bands for _, point in points])


def pareto(found: Findings) -> Figure:
    """Draw combined noise and colour error against seconds, the laws, and the Pareto front."""
    figure, (axes,) = plots.new_figure(9.4, 4.4)
    labels = [law.label for law in found.laws_of_bands]
    colors = {label: plots.COLORS[place % len(plots.COLORS)] for place, label in enumerate(labels)}
    for law in found.laws_of_bands:
        _draw_law(axes, found, law, colors[law.label])
    front = {index for index, _ in found.front}
    for index, point in found.candidates:
        label = bands_label(point.settings.bands)
        total = 100.0 * found.total_error(point)
        filled = {} if index in front else {"mfc": "white"}
        plots.mark(axes, point.seconds, total, index, color=colors.get(label, plots.INK), **filled)
    steps = [(point.seconds, 100 * found.total_error(point)) for _, point in found.front]
    if steps:
        axes.step(
            *zip(*steps, strict=True), where="post", color=plots.INK, lw=0.8, ls="--", zorder=1
        )
    plots.style(axes, "combined error of shading, noise and colour, by bands", "seconds", "%")
    return figure


def _draw_law(axes: Axes, found: Findings, law: Law, color: str) -> None:
    """Draw the error of a law against seconds, dotted where it is extrapolated."""
    end = law.cost.seconds(max(point.settings.passes for _, point in found.of("passes")))
    times = np.geomspace(law.cost.seconds(2), max(_EXTRAPOLATION * end, law.cost.seconds(4)), 80)
    totals = np.array([100.0 * law.total_after(float(time)) for time in times])
    for part, line in ((times <= end, "-"), (times >= end, ":")):
        axes.plot(times[part], totals[part], line, color=color, lw=1.1, alpha=0.8)
    plots.write(axes, law.label.removesuffix(" bands"), times[-1], totals[-1], color)


def other_choices(found: Findings) -> Figure:
    """Draw the sweeps of photons and resolution."""
    figure, (left, right) = plots.new_figure(9.4, 3.5, (1.0, 1.0))
    _draw_photons(left, found)
    _draw_resolution(right, found)
    return figure


def _draw_photons(axes: Axes, found: Findings) -> None:
    """Draw errors against photons per pass, with times relative to the default number."""
    points = found.of("photons")
    usual = found.points[0].settings.photons or 0
    times = {point.settings.photons or 0: point.processor for _, point in points}
    for index, point in points:
        photons = point.settings.photons or 0
        for buffer, color in (("shading", plots.BLUE), ("indirect", plots.ORANGE)):
            error = 100.0 * point.true[buffer]
            plots.mark(axes, photons, error, index, color=color, label=buffer)
        if usual in times:
            share = f"{times[photons] / times[usual]:.2g}×"
            plots.write(axes, share, photons, error, xytext=(0, 9), ha="center")
    title = f"photons per pass, {points[0][1].settings.passes} passes"
    plots.style(axes, title, "photons", "true error, %")
    plots.legend(axes)


def _draw_resolution(axes: Axes, found: Findings) -> None:
    """Draw seconds against pixels, and the power law through the last two sizes."""
    pixels, seconds, passes = [], [], 0
    for index, point in found.of("resolution"):
        (width, height), passes = point.settings.size, point.settings.passes
        pixels.append(width * height)
        seconds.append(point.seconds)
        plots.mark(axes, pixels[-1], seconds[-1], index, color=plots.BLUE)
        plots.write(
            axes, f"{width}×{height}", pixels[-1], seconds[-1], xytext=(0, -12), ha="center"
        )
    if law := fit_power(pixels[-2:], seconds[-2:]):
        ends = pixels[-2:]
        axes.plot(ends, [law.at(end) for end in ends], color=plots.BLUE, lw=1.2, alpha=0.6)
        middle = math.sqrt(ends[0] * ends[1])
        text = f"exponent {law.exponent:.2f}"
        plots.write(axes, text, middle, law.at(middle), plots.BLUE, xytext=(-8, 4), ha="right")
    plots.style(axes, f"resolution, {passes} passes", "pixels", "seconds")


_FIGURES: dict[str, tuple[Callable[[Findings], Figure], tuple[str, ...]]] = {
    "error_time": (error_against_time, ("passes",)),
    "bands": (colors_by_bands, ("bands",)),
    "pareto": (pareto, ("passes", "bands")),
    "choices": (other_choices, ("photons",)),
}


def drawn_figures(found: Findings) -> dict[str, Figure]:
    """Return the figures for which there are points, by the names of their files."""
    return {
        name: draw(found)
        for name, (draw, sweeps) in _FIGURES.items()
        if all(found.of(sweep) for sweep in sweeps)
    }
