"""Merge renders of one scene with different seeds, as if they had been one run.

Means are weighted by each pixel's number of passes, and standard errors are pooled from the spread
within the runs and between them (Chan, Golub and LeVeque 1983).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.block_errors import BLOCKED, block_means, block_minima, pool_errors
from photonmap.errors import InputError
from photonmap.fingerprint import difference
from photonmap.merged_record import merge_records, seeds_of
from photonmap.messages import listed
from photonmap.output import BUFFERS, in_order
from photonmap.result import Result

Array = NDArray[np.float64]

CENTRES = ("depth", "normal", "object_id", "material_id")
"""Buffers that depend on the scene alone."""
OPTIONAL = ("caustics", "residual", "covariance")
"""Buffers that some scenes do not have."""
POOLED = ("emission", "direct", "indirect", "caustics", "residual", "reflectance")


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
    InputError : less than two, a seed that comes twice, another scene or other arguments, or
        buffers that were not written
    """
    results = list(results)
    names = names or [f"result {i}" for i, _ in enumerate(results, start=1)]
    if len(results) < 2:
        raise InputError("merging takes two results or more")
    for result, name in zip(results, names, strict=True):
        _check_whole(result, name)
    for result, name in zip(results[1:], names[1:], strict=True):
        _check_alike(results[0], result, names[0], name)
    _check_seeds(results, names)
    runs = [_Run(result) for result in results]
    buffers, errors = _merge_light(runs)
    passes = _count(runs)[..., 0]
    coverage = _mean([run.coverage for run in runs], runs)[..., 0]
    buffers["coverage"] = coverage.astype(np.float32)
    silent = [(run.count[..., 0] == 0) | run.result.unresolved for run in runs]
    buffers["unresolved"] = np.logical_and.reduce(silent) & (passes > 0)
    buffers["passes"] = passes.astype(np.uint32)
    buffers |= {name: results[0].buffers[name] for name in CENTRES}
    errors = errors if (passes > 1).any() else {}
    blocks = _merge_blocks(runs) if errors else {}
    merged = Result(in_order(buffers), errors, results[0].bands, {}, blocks)
    merged.record = merge_records([result.record for result in results], merged)
    return merged


class _Run:
    """The moments of one result, float64, (H, W, N) or (H, W, 1)."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.count = result.passes.astype(np.float64)[..., None]
        self.scale = self.count * np.maximum(self.count - 1.0, 0.0)
        self.coverage = result.coverage.astype(np.float64)[..., None]

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
        error = np.where(self.count > 1.0, error, 0.0)
        return error.astype(np.float64) ** 2 * self.scale


def _merge_light(runs: list[_Run]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return all buffers with bands, and their errors."""
    buffers: dict[str, NDArray[np.float32]] = {}
    errors: dict[str, NDArray[np.float32]] = {}
    present = runs[0].result.buffers
    groups = [name.partition("@")[2] for name in present if name.startswith("direct@")]
    for name in present:
        if name.partition("@")[0] in POOLED:
            buffers[name], errors[name] = _pool(name, runs)
    for name in ("direct", "indirect", "caustics"):
        if groups and name in buffers:
            buffers[name] = _sum([buffers[f"{name}@{group}"] for group in groups])
    buffers["radiance"] = (buffers["emission"] + buffers["direct"]) + buffers["indirect"]
    errors["radiance"] = _pool("radiance", runs)[1]
    for ending in (*(f"@{group}" for group in groups), ""):
        _merge_shading(ending, runs, buffers, errors)
    if groups:
        buffers["shading"] = _sum([buffers[f"shading@{group}"] for group in groups])
    return buffers, errors


