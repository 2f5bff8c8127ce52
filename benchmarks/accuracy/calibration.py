"""How often the errors that a render states hold, on pixels of each kind."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy import stats

import photonmap as pm
from benchmarks.harness.table import Cell
from photonmap.film.blocks import block_means
from photonmap.film.relative_error import relative_squares
from photonmap.integrators import sampling_plan
from photonmap.kernels.core.passes import Prepass

KINDS = ("flat", "penumbrae", "edges")
"""Of pixels, by what the sampling pre-pass finds: those of one smooth piece of surface, away from
penumbrae and in them or beside them; all others, among them mirrors and glass."""
BUFFERS = ("radiance", "direct", "indirect")
COLUMNS = [
    *(f"{name}: {', '.join(KINDS)}, %" for name in BUFFERS),
    f"of 10 000 beyond 5: {', '.join(BUFFERS)}",
    "measured / stated error",
    "worst 4×4 block of indirect light",
]
LEAST = 100
"""Values of which a share is stated."""
SIDE = 4
ROUNDING = 4.0 * 2.0**-23
"""Relative error of sums in float32, below which no standard error counts."""

Kinds = dict[str, NDArray[np.bool_]]
"""(H, W) each, by `KINDS`"""


@contextmanager
def watched_prepass() -> Iterator[list[Prepass]]:
    """Give the pre-passes of renders within the block, as they end."""
    found: list[Prepass] = []
    run = sampling_plan.run_prepass

    def watch(*arguments: Any) -> None:
        run(*arguments)
        found.extend(each for each in arguments if isinstance(each, Prepass))

    with patch.object(sampling_plan, "run_prepass", watch):
        yield found


def pixel_kinds(prepass: Prepass, size: tuple[int, int]) -> Kinds:
    """Return which pixels of an image of a width and height are of which kind."""
    flat, penumbra, specular = (
        np.reshape(part, size[::-1]) != 0
        for part in (prepass.flat, prepass.penumbra, prepass.specular)
    )
    around = np.lib.stride_tricks.sliding_window_view(np.pad(penumbra, 1), (3, 3)).any(axis=(2, 3))
    smooth = flat & ~specular
    masks = smooth & ~around, smooth & around, ~smooth
    return dict(zip(KINDS, masks, strict=True))


def calibration(
    result: pm.Result, truth: pm.Result, valid: NDArray[np.bool_], kinds: Kinds
) -> list[Cell]:
    """Return the cells of `COLUMNS`: how far a result is from that of many more passes.

    Intervals are of Student's t, and of the errors of both.
    """
    held: list[Cell] = []
    beyond = []
    for name in BUFFERS:
        apart, error, freedom = differences(result, truth, name)
        within = apart <= stats.t.ppf(0.975, freedom) * error
        counts = (error > 0.0) & valid[..., None]
        shares = [_share(within, counts & kinds[kind][..., None]) for kind in KINDS]
        held.append(
            " / ".join("-" if share is None else f"{100.0 * share:.1f}" for share in shares)
        )
        beyond.append(f"{1e4 * (_share(apart > 5.0 * error, counts) or 0.0):.2g}")
    return [
        *held,
        " / ".join(beyond),
        _measured(result, truth, valid),
        _worst(result, truth, valid),
    ]


def _share(those: NDArray[np.bool_], among: NDArray[np.bool_]) -> float | None:
    """Return which share of some values are among others; None of too few to tell."""
    return float(those[among].mean()) if among.sum() >= LEAST else None


def differences(
    result: pm.Result, truth: pm.Result, name: str
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return |difference| of a buffer, its standard error, and that one's degrees of freedom.

    (H, W, N) each; those of the error are by Welch and Satterthwaite.
    """
    value, other = (each.buffers[name].astype(float) for each in (result, truth))
    squares = [each.standard_error(name).astype(float) ** 2 for each in (result, truth)]
    degrees = [each.degrees_of_freedom(name)[..., None] for each in (result, truth)]
    total = squares[0] + squares[1]
    parts = squares[0] ** 2 / degrees[0] + squares[1] ** 2 / degrees[1]
    freedom = np.divide(total**2, parts, where=parts > 0.0, out=np.ones(total.shape))
    return np.abs(value - other), np.maximum(np.sqrt(total), ROUNDING * np.abs(other)), freedom


def _measured(result: pm.Result, truth: pm.Result, valid: NDArray[np.bool_]) -> float:
    """Return the root of the mean squared error of radiance over that which is stated."""
    apart, error, _ = differences(result, truth, "radiance")
    values = truth.radiance[valid].astype(float)
    measured, stated = (
        relative_squares(each[valid] ** 2, values).mean() for each in (apart, error)
    )
    return float(np.sqrt(measured / stated))


def _worst(result: pm.Result, truth: pm.Result, valid: NDArray[np.bool_]) -> str:
    """Return how far the block is off that exceeds its errors most, of blocks of valid pixels.

    Pixels of a block share light: its error is taken as the mean of theirs, as if they erred alike.
    """
    apart = block_means(result.indirect - truth.indirect, SIDE).mean(axis=2)
    mean = block_means(truth.indirect, SIDE).mean(axis=2)
    error = block_means(differences(result, truth, "indirect")[1], SIDE).mean(axis=2)
    whole = (block_means(valid.astype(float), SIDE) == 1.0) & (mean > 0.0)
    if not whole.any():
        return "-"
    far = np.where(whole, np.abs(apart) / np.maximum(error, 1e-30), 0.0)
    worst = np.unravel_index(np.argmax(far), far.shape)
    return f"{apart[worst] / mean[worst]:+.1%}, {far[worst]:.1f} σ"
