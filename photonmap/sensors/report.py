"""Results as tables in text and CSV, and as one picture."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from photonmap.report import plots
from photonmap.report.tables import aligned, write_csv
from photonmap.runtime.writing import replacing
from photonmap.sensors.comparison import METHODS, BestRow, ColorRow
from photonmap.sensors.interreflection import ErrorRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = ("bands", "bounces", "mean_percent", "max_percent")
"""Columns of the CSV file."""

BEST_COLUMNS = (
    "bands", "1 bounce %", "2 bounces %", "ΔE", "best σ/bin", "ΔE", "best spread", "ΔE",
)  # fmt: skip


def error_table(rows: Sequence[ErrorRow]) -> str:
    """Return a table of errors in percent, with the pairs that count and the worst of them."""
    cells = []
    for row in rows:
        percents = f"{100.0 * row.mean:.3f}", f"{100.0 * row.worst:.3f}", f"{100.0 * row.kept:.1f}"
        cells.append([row.bands, str(row.bounces), *percents, " and ".join(row.worst_pair)])
    return _table(["bands", "bounces", "mean %", "max %", "counted %", "worst"], cells)


def color_table(rows: Sequence[ColorRow]) -> str:
    """Return a table of ΔE2000, a line for each set of bands and number of bounces."""
    by_key = {(row.bands, row.bounces, row.method): row for row in rows}
    cells = []
    for bands, bounces in dict.fromkeys((row.bands, row.bounces) for row in rows):
        found = [by_key[bands, bounces, method] for method in METHODS]
        values = [f"{x:.3f}" for row in found for x in (row.mean, row.p95, row.worst)]
        cells.append([bands, str(bounces), *values])
    heads = [f"{method} {what}" for method in METHODS for what in ("mean", "p95", "max")]
    return _table(["bands", "bounces", *heads], cells)


def best_line(row: BestRow | None = None) -> str:
    """Return one line of the table of best bands; its head without a row."""
    if row is None:
        cells: Sequence[str] = BEST_COLUMNS
    else:
        spread = (f"{row.spread:.3f}", f"{row.spread_delta:.3f}") if row.count > 1 else ("-", "-")
        values = (100.0 * row.one, 100.0 * row.two, row.usual, row.width, row.width_delta)
        cells = (str(row.count), *(f"{value:.3f}" for value in values), *spread)
    widths = [max(len(head), 6) for head in BEST_COLUMNS]
    pairs = list(zip(cells, widths, strict=True))
    return "  ".join([pairs[0][0].ljust(pairs[0][1]), *(cell.rjust(w) for cell, w in pairs[1:])])


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Align columns of text to the right; "bands" and "worst" to the left."""
    right = [place for place, name in enumerate(head) if name not in ("bands", "worst")]
    return "\n".join(aligned([head, *rows], right))


def write_errors(path: str | PathLike[str], rows: Sequence[ErrorRow]) -> None:
    """Write errors in percent, one row for each set of bands and number of bounces."""
    cells = [
        [row.bands, row.bounces, f"{100.0 * row.mean:#.6g}", f"{100.0 * row.worst:#.6g}"]
        for row in rows
    ]
    with replacing(path) as part:
        write_csv(part, COLUMNS, cells)


_METHOD_COLORS = {"direct": "#777777", "regression": plots.BLUE}
_FEW = 5  # most sets of bands with both lines labelled
_FLOOR = 1e-3  # percent and ΔE; smaller values are drawn here on the logarithmic axes


def write_plot(
    path: str | PathLike[str], rows: Sequence[ErrorRow], color_rows: Sequence[ColorRow]
) -> None:
    """Draw errors against bounces, and ΔE2000 for each set of bands, side by side."""
    plots.check_plot(path)
    wide = max(1.0, len({row.bands for row in color_rows}) / 4.0)
    figure, (left, right) = plots.new_figure(4.5 + 4.5 * wide, 4.0, (1.0, wide))
    _draw_errors(left, rows)
    _draw_colors(right, color_rows)
    with replacing(path) as part:
        plots.save_figure(figure, part)


