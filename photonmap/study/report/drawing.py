"""Drawing of figures: axes, colours, and points that the page can address."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#D55E00", "#E69F00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#555555")
"""The palette of M. Okabe and K. Ito, distinct with colour-blindness too."""

PHOTON, TRACED = "#0072B2", "#D55E00"
INK, FAINT = "#222222", "#DDDDDD"
POINT = "point-"
"""Prefix of the id of a point's group in a figure."""

_HIT = 15.0  # diameter of the invisible disk that is clicked, points
_DPI = 150
_THOUSANDS = 10000.0  # value from which ticks are labelled in thousands


def new_figure(width: float, height: float, columns: int = 1) -> tuple[Figure, Sequence[Axes]]:
    """Return a figure of a width and height, inches, with axes side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(1, columns, squeeze=False)[0])


def mark(axes: Axes, x: float, y: float, index: int, **look: Any) -> None:
    """Draw a measured point; `index` is its index among all points."""
    group = f"{POINT}{index}-{len(axes.lines)}"
    axes.plot(x, y, "o", **{"ms": 5.5, "mew": 1.3, "zorder": 3, **look}, gid=f"seen-{group}")
    axes.plot(x, y, "o", ms=_HIT, alpha=0.0, color="white", mew=0.0, zorder=9, gid=group)


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
    axes.tick_params(colors=INK, length=3, labelsize=8)


def write(axes: Axes, text: str, x: float, y: float, color: str = INK, **place: Any) -> None:
    """Write text beside a point, 6 pt to the right unless `place` says otherwise."""
    given = {"xytext": (6, 0), "textcoords": "offset points", "va": "center", **place}
    axes.annotate(text, (x, y), color=color, fontsize=8, annotation_clip=False, **given)


def as_png(figure: Figure) -> bytes:
    """Return a figure as a PNG."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=_DPI)
    return file.getvalue()


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


def _plain(value: float, position: Any = None) -> str:
    return f"{value / 1000:g}k" if value >= _THOUSANDS else f"{value:g}"
