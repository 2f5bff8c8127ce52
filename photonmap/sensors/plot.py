"""The tables of the study as one picture."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.errors import InputError
from photonmap.sensors.color_error import ColorRow
from photonmap.sensors.interreflection import ErrorRow
from photonmap.sensors.report import check_file, replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUFFIXES = (".png", ".svg", ".pdf")

_COLORS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555")
"""Palette of M. Okabe and K. Ito, safe for colour-blind readers."""

_METHOD_COLORS = {"direct": "#777777", "regression": "#0072B2"}
_INK, _FAINT = "#222222", "#DDDDDD"
_LINE = 0.05
"""Height of a line of text, relative to the axis."""
_FEW = 5
"""Most sets of bands with both lines labelled."""
_FLOOR = 1e-3
"""Percent and ΔE; smaller values are drawn here on the logarithmic axes."""


def check_plot(path: str | PathLike[str]) -> None:
    """Check before the computation that matplotlib is there and that the picture can be written.

    Raises
    ------
    InputError
        if not, or if the suffix is none of `SUFFIXES`
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"plots are {', '.join(SUFFIXES)}; end the name in one of them", path)
    check_file(path)
    if find_spec("matplotlib") is None:
        raise InputError("plots need matplotlib: pip install 'photonmap[plot]'")


def write_plot(
    path: str | PathLike[str], rows: Sequence[ErrorRow], color_rows: Sequence[ColorRow]
) -> None:
    """Draw errors against bounces, and ΔE2000 for each set of bands, side by side.

    Parameters
    ----------
    path : a .png, .svg or .pdf
    rows, color_rows : what to draw, one row at least of each

    Raises
    ------
    InputError
        as `check_plot`
    OSError
        if writing fails
    """
    check_plot(path)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    wide = max(1.0, len({row.bands for row in color_rows}) / 4.0)
    figure = Figure(figsize=(4.5 + 4.5 * wide, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, wide])
    _draw_errors(left, rows)
    _draw_colors(right, color_rows)
    with replacing(path) as part:
        figure.savefig(part, dpi=200)


def _draw_errors(axes: Axes, rows: Sequence[ErrorRow]) -> None:
    """Draw mean and worst error against the number of bounces, a colour for each set of bands."""
    ends: list[tuple[float, str, str]] = []
    labels = dict.fromkeys(row.bands for row in rows)
    for place, label in enumerate(labels):
        own = [row for row in rows if row.bands == label]
        bounces = [row.bounces for row in own]
        color = _COLORS[place % len(_COLORS)]
        worst = [_at_least(100.0 * row.worst) for row in own]
        mean = [_at_least(100.0 * row.mean) for row in own]
        axes.plot(bounces, worst, "o--", color=color, mfc="white", lw=1.2, ms=5)
        axes.plot(bounces, mean, "o-", color=color, lw=1.8, ms=5)
        ends.append((mean[-1], _called(label), color))
        if len(labels) <= _FEW:
            ends.append((worst[-1], "max", color))
    _style(axes, "Error within the bands, %: mean and (dashed) max")
    last = max(row.bounces for row in rows)
    axes.set_xlim(0.8, last + 0.2)
    axes.set_xticks(range(1, last + 1))
    axes.set_xlabel("bounces between two surfaces", color=_INK)
    _write_beside(axes, last, ends)


