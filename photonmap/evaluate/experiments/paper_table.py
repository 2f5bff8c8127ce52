"""Table 1 of the paper whose data set `icip2013` follows, with our scores beside the paper's.

S. Beigpour, M. Serra, J. van de Weijer, R. Benavente, M. Vanrell, O. Penacchio and D. Samaras,
"Intrinsic image evaluation on synthetic complex scenes", ICIP 2013: LMSE of reflectance and
shading for single objects and complex scenes in white light, light of one colour and two lights.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from photonmap.evaluate.bench.images import (
    COLORS_OF_LIGHT,
    COMPLEX,
    CONTENTS,
    OBJECT,
    ONE_LIGHT,
    TWO_LIGHTS,
    WHITE_LIGHT,
    Kind,
)
from photonmap.evaluate.bench.measure import BOTH, REFLECTANCE, SHADING, Column
from photonmap.evaluate.bench.scores import Evaluation, MethodScores
from photonmap.evaluate.intervals import group_by_scene, scene_interval
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.evaluate.report.tables import Cell, Table, interval

METRIC = "lmse-color"  # The paper's: LMSE with one factor a window for all bands
_GREY = "lmse"
_TITLES = {
    METRIC: (
        "table-1",
        "By kind of scene and light",
        "LMSE with one factor a window for all bands, as in Table 1 of Beigpour et al. 2013, whose "
        "figures stand below ours. Their images are others, so compare rankings and trends. Our "
        "serra is a reading of Serra et al. 2012, of which only the abstract was at hand.",
    ),
    _GREY: (
        "table-1-grey",
        "By kind of scene and light, grey values",
        "The same by LMSE of grey values, which does not count the colour of shading, as most "
        "methods estimate grey shading.",
    ),
}
"""Name, title and meaning of the table by each metric."""
_COLUMNS = tuple((layer, Kind(content, light)) for layer in BOTH for content in CONTENTS
                for light in COLORS_OF_LIGHT)  # fmt: skip
_PAPER = {
    "Barron and Malik 2012, in the paper": (
        0.082, 0.099, 0.102, 0.020, 0.059, 0.039, 0.043, 0.046, 0.054, 0.011, 0.014, 0.014,
    ),
    "Gehler et al. 2011, in the paper": (
        0.089, 0.113, 0.123, 0.018, 0.067, 0.040, 0.043, 0.045, 0.051, 0.007, 0.009, 0.009,
    ),
    "Serra et al. 2012, in the paper": (
        0.063, 0.069, 0.076, 0.027, 0.041, 0.033, 0.021, 0.022, 0.025, 0.006, 0.006, 0.007,
    ),
}  # fmt: skip
"""In the order of `_COLUMNS`."""
SHARED = {"sirfs": 0, "gehler": 1, "serra": 2}
"""Rows of the paper's table for methods that are here too."""
_SLIGHT = 0.5
"""Shading hardly notices colour if it changes by less than this share of reflectance's change."""

Row = dict[tuple[str, Kind], float]


def paper_tables(evaluation: Evaluation) -> list[Table]:
    """Return the table by each LMSE that images of known kinds were measured by.

    Each figure is the mean over the images of a kind, with a 95% interval over scenes.
    """
    columns = [column for column in _COLUMNS if column[1] in evaluation.kinds]
    tables = []
    for metric in _TITLES:
        methods = [m for m in evaluation.methods if Column(metric, REFLECTANCE) in m.columns]
        if columns and methods:
            tables.append(_paper_table(evaluation, metric, methods, columns))
    return tables


