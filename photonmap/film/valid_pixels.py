"""Which pixels errors are stated over."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


def valid_pixels(coverage: NDArray[Any], emission: NDArray[Any], unresolved: Mask) -> Mask:
    """Return whether surfaces cover a pixel wholly, none of them emits, and it is resolved.

    The one definition of valid pixels; `photonmap.kernels.film.moments.is_valid` is its kernel.

    Parameters
    ----------
    coverage : (...) fraction of each pixel that shows a surface
    emission : (..., N), in any unit
    unresolved : (...) no photon was found for indirect light, although some were stored
    """
    return (coverage == 1.0) & ~emission.any(axis=-1) & ~unresolved
