"""The reference image of the Cornell box, and errors against it.

The file holds, for 256×256 box pixels in linear RGB: full, half0 and half1 (two independent
halves of full), direct, indirect, and mask (pixels without emission). `make_reference` makes it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.film.relative_error import squared_norm

SIZE = (256, 256)


class Truth:
    """A reference image; `reason` says why there is none."""

    reason = ""

    def __init__(self, path: Path) -> None:
        if not path.exists():
            self.reason = (
                f"no reference at {path}: python -m benchmarks.accuracy.make_reference makes one"
            )
            return
        with np.load(path) as file:
            self._images = {name: file[name] for name in file.files}
        self._mask = self._images["mask"]
        full = self._images["full"][self._mask].astype(np.float64)
        self._norm = squared_norm(full)

    def relative_mse(self, image: NDArray[Any]) -> float:
        """Return mean((I − R)² / (R² + 0.01 m²)) over bands and pixels without emission.

        The square is (I − half0)(I − half1), which the noise of the reference does not bias.
        """
        first, second = (
            image[self._mask].astype(np.float64) - self._images[half][self._mask]
            for half in ("half0", "half1")
        )
        return float((first * second / self._norm).mean())

    def energy(self, name: str, image: NDArray[Any]) -> tuple[float, NDArray[np.float64]]:
        """Return the relative difference of an image's mean, over all bands and per band.

        `name` is "full", "direct" or "indirect"; pixels with emission are left out.
        """
        truth = self._images[name][self._mask].mean(axis=0, dtype=np.float64)
        found = image[self._mask].mean(axis=0, dtype=np.float64)
        return float(found.mean() / truth.mean() - 1.0), found / truth - 1.0
