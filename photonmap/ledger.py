"""The moments of a render: of the whole image, and of each group of lights where they are split."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.accumulate import Accumulator, Buffers
from photonmap.blocks import BlockMoments
from photonmap.columns import Columns, split_pixels
from photonmap.kernels.records import Film, Pixels
from photonmap.workers import Workers

OF_GROUPS = ("direct", "indirect", "caustics", "shading", "covariance")
"""Buffers that are split by groups of lights."""


class Ledger:
    """Takes in passes one by one.

    Parameters
    ----------
    columns : what the passes carry
    film : the image
    workers : that share the work
    smooth : the scene has smooth surfaces
    """

    def __init__(self, columns: Columns, film: Film, workers: Workers, smooth: bool) -> None:
        self._columns, size = columns, film.width * film.height
        self.whole = Accumulator(size, columns.distinct, workers, smooth, columns.weights)
        self._blocks = BlockMoments(film, columns.distinct, smooth)
        split = columns.groups != ("",)
        self._groups = {
            group: Accumulator(size, columns.distinct, workers, smooth)
            for group in (columns.groups if split else ())
        }

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> None:
        """Take in one complete pass, and what it saw in smooth surfaces."""
        columns = self._columns
        for index, accumulator in enumerate(self._groups.values()):
            part = None if seen is None else columns.of_group(seen, index)
            accumulator.add(split_pixels(columns, pixels, index), part)
        whole = split_pixels(columns, pixels), None if seen is None else columns.whole(seen)
        self.whole.add(*whole)
        self._blocks.add(*whole)

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind but their number, by name: the arrays themselves."""
        accumulators = enumerate((self.whole, *self._groups.values()))
        return self._blocks.arrays | {
            f"{index} {name}": array
            for index, accumulator in accumulators
            for name, array in accumulator.arrays.items()
        }

    def resume(self, count: int) -> None:
        """Go on after `count` passes, those that `arrays` were filled with."""
        self._blocks.count = count
        for accumulator in (self.whole, *self._groups.values()):
            accumulator.count = count

    def finish(self, scale: float) -> tuple[Buffers, Buffers]:
        """Return all buffers and their standard errors, as `Accumulator.finish`, in all bands.

        Those of groups are named as in "direct@sun". Where lights are split, buffers of the whole
        are the sums of theirs, in their order. A covariance that is 0 everywhere is left out.
        """
        buffers, errors = self.whole.finish(scale)
        for index, (group, accumulator) in enumerate(self._groups.items()):
            parts, spreads = accumulator.finish(scale)
            for name in OF_GROUPS:
                if name in parts:
                    buffers[name] = parts[name] if index == 0 else buffers[name] + parts[name]
                    buffers[f"{name}@{group}"] = parts[name]
                if name in spreads:
                    errors[f"{name}@{group}"] = spreads[name]
        if self._groups:
            buffers["radiance"] = (buffers["emission"] + buffers["direct"]) + buffers["indirect"]
        for name in [name for name in buffers if name.startswith("covariance")]:
            if not buffers[name].any():
                del buffers[name]
        return self._expand(buffers), self._expand(errors)

    def block_errors(self, scale: float) -> Buffers:
        """Return the standard errors of blocks' means of the whole, in all bands."""
        return {
            name: error[..., self._columns.of_band].astype(np.float32)
            for name, error in self._blocks.finish(scale).items()
        }

    def _expand(self, images: Buffers) -> Buffers:
        return {
            name: self._columns.expand(image) if image.ndim == 2 else image
            for name, image in images.items()
        }
