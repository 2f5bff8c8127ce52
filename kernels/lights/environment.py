"""The sky as a map: which texel a direction meets, and directions drawn in proportion to light.

The map is constant over each texel, so both are exact. Row 0 surrounds +y; at a turn of 0 the
centre column looks along -z, and columns to its right turn towards +x.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit


@jit
def texel_at(environment, direction):
    """Return (row, column), as floats, of the texel that a direction of any length looks at."""
    rows, columns = environment.columns.shape
    x, y, z = direction
    height = math.atan2(math.sqrt(x * x + z * z), y) / math.pi
    turn = 0.5 + math.atan2(x, -z) / (2.0 * math.pi) + environment.rotation
    turn -= math.floor(turn)
    row, column = min(int(height * rows), rows - 1), min(int(turn * columns), columns - 1)
    return float(row), float(column)


@jit
def radiance_of(environment, texel):
    """Return what a texel holds, (3,), as in `Environment`."""
    return vec.row(environment.texels[int(texel[0])], int(texel[1]))


@jit
def environment_pdf(environment, texel):
    """Return the density (per steradian) of `sample_environment` on a texel."""
    row, column = int(texel[0]), int(texel[1])
    probability = warp.discrete_pdf(environment.rows, row)
    probability *= warp.discrete_pdf(environment.columns[row], column)
    band = environment.cosines[row] - environment.cosines[row + 1]
    return probability * environment.columns.shape[1] / (2.0 * math.pi * band)


@jit
def sample_environment(environment, u, v):
    """Return (direction, texel): a texel by its light, uniform over its solid angle."""
    row, u = warp.discrete(environment.rows, u)
    column, v = warp.discrete(environment.columns[row], v)
    y = (1.0 - u) * environment.cosines[row] + u * environment.cosines[row + 1]
    turn = (column + v) / environment.columns.shape[1] - 0.5 - environment.rotation
    r, phi = math.sqrt(max(0.0, 1.0 - y * y)), 2.0 * math.pi * turn
    direction = (r * math.sin(phi), y, -r * math.cos(phi))
    return direction, (float(row), float(column))