def _draw_colors(axes: Axes, rows: Sequence[ColorRow]) -> None:
    """Draw mean, 95th percentile and worst ΔE2000, a group for each set of bands."""
    labels = list(dict.fromkeys(row.bands for row in rows))
    places = [labels.index(row.bands) + _offset(row) for row in rows]
    for at, row in zip(places, rows, strict=True):
        color = _METHOD_COLORS[row.method]
        mean, p95, worst = map(_at_least, (row.mean, row.p95, row.worst))
        axes.plot([at, at], [mean, worst], color=color, lw=1.0)
        axes.plot(at, p95, "_", color=color, ms=9, mew=1.8)
        axes.plot(at, worst, "o", color=color, mfc="white", ms=5)
        axes.plot(at, mean, "o", color=color, ms=6)
    _style(axes, "Colour difference after projection to sRGB, ΔE2000")
    axes.axhline(1.0, color=_INK, lw=0.8, ls=":", zorder=0)
    axes.annotate(
        "just visible", (-0.58, 1.0), (0, 3), textcoords="offset points", color=_INK, fontsize=8
    )
    axes.set_xlim(-0.6, len(labels) - 0.4)
    axes.set_xticks(places, [str(row.bounces) for row in rows])
    axes.set_xlabel("bounces", color=_INK)
    for place, label in enumerate(labels):
        _write(axes, _called(label), (place, 1.0), (0, 4), _INK, "center", at_top=True)
    last = max(zip(places, rows, strict=True), key=lambda pair: pair[0])
    ends = zip((last[1].mean, last[1].p95, last[1].worst), ("mean", "95%", "max"), strict=True)
    color = _METHOD_COLORS[last[1].method]
    _write_beside(axes, last[0], [(_at_least(value), text, color) for value, text in ends])
    for (method, color), side in zip(_METHOD_COLORS.items(), ("right", "left"), strict=True):
        lowest = min(
            _at_least(row.mean) for row in rows if (row.bands, row.method) == (labels[0], method)
        )
        _write(axes, method, (0.0, lowest), (-3 if side == "right" else 3, -14), color, side)


def _offset(row: ColorRow) -> float:
    """Return the offset of a row within its group."""
    return {"direct": -0.21, "regression": 0.21}[row.method] + (row.bounces - 1.5) * 0.2


def _write(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    shift: tuple[float, float],
    color: str,
    side: str,
    at_top: bool = False,
) -> None:
    """Write beside a point, moved by 1/72 in; at the top its y is a part of the height."""
    axes.annotate(
        text,
        at,
        shift,
        xycoords=axes.get_xaxis_transform() if at_top else "data",
        textcoords="offset points",
        ha=side,
        color=color,
        fontsize=9,
    )


def _write_beside(axes: Axes, x: float, ends: Sequence[tuple[float, str, str]]) -> None:
    """Write texts right of points (y, text, colour), moved apart where they would overlap."""
    ends = sorted(ends)
    low, high = np.log10(axes.get_ylim())
    heights = _apart([float(np.log10(end[0])) for end in ends], _LINE * float(high - low))
    for (_, text, color), height in zip(ends, heights, strict=True):
        axes.annotate(
            text,
            (x, 10.0**height),
            (9, 0),
            textcoords="offset points",
            annotation_clip=False,
            va="center",
            color=color,
            fontsize=9,
        )


def _apart(heights: Sequence[float], gap: float) -> list[float]:
    """Move increasing heights until none is nearer than `gap` to the next, each crowd evenly."""
    crowds: list[list[float]] = []
    for height in heights:
        crowd = [height]
        while crowds and _spaced(crowds[-1], gap)[-1] + gap > _spaced(crowd, gap)[0]:
            crowd = crowds.pop() + crowd
        crowds.append(crowd)
    return [height for crowd in crowds for height in _spaced(crowd, gap)]


def _spaced(crowd: Sequence[float], gap: float) -> list[float]:
    """Return as many heights, `gap` apart, with the same mean."""
    first = sum(crowd) / len(crowd) - gap * (len(crowd) - 1) / 2.0
    return [first + gap * place for place in range(len(crowd))]


def _style(axes: Axes, title: str) -> None:
    """Set a logarithmic axis with plain numbers, few lines and a title over it."""
    from matplotlib.ticker import LogLocator, NullLocator

    axes.set_yscale("log")
    axes.margins(y=0.1)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(_plain)
    axes.set_title(title, loc="left", fontsize=10.5, color=_INK, pad=18)
    axes.grid(axis="y", color=_FAINT, lw=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=_INK, length=3)


def _plain(value: float, position: Any = None) -> str:
    return f"{value:g}"


def _at_least(value: float) -> float:
    return max(value, _FLOOR)


def _called(label: str) -> str:
    """Return a label, with a noun if it is only a number."""
    return f"{label} band{'s' * (label != '1')}" if label.isdecimal() else label
