"""Plots of one look: figures, axes, colours, labels, and what they are written as."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.errors import InputError
from photonmap.runtime.writing import check_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555")
"""The palette of M. Okabe and K. Ito, which colour-blind readers can distinguish as well."""
ORANGE, BLUE, GREEN, PURPLE, YELLOW, SKY, GREY = COLORS
INK, FAINT = "#222222", "#DDDDDD"
SUFFIXES = (".png", ".svg", ".pdf")
"""Of files that figures are written to."""
POINT = "point-"
"""Prefix of the id of a point's group in a figure."""

_HIT = 15.0  # diameter of the invisible disk that is clicked, points
_DPI = 150
_THOUSANDS = 10000.0  # value from which ticks are labelled in thousands
_TEXT = 8  # size of labels, points
_LINE = 0.05  # height of a line of text, relative to the axis


def check_plot(path: str | PathLike[str]) -> None:
    """Check before the computation that matplotlib is there and that the picture can be written."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"plots are {', '.join(SUFFIXES)}; end the name in one of them", path)
    check_file(path)
    if find_spec("matplotlib") is None:
        raise InputError("plots need matplotlib: pip install 'photonmap[plot]'")


def new_figure(
    width: float, height: float, ratios: Sequence[float] = (1.0,)
) -> tuple[Figure, list[Axes]]:
    """Return a figure of a width and height, inches, with axes of relative widths side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(ratios), squeeze=False, width_ratios=ratios)
    return figure, list(axes[0])


def style(axes: Axes, title: str, x: str, y: str, logarithmic: str = "xy") -> None:
    """Set title and labels; logarithmic axes get plain numbers as ticks."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_title(title, loc="left", fontsize=10.5, color=INK)
    axes.set_xlabel(x, color=INK, fontsize=9)
    axes.set_ylabel(y, color=INK, fontsize=9)
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        if name in logarithmic:
            (axes.set_xscale if name == "x" else axes.set_yscale)("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(_plain))
    axes.margins(0.08, 0.1)
    axes.grid(color=FAINT, lw=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=INK, length=3, labelsize=_TEXT)


def _plain(value: float, position: Any = None) -> str:
    return f"{value / 1000:g}k" if value >= _THOUSANDS else f"{value:g}"


def mark(axes: Axes, x: float, y: float, index: int, **look: Any) -> None:
    """Draw a measured point; `index` is its index among all points."""
    group = f"{POINT}{index}-{len(axes.lines)}"
    axes.plot(x, y, "o", **{"ms": 5.5, "mew": 1.3, "zorder": 3, **look}, gid=f"seen-{group}")
    axes.plot(x, y, "o", ms=_HIT, alpha=0.0, color="white", mew=0.0, zorder=9, gid=group)


def write(axes: Axes, text: str, x: float, y: float, color: str = INK, **place: Any) -> None:
    """Write text beside a point, 6 pt to the right unless `place` says otherwise."""
    given = {"xytext": (6, 0), "textcoords": "offset points", "va": "center", **place}
    axes.annotate(text, (x, y), color=color, fontsize=_TEXT, annotation_clip=False, **given)


def write_beside(axes: Axes, x: float, ends: Sequence[tuple[float, str, str]]) -> None:
    """Write texts right of points (y, text, colour) on a logarithmic axis, none over another."""
    ends = sorted(ends)
    low, high = np.log10(axes.get_ylim())
    heights = apart([float(np.log10(end[0])) for end in ends], _LINE * float(high - low))
    for (_, text, color), height in zip(ends, heights, strict=True):
        write(axes, text, x, 10.0**height, color, xytext=(9, 0))


def apart(heights: Sequence[float], gap: float) -> list[float]:
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


def legend(axes: Axes) -> None:
    """Add a legend that lists each label once."""
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    if once:
        axes.legend(once.values(), once.keys(), fontsize=_TEXT, frameon=False)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure to a file whose suffix is one of `SUFFIXES`."""
    figure.savefig(path, dpi=_DPI)


def as_svg(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element whose ids are unique to its name."""
    from matplotlib import rc_context

    file = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    return re.sub(r'id="(?!m[0-9a-f]{10}|p[0-9a-f]{10}|h[0-9a-f]{10})', f'id="{name}-', text)
