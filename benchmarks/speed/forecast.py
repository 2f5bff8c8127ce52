"""Error of the predicted render time, after a tenth of the time."""

from __future__ import annotations

from typing import Any

import photonmap as pm
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table

SCENES = {
    "Cornell box": "cornell_box",
    "mirror and glass": "cornell_balls",
    "two rooms": "two_rooms",
}
BUDGETS: tuple[dict[str, Any], ...] = (
    {"error": 0.02},
    {"error": "indirect:p95:0.05"},
    {"error": 0.008},
    {"passes": 100},
    {"seconds": 10.0},
)
SETTINGS: dict[str, Any] = {"bands": 6, "size": (128, 128)}
TENTH = 0.1
ALLOWED = 1.5


def run(options: Options) -> list[Table]:
    """Render with all budgets, and compare the predictions in the records with the truth."""
    table = Table(
        "forecast: predicted / true seconds, 128×128, 6 bands",
        ["scene", "budget", "passes", "seconds", "smallest", "largest", "target: at most"],
    )
    for scene, name in SCENES.items():
        pm.render(getattr(pm.scenes, name)(), passes=2, **SETTINGS)  # compiles
        for budget in BUDGETS:
            record = pm.render(
                getattr(pm.scenes, name)(), threads=options.threads, **budget, **SETTINGS
            ).record
            total = record["seconds"]["render"]
            pairs = record["predicted_seconds"]
            factors = [forecast / total for elapsed, forecast in pairs if elapsed >= TENTH * total]
            ((kind, value),) = budget.items()
            row = [scene, f"{kind} {value}", record["passes"], total]
            table.rows.append([*row, min(factors), max(factors), ALLOWED])
    table.notes = ["predicted after 1, 2, 4, 8, … passes, but not before a tenth of the time"]
    return [table]
