"""How far the predicted time of a render is off, after a tenth of it."""

from __future__ import annotations

from typing import Any

import photonmap as pm
from benchmarks.options import Options
from benchmarks.table import Table

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
    """Render to all budgets, and look at what the records say was predicted."""
    table = Table(
        "forecast: predicted / true seconds, 128×128, 6 bands",
        ["scene", "budget", "passes", "seconds", "least", "most", "at most"],
    )
    for scene, name in SCENES.items():
        pm.render(getattr(pm.scenes, name)(), passes=2, **SETTINGS)  # compiles
        for budget in BUDGETS:
            record = pm.render(
                getattr(pm.scenes, name)(), threads=options.threads, **budget, **SETTINGS
            ).record
            total = record["seconds"]["render"]
            pairs = record["predicted_seconds"]
            factors = [told / total for elapsed, told in pairs if elapsed >= TENTH * total]
            ((kind, value),) = budget.items()
            row = [scene, f"{kind} {value}", record["passes"], total]
            table.rows.append([*row, min(factors), max(factors), ALLOWED])
    table.notes = ["predicted after 1, 2, 4, 8, … passes, but not before a tenth of the time"]
    return [table]
