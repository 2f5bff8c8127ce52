"""Merge renders of one scene with different seeds, as if they had been one run.

Means are weighted by each pixel's number of passes, and standard errors are pooled from the spread
within the runs and between them (Chan, Golub and LeVeque 1983). Direct light is not filtered.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import group_name, in_order, names_where, row_of, split_name
from photonmap.errors import InputError
from photonmap.film.bias import BlockBias
from photonmap.film.blocks import BLOCKED, SIDE, block_means, block_minima
from photonmap.film.pooling import (
    error_of,
    pool_comoments,
    pool_errors,
    pool_means,
    shift_ratio,
    spread_of,
    sum_counts,
    variance_divisor,
)
from photonmap.film.relative_error import relative_squares, valid_pixels
from photonmap.results.relighting import sum_images
from photonmap.results.result import Result, check_result
from photonmap.results.unfiltered import UNFILTERED, unfiltered
from photonmap.runtime.fingerprint import difference
from photonmap.runtime.wording import listed

Array = NDArray[np.float64]

POOLED = names_where(pooling="mean", has_error=True)
"""Buffers that are means over passes, with standard errors."""
SAME = names_where(pooling="same")
"""Buffers that depend on the scene alone."""
REQUIRED = names_where(kept="all", omitted="never")
"""Buffers without which a result cannot be merged."""


def merge(results: Iterable[Result], names: Sequence[str] | None = None) -> Result:
    """Merge renders that differ in their seeds, passes and threads alone.

    Parameters
    ----------
    results : two or more, merged ones among them
    names : what errors call them; "result 1" and so on if left out

    Returns
    -------
    Result. Its means and errors are those of one run of all passes, up to float32.

    Raises
    ------
    InputError : no list of results, fewer than two, a seed that occurs twice, another scene or
        other arguments, or buffers that were not written
    """
    if isinstance(results, Result | str) or not isinstance(results, Iterable):
        raise InputError("merge takes its results in a list, as in merge([one, other])")
    results = [check_result(result) for result in results]
    names = names or [f"result {i}" for i, _ in enumerate(results, start=1)]
    if len(results) < 2:
        raise InputError("merging needs at least two results")
    for result, name in zip(results, names, strict=True):
        _check_complete(result, name)
    for result, name in zip(results[1:], names[1:], strict=True):
        _check_alike(results[0], result, names[0], name)
    _check_seeds(results, names)
    runs = [_Run(unfiltered(result)) for result in results]
    buffers, errors = _merge_light(runs)
    buffers |= _merge_rest(runs)
    errors = errors if (buffers["passes"] > 1).any() else {}
    blocks = _merge_blocks(runs) if errors else {}
    merged = Result(in_order(buffers), errors, results[0].bands, {}, blocks)
    merged.record = merge_records([result.record for result in results], merged)
    return merged


class _Run:
    """The moments of one result, float64, (H, W, N) or (H, W, 1)."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.count = result.passes.astype(np.float64)[..., None]
        self.scale = variance_divisor(self.count)

    def mean(self, name: str) -> Array:
        """Return the mean of a buffer; 0 where there was nothing to write."""
        image = self.result.buffers.get(name)
        shape = self.result.radiance.shape
        return np.zeros(shape) if image is None else image.astype(np.float64)

    def spread(self, name: str) -> Array:
        """Return the sum of squared deviations of a buffer."""
        error = self.result.errors.get(name)
        if error is None:
            return np.zeros(self.result.radiance.shape)
        return spread_of(error, self.count)


