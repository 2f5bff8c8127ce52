"""What makes a data set hard for a method: coloured light, a second one, interreflection, noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from photonmap.evaluate.bench.images import ONE_LIGHT, TWO_LIGHTS, WHITE_LIGHT
from photonmap.evaluate.bench.measure import MEAN_LAYER, Column
from photonmap.evaluate.bench.scores import Evaluation, MethodScores
from photonmap.evaluate.experiments.paper_table import METRIC
from photonmap.evaluate.intervals import group_by_scene, paired_test, scene_interval
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.evaluate.report.tables import Cell, Table, interval, number

COLUMN = Column(METRIC, MEAN_LAYER)
_HEADS = (
    "method", "LMSE", "interreflection", "one colour for white", "second light for one",
    "bands for RGB", "noise of the truth",
)  # fmt: skip


def cost_table(everything: Evaluation, direct: Evaluation, banded: Evaluation) -> Table | None:
    """Return by how much conditions change the LMSE of methods, mean of reflectance and shading.

    Parameters
    ----------
    everything : of all light, in RGB, with draws of the truth's noise if that is to be shown
    direct : of the same images without indirect light
    banded : of the same images in their bands
    """
    rows: list[tuple[str, Sequence[Cell]]] = []
    for method in everything.methods:
        if COLUMN not in method.columns:
            continue
        scores = method.values(COLUMN, everything.images)
        cells = [Cell(float(np.nanmean(scores)))]
        cells.append(_change(_of(method.name, direct), scores, everything.scenes))
        for before, after in ((WHITE_LIGHT, ONE_LIGHT), (ONE_LIGHT, TWO_LIGHTS)):
            pair = [_by_scene(scores, everything, light) for light in (before, after)]
            cells.append(_change(pair[0], pair[1], sorted(set(everything.scenes))))
        cells.append(_change(scores, _of(method.name, banded), everything.scenes))
        cells.append(_noise(method, scores))
        rows.append((method.name, cells))
    if not rows:
        return None
    return Table(
        "costs",
        "What makes images hard",
        "The LMSE of all images (one factor a window for all bands, mean of reflectance and "
        "shading), and how it changes: with all light where there was direct light alone; in light "
        "of one colour where it was white, and in two lights where it was one colour; in the data "
        "set's bands where it was RGB; and if the standard error of the truth is added to it once "
        "more. Below: 95% intervals over scenes, and p of a permutation test over scenes.",
        _HEADS,
        rows,
        _findings(rows),
    )


def _of(name: str, evaluation: Evaluation) -> Floats:
    """Return the scores of a method by image, nan where there is none."""
    found = next((method for method in evaluation.methods if method.name == name), None)
    if found is None:
        return np.full(len(evaluation.images), np.nan)
    return found.values(COLUMN, evaluation.images)


def _by_scene(scores: Floats, evaluation: Evaluation, light: str) -> Floats:
    """Return the mean score of each scene's images in a light, nan where there is none."""
    lit = np.array([kind.light == light for kind in evaluation.kinds])
    names = np.array(evaluation.scenes, object)
    means = []
    for scene in sorted(set(evaluation.scenes)):
        found = scores[lit & (names == scene) & np.isfinite(scores)]
        means.append(found.mean() if found.size else np.nan)
    return np.array(means)


def _change(before: Floats, after: Floats, scenes: Sequence[str]) -> Cell:
    """Return the mean change over pairs that have both scores."""
    groups = group_by_scene(after - before, scenes)
    if not groups:
        return Cell(None)
    ends = interval(scene_interval(groups))
    p_value = paired_test(after, before, scenes)
    return Cell(float(np.concatenate(groups).mean()), f"{ends} p {number(p_value)}".strip())


def _noise(method: MethodScores, scores: Floats) -> Cell:
    """Return how much higher scores are against a truth with more noise."""
    drawn = method.drawn(COLUMN)
    if not len(drawn):
        return Cell(None)
    return Cell(float(drawn.mean() - np.nanmean(scores)))


def _findings(rows: Sequence[tuple[str, Sequence[Cell]]]) -> list[str]:
    """Return for how many methods each change is significant, and in which direction."""
    said = []
    for place, what in enumerate(_HEADS[2:-1], 1):
        up, down, known = 0, 0, 0
        for _, cells in rows:
            value, note = cells[place]
            if value is None:
                continue
            known += 1
            sure = note.rpartition("p ")[2]
            if sure and float(sure) < 0.05:
                up, down = up + (value > 0.0), down + (value < 0.0)
        if known:
            said.append(
                f"{what.capitalize() if what != 'bands for RGB' else 'Bands for RGB'}: raises the "
                f"error of {up} of {known} methods and lowers that of {down} (p < 0.05)."
            )
    return said
