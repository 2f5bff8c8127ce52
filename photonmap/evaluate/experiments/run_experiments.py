"""Run all experiments on a data set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from photonmap.evaluate.bench.images import open_finished, shots
from photonmap.evaluate.bench.measure import REFLECTANCE, Column, choose_metrics
from photonmap.evaluate.bench.run import evaluate_dataset, one_thread
from photonmap.evaluate.bench.scores import Evaluation
from photonmap.evaluate.experiments.degradations import OrderTest
from photonmap.evaluate.experiments.lmse import cost_table, sample_tables
from photonmap.evaluate.experiments.paper_table import METRIC
from photonmap.evaluate.methods.method import Method
from photonmap.evaluate.report.gallery import Disagreements
from photonmap.evaluate.report.tables import Table


def run_experiments(
    folder: Path,
    evaluation: Evaluation,
    methods: Sequence[str | Method],
    disagreements: Disagreements,
    log: Callable[[str], None] = lambda line: None,
) -> list[Table]:
    """Return the tables of all experiments that the data set and the methods allow.

    The evaluation is of the data set in RGB and all light, by `METRIC` and at least the methods,
    which may be fewer to save time; `disagreements` are given those of LMSE with a known order;
    `log` is called with a line for each image. An `InputError` says that an image has light that is
    not reflected diffusely, or what `evaluate_dataset` says.
    """
    tables: list[Table | None] = []
    scored = {m.name for m in evaluation.methods if Column(METRIC, REFLECTANCE) in m.columns}
    decomposing = [m for m in methods if (m if isinstance(m, str) else m.name) in scored]
    if decomposing:
        log("in direct light")
        direct = evaluate_dataset(folder, decomposing, [METRIC], "rgb", 0, "direct", log)
        log("in bands")
        banded = evaluate_dataset(folder, decomposing, [METRIC], "bands", 0, "all", log)
        tables.append(cost_table(evaluation, direct, banded))
    tables += sample_tables(evaluation)
    log("degradations")
    test, seen = OrderTest(choose_metrics(None, "rgb"), disagreements.keep_known), set()
    with one_thread():
        for shot in shots(open_finished(folder), "rgb"):
            if shot.truth.scene not in seen:  # the first image of each
                seen.add(shot.truth.scene)
                test.add(shot.truth)
    tables.append(test.table())
    return [table for table in tables if table is not None]