def _sum(images: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    total = images[0].copy()
    for image in images[1:]:
        total += image
    return total


def _count(runs: list[_Run]) -> Array:
    """Return the number of all passes, (H, W, 1)."""
    return np.sum([run.count for run in runs], axis=0)


def _mean(values: list[Array], runs: list[_Run]) -> Array:
    """Return the mean over all passes; exactly the value where all values are the same."""
    count = _count(runs)
    total = np.zeros_like(values[0])
    for value, run in zip(values[1:], runs[1:], strict=True):
        total += run.count * (value - values[0])
    return values[0] + total / np.maximum(count, 1.0)


def _error(spread: Array, runs: list[_Run]) -> Array:
    """Return the standard error of the mean over all passes; infinite before the second."""
    count = _count(runs)
    error = np.sqrt(np.maximum(spread, 0.0) / np.maximum(count * (count - 1.0), 1.0))
    return np.where(count > 1.0, error, np.inf)


def _pool(name: str, runs: list[_Run]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the mean and the standard error of a buffer."""
    values = [run.mean(name) for run in runs]
    mean = _mean(values, runs)
    spread = np.zeros_like(mean)
    for run, value in zip(runs, values, strict=True):
        spread += run.spread(name) + run.count * (value - mean) ** 2
    return mean.astype(np.float32), _error(spread, runs).astype(np.float32)


def _merge_blocks(runs: list[_Run]) -> dict[str, NDArray[np.float32]]:
    """Return the standard errors of blocks' means; a block has the least passes of its pixels."""
    counts = [block_minima(run.count) for run in runs]
    nothing = np.zeros(1)
    merged = {}
    for name in dict.fromkeys(name for run in runs for name in run.result.block_errors):
        means = [block_means(run.mean(name)) for run in runs]
        errors = [run.result.block_errors.get(name, nothing) for run in runs]
        merged[name] = pool_errors(counts, means, errors).astype(np.float32)
    return merged


def _merge_shading(
    ending: str, runs: list[_Run], buffers: dict[str, Any], errors: dict[str, Any]
) -> None:
    """Add shading, its error and the covariance: of the whole (""), or of a group ("@sun").

    The ratio of reflected light to reflectance where that is not 0, with the error of a ratio by
    the delta method, as `kernels.moments` has it; the mean irradiance / π elsewhere.
    """
    name = f"shading{ending}"
    buffers[name], errors[name] = _pool(name, runs)
    shadings = [run.mean(name) for run in runs]
    albedos = [run.mean("reflectance") for run in runs]
    reflected = [s * r for s, r in zip(shadings, albedos, strict=True)]
    albedo, light = _mean(albedos, runs), _mean(reflected, runs)
    plain = buffers.get("residual", np.zeros(1)) == 0.0
    whole = buffers[f"direct{ending}"].astype(np.float64) + buffers[f"indirect{ending}"]
    known = buffers["reflectance"] > 0.0
    divisor = np.where(known, buffers["reflectance"], 1.0).astype(np.float64)
    ratio = np.where(plain, whole, light) / divisor
    spread, product = np.zeros_like(ratio), np.zeros_like(ratio)
    for run, s, r, x in zip(runs, shadings, albedos, reflected, strict=True):
        own = run.mean(f"covariance{ending}") * run.scale
        step = ratio - s
        bent = (ratio + s) * run.spread("reflectance") - 2.0 * own
        # Where this run saw no reflectance, its shading is of another kind, and nothing deviates.
        spread += r**2 * run.spread(name) + np.where(r > 0.0, step * bent, 0.0)
        spread += run.count * (step * r) ** 2
        product += own + run.count * (x - light) * (r - albedo)
    buffers[name] = np.where(known, ratio, buffers[name]).astype(np.float32)
    error = (_error(spread, runs) / divisor).astype(np.float32)
    errors[name] = np.where(known, error, errors[name])
    count = _count(runs)
    covariance = (product / np.maximum(count * (count - 1.0), 1.0)).astype(np.float32)
    if covariance.any():
        buffers[f"covariance{ending}"] = covariance


def _check_whole(result: Result, name: str) -> None:
    """Raise InputError if a result lacks what merging takes."""
    if "fingerprint" not in result.record:
        raise InputError(f"{name}: its record tells too little to merge it; render it again")
    missing = [buffer for buffer in BUFFERS if buffer not in (*OPTIONAL, *result.buffers)]
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
            f"render without --buffers to merge"
        )


def _check_alike(first: Result, other: Result, name: str, other_name: str) -> None:
    """Raise InputError if two results are not of the same scene and arguments."""
    prints = [{**result.record["fingerprint"], "seed": None} for result in (first, other)]
    told = difference(*prints)
    sets = [{n for n in r.buffers if not n.startswith("covariance")} for r in (first, other)]
    if not told and sets[0] != sets[1]:
        told = f"{listed(sorted(sets[0] ^ sets[1]))} in one of them alone"
    for buffer in () if told else CENTRES:
        if not np.array_equal(first.buffers[buffer], other.buffers[buffer]):
            told = f"other {buffer}"
    if told:
        raise InputError(f"{other_name} cannot be merged with {name}: {told}")


def _check_seeds(results: list[Result], names: Sequence[str]) -> None:
    """Raise InputError if the same passes would count twice."""
    owner: dict[int, str] = {}
    for result, name in zip(results, names, strict=True):
        for seed in seeds_of(result.record):
            if seed in owner:
                raise InputError(
                    f"{name} and {owner[seed]} both are of seed {seed}, and so of the same passes; "
                    f"render one of them with another seed"
                )
            owner[seed] = name