def _merge_light(runs: list[_Run]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return all buffers with bands, and their errors."""
    buffers: dict[str, NDArray[np.float32]] = {}
    errors: dict[str, NDArray[np.float32]] = {}
    present = runs[0].result.buffers
    groups = [group for group in dict.fromkeys(split_name(name)[1] for name in present) if group]
    for name in present:
        if split_name(name)[0] in POOLED:
            buffers[name], errors[name] = _pool(name, runs)
    for name in names_where(pooling="mean", per_light=True):
        if groups and name in buffers:
            buffers[name] = sum_images([buffers[group_name(name, group)] for group in groups])
    buffers["radiance"] = (buffers["emission"] + buffers["direct"]) + buffers["indirect"]
    errors["radiance"] = _pool("radiance", runs)[1]
    for group in (*groups, ""):
        _merge_shading(group, runs, buffers, errors)
    if groups:
        buffers["shading"] = sum_images([buffers[group_name("shading", g)] for g in groups])
    return buffers, errors


def _merge_rest(runs: list[_Run]) -> dict[str, NDArray[Any]]:
    """Return all buffers without errors that the runs have, as their rows say."""
    merged: dict[str, NDArray[Any]] = {}
    counts = [run.count for run in runs]
    taken = [count[..., 0] > 0.0 for count in counts]
    for name, image in runs[0].result.buffers.items():
        row, images = row_of(name), [run.result.buffers.get(name, image) for run in runs]
        if row is None or row.has_error:
            continue
        if row.pooling == "same":
            merged[name] = image
        elif row.pooling == "sum":
            merged[name] = np.sum(images, axis=0, dtype=image.dtype)
        elif row.pooling == "all":
            agree = [ours | ~some for ours, some in zip(images, taken, strict=True)]
            merged[name] = np.logical_and.reduce(agree) & np.logical_or.reduce(taken)
        elif row.pooling == "mean":
            of_image = [count if row.is_banded else count[..., 0] for count in counts]
            mean = pool_means(of_image, [values.astype(np.float64) for values in images])
            merged[name] = mean.astype(image.dtype)
    return merged


def _pool(name: str, runs: list[_Run]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the mean and the standard error of a buffer."""
    means, counts = [run.mean(name) for run in runs], [run.count for run in runs]
    spreads = [run.spread(name) for run in runs]
    error = error_of(pool_comoments(counts, means, means, spreads), sum_counts(counts))
    return pool_means(counts, means).astype(np.float32), error.astype(np.float32)


def _merge_blocks(runs: list[_Run]) -> dict[str, NDArray[np.float32]]:
    """Return the standard errors of blocks' means; a block has the least passes of its pixels."""
    counts = [block_minima(run.count, SIDE) for run in runs]
    nothing = np.zeros(1)
    merged = {}
    for name in dict.fromkeys(name for run in runs for name in run.result.block_errors):
        means = [block_means(run.mean(name), SIDE) for run in runs]
        errors = [run.result.block_errors.get(name, nothing) for run in runs]
        merged[name] = pool_errors(counts, means, errors).astype(np.float32)
    return merged


def _merge_shading(
    group: str, runs: list[_Run], buffers: dict[str, Any], errors: dict[str, Any]
) -> None:
    """Add shading, its error and the covariance: of a light group, or of the whole ("").

    The ratio of reflected light to reflectance where that is not 0, with the error of a ratio by
    the delta method, as in `photonmap.kernels.film.moments`; the mean irradiance / π elsewhere.
    """
    name, covariance_name = group_name("shading", group), group_name("covariance", group)
    buffers[name], errors[name] = _pool(name, runs)
    shadings = [run.mean(name) for run in runs]
    albedos = [run.mean("reflectance") for run in runs]
    reflected = [s * r for s, r in zip(shadings, albedos, strict=True)]
    counts = [run.count for run in runs]
    light, count = pool_means(counts, reflected), sum_counts(counts)
    plain = buffers.get("residual", np.zeros(1)) == 0.0
    direct, indirect = (buffers[group_name(part, group)] for part in ("direct", "indirect"))
    whole = direct.astype(np.float64) + indirect
    whole -= buffers.get(group_name("fluorescence", group), 0.0)
    known = buffers["reflectance"] > 0.0
    divisor = np.where(known, buffers["reflectance"], 1.0).astype(np.float64)
    ratio = np.where(plain, whole, light) / divisor
    own = [run.mean(covariance_name) * run.scale for run in runs]
    product = pool_comoments(counts, reflected, albedos, own)
    spread = np.zeros_like(ratio)
    for run, s, r, comoment in zip(runs, shadings, albedos, own, strict=True):
        within = shift_ratio(r**2 * run.spread(name), comoment, run.spread("reflectance"), s, ratio)
        # Where this run saw no reflectance, its shading is of another kind, and nothing deviates.
        spread += np.where(r > 0.0, within, 0.0) + run.count * ((ratio - s) * r) ** 2
    buffers[name] = np.where(known, ratio, buffers[name]).astype(np.float32)
    error = (error_of(spread, count) / divisor).astype(np.float32)
    errors[name] = np.where(known, error, errors[name])
    covariance = (product / np.maximum(variance_divisor(count), 1.0)).astype(np.float32)
    if covariance.any():
        buffers[covariance_name] = covariance


def _check_complete(result: Result, name: str) -> None:
    """Raise InputError if a result lacks what merging takes."""
    if "fingerprint" not in result.record:
        raise InputError(f"{name}: its record lacks what merging needs; render it again")
    record = result.record
    extra = {
        "fluorescence": record.get("effects", {}).get("fluorescence", {}).get("on"),
        **{UNFILTERED[name]: made["on"] for name, made in record.get("light_filter", {}).items()},
    }
    required = (*REQUIRED, *(buffer for buffer, is_there in extra.items() if is_there))
    missing = [buffer for buffer in required if buffer not in result.buffers]
    several = not missing and (result.passes > 1).any()
    if several and "reflectance" in result.errors and "covariance" not in result.buffers:
        varies = (result.errors["reflectance"] > 0.0) & (result.shading > 0.0)
        missing = ["covariance"] if varies.any() else []
    if several and not missing:
        missing = [f"{buffer}.error" for buffer in POOLED if buffer in result.buffers]
        missing = [error for error in missing if error.partition(".")[0] not in result.errors]
        blocked = [name for name in BLOCKED if name in result.buffers]
        missing += [f"{name}.error8" for name in blocked if name not in result.block_errors]
    if missing:
        raise InputError(
            f"{name}: {listed(missing)} {'is' if len(missing) == 1 else 'are'} missing; "
            f"render all buffers to merge"
        )


def _check_alike(first: Result, other: Result, name: str, other_name: str) -> None:
    """Raise InputError if two results are not of the same scene and arguments."""
    prints = [{**result.record["fingerprint"], "seed": None} for result in (first, other)]
    reason = difference(prints[0], prints[1], (f"in {name}", f"in {other_name}"))
    if not reason and first.bands.describe() != other.bands.describe():
        counts = f"bands {first.bands.count} in {name}, {other.bands.count} in {other_name}"
        reason = counts if first.bands.count != other.bands.count else "other bands"
    # What is left out where it is 0 everywhere may be in one of the two alone.
    zero = (*names_where(omitted="where it is 0 everywhere"), *UNFILTERED.values())
    sets = [{n for n in r.buffers if split_name(n)[0] not in zero} for r in (first, other)]
    if not reason and sets[0] != sets[1]:
        reason = f"{listed(sorted(sets[0] ^ sets[1]))} in one of them alone"
    for buffer in (name for name in SAME if name in sets[0] and not reason):
        if not np.array_equal(first.buffers[buffer], other.buffers[buffer]):
            reason = f"other {buffer}"
    if reason:
        raise InputError(
            f"{other_name} cannot be merged with {name}: {reason}; "
            "merge renders that differ in their seed, passes and threads alone"
        )


def _check_seeds(results: list[Result], names: Sequence[str]) -> None:
    """Raise InputError if the same passes would count twice."""
    owner: dict[int, str] = {}
    for result, name in zip(results, names, strict=True):
        for run in _runs_of(result.record):
            seed = run["seed"]
            if seed in owner:
                raise InputError(
                    f"{name} and {owner[seed]} both have seed {seed} and hold the same passes; "
                    f"render one of them with another seed"
                )
            owner[seed] = name


SUMS = ("passes", "photons", "photons_stored", "rays")


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
        "rays_by_kind": _sum_numbers([record.get("rays_by_kind", {}) for record in records]),
        "photons_reused": sum(record.get("photons_reused", 0) for record in records),
        "pass_samples": min(record.get("pass_samples", 1.0) for record in records),
        "error": relative_error(merged),
        "goal": None,
        "bias_blocks": _bias_blocks(records),
        "unresolved": int(merged.unresolved.sum()),
        "interrupted": any(record["interrupted"] for record in records),
        "resumed": sum(record["resumed"] for record in records),
        "predicted_seconds": [],
        "light_filter": {
            name: {"on": False, "why": "runs are merged by their plain means"}
            for name in UNFILTERED
        },
        "effects": _effects([record["effects"] for record in records]),
        "seconds": _sum_numbers([record["seconds"] for record in records]),
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


def _sum_numbers(parts: list[dict[str, float]]) -> dict[str, float]:
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