def _draw_errors(axes: Axes, rows: Sequence[ErrorRow]) -> None:
    """Draw mean and worst error against the number of bounces, a colour for each set of bands."""
    ends: list[tuple[float, str, str]] = []
    labels = dict.fromkeys(row.bands for row in rows)
    for place, label in enumerate(labels):
        own = [row for row in rows if row.bands == label]
        bounces = [row.bounces for row in own]
        color = plots.COLORS[place % len(plots.COLORS)]
        worst = [_at_least(100.0 * row.worst) for row in own]
        mean = [_at_least(100.0 * row.mean) for row in own]
        axes.plot(bounces, worst, "o--", color=color, mfc="white", lw=1.2, ms=5)
        axes.plot(bounces, mean, "o-", color=color, lw=1.8, ms=5)
        ends.append((mean[-1], _called(label), color))
        if len(labels) <= _FEW:
            ends.append((worst[-1], "max", color))
    title = "error within the bands: mean and (dashed) max"
    plots.style(axes, title, "bounces between two surfaces", "%", "y")
    last = max(row.bounces for row in rows)
    axes.set_xlim(0.8, last + 0.2)
    axes.set_xticks(range(1, last + 1))
    plots.write_beside(axes, last, ends)


def _draw_colors(axes: Axes, rows: Sequence[ColorRow]) -> None:
    """Draw mean, 95th percentile and worst ΔE2000, a group for each set of bands."""
    labels = list(dict.fromkeys(row.bands for row in rows))
    sides = {"direct": -0.21, "regression": 0.21}
    places = [
        labels.index(row.bands) + sides[row.method] + (row.bounces - 1.5) * 0.2 for row in rows
    ]
    for at, row in zip(places, rows, strict=True):
        color = _METHOD_COLORS[row.method]
        mean, p95, worst = map(_at_least, (row.mean, row.p95, row.worst))
        axes.plot([at, at], [mean, worst], color=color, lw=1.0)
        axes.plot(at, p95, "_", color=color, ms=9, mew=1.8)
        axes.plot(at, worst, "o", color=color, mfc="white", ms=5)
        axes.plot(at, mean, "o", color=color, ms=6)
    plots.style(axes, "colour difference after projection to sRGB", "bounces", "ΔE2000", "y")
    axes.set_title(axes.get_title("left"), loc="left", fontsize=10.5, color=plots.INK, pad=18)
    axes.axhline(1.0, color=plots.INK, lw=0.8, ls=":", zorder=0)
    plots.write(axes, "just visible", -0.58, 1.0, xytext=(0, 3), va="bottom")
    axes.set_xlim(-0.6, len(labels) - 0.4)
    axes.set_xticks(places, [str(row.bounces) for row in rows])
    above: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "xytext": (0, 4)}
    for place, label in enumerate(labels):
        plots.write(axes, _called(label), place, 1.0, ha="center", va="bottom", **above)
    last = max(zip(places, rows, strict=True), key=lambda pair: pair[0])
    ends = zip((last[1].mean, last[1].p95, last[1].worst), ("mean", "95%", "max"), strict=True)
    color = _METHOD_COLORS[last[1].method]
    plots.write_beside(axes, last[0], [(_at_least(value), text, color) for value, text in ends])
    for (method, color), side in zip(_METHOD_COLORS.items(), ("right", "left"), strict=True):
        own = [row.mean for row in rows if (row.bands, row.method) == (labels[0], method)]
        lowest = _at_least(min(own))
        shift = (-3 if side == "right" else 3, -14)
        plots.write(axes, method, 0.0, lowest, color, xytext=shift, ha=side, va="bottom")


def _at_least(value: float) -> float:
    return max(value, _FLOOR)


def _called(label: str) -> str:
    """Return a label, with a noun if it is only a number."""
    return f"{label} band{'s' * (label != '1')}" if label.isdecimal() else label
