"""What makes a data set hard for methods, and how many scenes distinguish them: both by LMSE.

Coloured light, a second light, interreflection, bands and the noise of the truth are told apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from photonmap.evaluate.bench.images import ONE_LIGHT, TWO_LIGHTS, WHITE_LIGHT
from photonmap.evaluate.bench.measure import MEAN_LAYER, Column
from photonmap.evaluate.bench.scores import Evaluation
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

    The first evaluation is of all light, in RGB, with draws of the truth's noise if that is to be
    shown; the others are of the same images without indirect light, and in their bands.
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
        noisier = method.drawn(COLUMN)
        more = float(noisier.mean() - np.nanmean(scores)) if len(noisier) else None
        cells.append(Cell(more))
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


def _findings(rows: Sequence[tuple[str, Sequence[Cell]]]) -> list[str]:
    """Return for how many methods each change is significant, and in which direction."""
    said = []
    for column, what in enumerate(_HEADS[2:-1], 1):
        up, down, known = 0, 0, 0
        for _, cells in rows:
            value, note = cells[column]
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


POWER = 0.8  # Probability of finding a difference that is there
_SIGNIFICANCE = 0.05
_DRAWS = 400  # Sets of scenes that are drawn for each number of scenes


def scenes_needed(differences: Floats) -> float:
    """Return for how many scenes a difference of two methods would be found, 4 times out of 5.

    n = ((z_{1−α/2} + z_{power}) σ / |μ|)², the normal approximation for a paired two-sided test at
    α = 5%, with mean μ and standard deviation σ of the differences of mean scores, (S,); infinite
    if they have mean 0.
    """
    from scipy.stats import norm

    mean, deviation = float(differences.mean()), float(differences.std(ddof=1))
    if mean == 0.0:
        return float("inf")
    quantiles = float(norm.ppf(1.0 - _SIGNIFICANCE / 2.0) + norm.ppf(POWER))
    return max((quantiles * deviation / abs(mean)) ** 2, 2.0)


def sample_tables(evaluation: Evaluation) -> list[Table]:
    """Return how stable the ranking is for a number of scenes, and how many each pair needs.

    None with fewer than three scenes or two methods that were scored on all of them.
    """
    names, scores = _scene_scores(evaluation)
    count = scores.shape[1] if len(names) else 0
    if len(names) < 2 or count < 3:
        return []
    return [_stability(scores), _pairs(names, scores)]


def _scene_scores(evaluation: Evaluation) -> tuple[list[str], Floats]:
    """Return methods with scores in all scenes, and their mean scores (M, S)."""
    names, rows = [], []
    for method in evaluation.methods:
        values = method.values(COLUMN, evaluation.images)
        if np.isfinite(values).all():
            names.append(method.name)
            rows.append([each.mean() for each in group_by_scene(values, evaluation.scenes)])
    return names, np.array(rows)


def _stability(scores: Floats) -> Table:
    """Return how many pairs of methods fewer scenes rank as all of them do."""
    rng = np.random.Generator(np.random.PCG64(0))
    pairs = np.array(list(combinations(range(len(scores)), 2)))
    signs = np.sign(scores[pairs[:, 0]] - scores[pairs[:, 1]])  # of each scene
    wanted = np.sign((scores[pairs[:, 0]] - scores[pairs[:, 1]]).mean(axis=1))
    rows = []
    sizes = [n for n in (1, 2, 3, 5, 8, 12, 17, 25, 50, 100) if n < scores.shape[1]]
    for size in sizes:
        shares = []
        for _ in range(_DRAWS):
            drawn = rng.choice(scores.shape[1], size, replace=False)
            means = scores[:, drawn].mean(axis=1)
            found = np.sign(means[pairs[:, 0]] - means[pairs[:, 1]])
            shares.append(float((found == wanted).mean()))
        low = float(np.quantile(shares, 0.05))
        rows.append((f"{size}", [Cell(float(np.mean(shares))), Cell(low)]))
    agree = float((signs == wanted[:, None]).mean())
    return Table(
        "ranking-by-scenes",
        "How many scenes a ranking needs",
        "Share of pairs of methods that some scenes, drawn at random, rank as all scenes do, by "
        "LMSE (mean of reflectance and shading): its mean, and what 95% of draws exceed.",
        ["scenes", "pairs ranked alike", "95% exceed"],
        rows,
        [f"A single scene ranks {100 * agree:.0f}% of the pairs as all {scores.shape[1]} do."],
    )


def _pairs(names: list[str], scores: Floats) -> Table:
    """Return how many scenes each pair of methods needs."""
    rows = []
    for first, second in combinations(range(len(names)), 2):
        differences = scores[first] - scores[second]
        needed = scenes_needed(differences) if differences.any() else float("inf")
        shown = Cell(float(np.ceil(needed))) if np.isfinite(needed) else Cell(None, "equal")
        rows.append(
            (f"{names[first]} and {names[second]}", [Cell(float(differences.mean())), shown])
        )
    rows.sort(key=lambda row: row[1][1].value or np.inf)
    there = scores.shape[1]
    enough = sum((row[1][1].value or np.inf) <= there for row in rows)
    return Table(
        "scenes-by-pair",
        "How many scenes a pair of methods needs",
        "Number of scenes for which a paired test at 5% would find the difference four times out "
        "of five, from the mean and the standard deviation over these scenes.",
        ["methods", "difference", "scenes needed"],
        rows,
        [f"{there} scenes are enough for {enough} of {len(rows)} pairs."],
    )
