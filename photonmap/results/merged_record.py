"""The record of a merged result: what its runs add up to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from photonmap.film.bias import BlockBias
from photonmap.film.relative_error import relative_squares
from photonmap.film.valid_pixels import valid_pixels

if TYPE_CHECKING:
    from photonmap.results.result import Result

SUMS = ("passes", "photons", "photons_stored", "rays")


def seeds_of(record: dict[str, Any]) -> list[int]:
    """Return the seeds of a result: one, or those that were merged."""
    return [run["seed"] for run in _runs_of(record)]


def merge_records(records: list[dict[str, Any]], merged: Result) -> dict[str, Any]:
    """Return the record of a merged result.

    What the runs share stands as in theirs. `merged` lists the runs; passes, photons, rays and
    seconds are sums, and `error` is computed again.
    """
    first = records[0]
    runs = [run for record in records for run in _runs_of(record)]
    seeds = [run["seed"] for run in runs]
    sums = {name: sum(record[name] for record in records) for name in SUMS}
    arguments = {
        **first["arguments"],
        "seed": seeds,
        "budget": {"passes": sums["passes"]},
        "threads": max(record["arguments"]["threads"] for record in records),
    }
    return {
        **first,
        "arguments": arguments,
        "fingerprint": {**first["fingerprint"], "seed": seeds},
        "merged": runs,
        **sums,
        "rays_by_kind": _sums([record.get("rays_by_kind", {}) for record in records]),
        "pass_samples": min(record.get("pass_samples", 1.0) for record in records),
        "error": relative_error(merged),
        "goal": None,
        "bias_blocks": _bias_blocks(records),
        "unresolved": int(merged.unresolved.sum()),
        "interrupted": any(record["interrupted"] for record in records),
        "resumed": sum(record["resumed"] for record in records),
        "predicted_seconds": [],
        "effects": _effects([record["effects"] for record in records]),
        "seconds": _sums([record["seconds"] for record in records]),
        "warnings": list(
            dict.fromkeys(message for record in records for message in record["warnings"])
        ),
    }


def relative_error(result: Result) -> float | None:
    """Return the relative standard error of radiance, as `Accumulator.error` defines it."""
    if "radiance" not in result.errors:
        return None
    valid = valid_pixels(result.coverage, result.emission, result.unresolved)
    if not valid.any():
        return 0.0
    value = result.radiance[valid].astype(np.float64)
    variance = result.errors["radiance"][valid].astype(np.float64) ** 2
    error = np.sqrt(relative_squares(variance, value).mean())
    return float(error) if np.isfinite(error) else None


def _bias_blocks(records: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the bias of blocks, if all runs know it."""
    known = [record.get("bias_blocks") for record in records]
    parts = [BlockBias.read(blocks) for blocks in known if blocks is not None]
    if len(parts) < len(known):
        return None
    return BlockBias.pool(parts, [record["passes"] for record in records]).describe()


def _runs_of(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the runs that a result is made of: one, or those that were merged."""
    if "merged" in record:
        return record["merged"]
    run = {name: record[name] for name in ("passes", "photons", "rays", "error")}
    return [{"seed": record["arguments"]["seed"], **run, "seconds": record["seconds"]["render"]}]


def _sums(parts: list[dict[str, float]]) -> dict[str, float]:
    names = dict.fromkeys(name for part in parts for name in part)
    return {name: sum(part.get(name, 0) for part in parts) for name in names}


def _effects(plans: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the plan of the first, with the seconds of all."""
    merged = {}
    for name, effect in plans[0].items():
        spent = [plan[name]["seconds"] for plan in plans]
        timed = [seconds for seconds in spent if seconds is not None]
        merged[name] = {**effect, "seconds": sum(timed) if timed else None}
    return merged
