"""Empty estimates of a pass, for tests to fill."""

import numpy as np

from photonmap.kernels.core.passes import Pixels


def empty_pixels(size, bands):
    """Pixels of which nothing was estimated."""
    return Pixels(
        *np.zeros((6, size, bands), np.float32),
        coverage=np.zeros(size, np.float32),
        lookups=np.zeros(size, np.uint8),
        plane=np.zeros((size, 7), np.float32),
    )
