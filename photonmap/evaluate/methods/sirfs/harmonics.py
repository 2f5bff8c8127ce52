"""Real spherical harmonics of unit normals up to order 2, without their constants.

As polynomials of R. Ramamoorthi and P. Hanrahan, "An efficient representation for irradiance
environment maps", SIGGRAPH 2001. The constants would only scale the coefficients of light, whose
prior is learnt.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.metrics.arrays import Floats

COUNT = 9


def harmonics(normals: Floats) -> Floats:
    """Return (P, 9) for normals (P, 3)."""
    x, y, z = normals.T
    rows = [np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3.0 * z * z - 1.0]
    return np.stack(rows, axis=1)


def by_normals(normals: Floats, by_harmonics: Floats) -> Floats:
    """Return the gradient by normals (P, 3) of what has a gradient by harmonics (P, 9)."""
    x, y, z = normals.T
    g = by_harmonics.T
    return np.stack(
        [
            g[1] + y * g[4] + z * g[5] + 2.0 * x * g[7],
            g[2] + x * g[4] + z * g[6] - 2.0 * y * g[7],
            g[3] + x * g[5] + y * g[6] + 6.0 * z * g[8],
        ],
        axis=1,
    )
