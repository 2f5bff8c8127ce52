"""The sky as a map: which texel a direction meets, and directions drawn in proportion to light.

The map is constant over each texel, so both are exact. Row 0 surrounds +y; at a turn of 0 the
centre column looks along -z, and columns to its right turn towards +x.
"""

import math

from photonmap.kernels import vec, warp
from photonmap.kernels.jit import jit


@jit
def texel_at(environment, direction):
    """Return (row, column) of the texel that a direction, of any length, looks at."""
    rows, columns = environment.columns.shape
    x, y, z = direction
    height = math.atan2(math.sqrt(x * x + z * z), y) / math.pi
    turn = 0.5 + math.atan2(x, -z) / (2.0 * math.pi) + environment.turn
    turn -= math.floor(turn)
    return min(int(height * rows), rows - 1), min(int(turn * columns), columns - 1)


@jit
def radiance_at(environment, direction):
    """Return the linear RGB that a direction looks at."""
    row, column = texel_at(environment, direction)
    return vec.row(environment.texels[row], column)


@jit
def _texel_pdf(environment, row, column):
    chance = warp.discrete_pdf(environment.rows, row)
    chance *= warp.discrete_pdf(environment.columns[row], column)
    band = environment.cosines[row] - environment.cosines[row + 1]
    return chance * environment.columns.shape[1] / (2.0 * math.pi * band)


@jit
def environment_pdf(environment, direction):
    """Return the density (per steradian) of `sample_environment`."""
    row, column = texel_at(environment, direction)
    return _texel_pdf(environment, row, column)


@jit
def sample_environment(environment, u, v):
    """Return (direction, density): a texel by its light, uniform over its solid angle."""
    row, u = warp.discrete(environment.rows, u)
    column, v = warp.discrete(environment.columns[row], v)
    y = (1.0 - u) * environment.cosines[row] + u * environment.cosines[row + 1]
    turn = (column + v) / environment.columns.shape[1] - 0.5 - environment.turn
    r, phi = math.sqrt(max(0.0, 1.0 - y * y)), 2.0 * math.pi * turn
    direction = (r * math.sin(phi), y, -r * math.cos(phi))
    return direction, _texel_pdf(environment, row, column)