def _paper_table(
    evaluation: Evaluation,
    metric: str,
    methods: Sequence[MethodScores],
    columns: Sequence[tuple[str, Kind]],
) -> Table:
    rows, means = [], dict[str, Row]()
    for method in methods:
        values = {layer: method.values(Column(metric, layer), evaluation.images) for layer in BOTH}
        cells = [_cell(values[layer], kind, evaluation) for layer, kind in columns]
        known = zip(columns, cells, strict=True)
        means[method.name] = {c: cell.value for c, cell in known if cell.value is not None}
        rows.append((method.name, cells))
    for name, figures in _PAPER.items():
        of = dict(zip(_COLUMNS, figures, strict=True))
        rows.append((name, [Cell(of[column]) for column in columns]))
    heads = ["method", *(f"{layer}, {kind.content}, {kind.light}" for layer, kind in columns)]
    findings = _findings(means) if len(columns) == len(_COLUMNS) else ()
    return Table(*_TITLES[metric], heads, rows, findings)


def _cell(values: Floats, kind: Kind, evaluation: Evaluation) -> Cell:
    """Return the mean over the images of a kind."""
    of_kind = np.array([each == kind for each in evaluation.kinds])
    groups = group_by_scene(np.where(of_kind, values, np.nan), evaluation.scenes)
    if not groups:
        return Cell(None)
    return Cell(float(np.concatenate(groups).mean()), interval(scene_interval(groups)))


def _findings(means: dict[str, Row]) -> list[str]:
    """Return in which of the paper's observations our scores agree with it."""
    rows = {name: row for name, row in means.items() if len(row) == len(_COLUMNS)}
    if not rows:
        return []
    paper = [dict(zip(_COLUMNS, figures, strict=True)) for figures in _PAPER.values()]
    said = []
    for sentence, holds in _TRENDS:
        agree = [name for name, row in rows.items() if holds(row)]
        others = [name for name in rows if name not in agree]
        but = f"; not for {', '.join(others)}" if agree and others else ""
        theirs = sum(map(holds, paper))
        said.append(
            f"{sentence}: in the paper for {theirs} of {len(paper)} methods, here for {len(agree)} "
            f"of {len(rows)}{but}."
        )
    return [*said, *_rankings(rows, paper)]


def _average(row: Row, layer: str, *lights: str, contents: Sequence[str] = CONTENTS) -> float:
    return float(np.mean([row[layer, Kind(c, light)] for c in contents for light in lights]))


def _colour_costs(row: Row) -> bool:
    white = _average(row, REFLECTANCE, WHITE_LIGHT)
    return white < min(_average(row, REFLECTANCE, light) for light in (ONE_LIGHT, TWO_LIGHTS))


def _complex_is_lower(row: Row) -> bool:
    lower, higher = (
        [_average(row, layer, *COLORS_OF_LIGHT, contents=(content,)) for layer in BOTH]
        for content in (COMPLEX, OBJECT)
    )
    return all(one < other for one, other in zip(lower, higher, strict=True))


def _shading_hardly_notices(row: Row) -> bool:
    changes = [
        abs(_average(row, layer, ONE_LIGHT, TWO_LIGHTS) - _average(row, layer, WHITE_LIGHT))
        for layer in (SHADING, REFLECTANCE)
    ]
    return changes[0] < _SLIGHT * changes[1]


_TRENDS = (
    ("Errors of reflectance rise when the light is not white", _colour_costs),
    ("Complex scenes score lower than objects, in both layers", _complex_is_lower),
    (
        "Shading hardly notices colour (it changes by less than half as much as reflectance)",
        _shading_hardly_notices,
    ),
)


def _rankings(rows: dict[str, Row], paper: Sequence[Row]) -> list[str]:
    """Return in how many columns two methods rank as they do in the paper."""
    said = []
    for first, second in combinations([name for name in SHARED if name in rows], 2):
        one, two = paper[SHARED[first]], paper[SHARED[second]]
        same = sum((one[p] - two[p]) * (rows[first][p] - rows[second][p]) > 0.0 for p in _COLUMNS)
        apart = sum(one[p] != two[p] for p in _COLUMNS)
        said.append(f"{first} and {second} rank as in the paper in {same} of {apart} columns.")
    return said
