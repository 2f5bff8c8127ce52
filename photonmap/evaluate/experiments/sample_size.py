"""How many scenes it takes to distinguish methods."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from photonmap.evaluate.bench.scores import Evaluation
from photonmap.evaluate.experiments.costs import COLUMN
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.evaluate.report.tables import Cell, Table

POWER = 0.8
"""Probability of finding a difference that is there."""
_LEVEL = 0.05
_DRAWS = 400
"""Sets of scenes that are drawn for each number of scenes."""


def scenes_needed(differences: Floats) -> float:
    """Return for how many scenes a difference of two methods would be found, 4 times out of 5.

    n = ((z_{1−α/2} + z_{power}) σ / |μ|)², the normal approximation for a paired two-sided test at
    α = 5%, with mean μ and standard deviation σ of the differences; infinite if they have mean 0.

    Parameters
    ----------
    differences : (S,) of the mean scores of each scene
    """
    from scipy.stats import norm

    mean, deviation = float(differences.mean()), float(differences.std(ddof=1))
    if mean == 0.0:
        return float("inf")
    quantiles = float(norm.ppf(1.0 - _LEVEL / 2.0) + norm.ppf(POWER))
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
    scenes = np.array(evaluation.scenes, object)
    names, rows = [], []
    for method in evaluation.methods:
        values = method.values(COLUMN, evaluation.images)
        if np.isfinite(values).all():
            names.append(method.name)
            rows.append([values[scenes == scene].mean() for scene in dict.fromkeys(scenes)])
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
