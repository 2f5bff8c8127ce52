"""The sky as a map: which texel a direction meets, and directions drawn in proportion to light.

The map is constant over each texel, so both are exact. Row 0 surrounds +y; at a turn of 0 the
centre column looks along -z, and columns to its right turn towards +x.

Towards a surface, directions are drawn by radiance times cosine: first a block of texels, by the
irradiance that it gives to normals near the surface's own, then a texel of the block, by its light.
Samples are lost below the horizon only in blocks that the horizon crosses.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit

BLOCK_ROWS, BLOCK_COLUMNS = 16, 32  # Blocks of a map, which has as many texels at least
STEPS = 7  # Cells of normals along each edge of a cube around the origin, for its faces
ALL_AROUND = 6 * STEPS * STEPS  # In place of a cell of normals: for light from everywhere


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
def _step_of(coordinate, along):
    return min(int((coordinate / along + 1.0) * 0.5 * STEPS), STEPS - 1)


@jit
def cell_of_normal(normal):
    """Return the cell of a normal: of the cube's face that it goes through, and there of a grid.

    Faces are +x, -x, +y, -y, +z and -z; rows and columns follow the two axes after the face's own.
    """
    x, y, z = normal
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        face, along, first, second = 0, x, y, z
    elif abs(y) >= abs(z):
        face, along, first, second = 2, y, z, x
    else:
        face, along, first, second = 4, z, x, y
    if along < 0.0:
        face += 1
    along = abs(along)
    return (face * STEPS + _step_of(first, along)) * STEPS + _step_of(second, along)


@jit
def _first_of(block, blocks, count):
    """Return the first of `count` rows or columns of texels in a row or column of blocks."""
    return (block * count + blocks - 1) // blocks


@jit
def _rows_of(environment, i, j):
    """Return (CDF of the rows of a block, number of the first)."""
    count = environment.columns.shape[0]
    first = _first_of(i, BLOCK_ROWS, count)
    return environment.rows[j, first : _first_of(i + 1, BLOCK_ROWS, count)], first


@jit
def _columns_of(environment, row, j):
    """Return (CDF of a row's columns within a column of blocks, number of the first)."""
    count = environment.columns.shape[1]
    first = _first_of(j, BLOCK_COLUMNS, count)
    return environment.columns[row, first : _first_of(j + 1, BLOCK_COLUMNS, count)], first


@jit
def _density(environment, cell, block, texel):
    """Return the density (per steradian) on a texel, (row, column), of a block, (row, column)."""
    (i, j), (row, column) = block, texel
    of_rows, first_row = _rows_of(environment, i, j)
    of_columns, first_column = _columns_of(environment, row, j)
    probability = (
        warp.discrete_pdf(environment.block_rows[cell], i)
        * warp.discrete_pdf(environment.block_columns[cell, i], j)
        * warp.discrete_pdf(of_rows, row - first_row)
        * warp.discrete_pdf(of_columns, column - first_column)
    )
    band = environment.cosines[row] - environment.cosines[row + 1]
    return probability * environment.columns.shape[1] / (2.0 * math.pi * band)


@jit
def environment_pdf(environment, cell, texel):
    """Return the density (per steradian) of `sample_environment` on a texel."""
    row, column = int(texel[0]), int(texel[1])
    rows, columns = environment.columns.shape
    block = row * BLOCK_ROWS // rows, column * BLOCK_COLUMNS // columns
    return _density(environment, cell, block, (row, column))


@jit
def sample_environment(environment, cell, u, v):
    """Return (direction, texel, density): a texel by its light, uniform over its solid angle.

    `cell` is that of the normal of a surface, from `cell_of_normal`, or ALL_AROUND. The density is
    0 where no light comes from.
    """
    i, u = warp.discrete(environment.block_rows[cell], u)
    j, v = warp.discrete(environment.block_columns[cell, i], v)
    of_rows, first_row = _rows_of(environment, i, j)
    row, u = warp.discrete(of_rows, u)
    row += first_row
    of_columns, first_column = _columns_of(environment, row, j)
    column, v = warp.discrete(of_columns, v)
    column += first_column
    y = (1.0 - u) * environment.cosines[row] + u * environment.cosines[row + 1]
    turn = (column + v) / environment.columns.shape[1] - environment.rotation
    r, (cosine, sine) = math.sqrt(max(0.0, 1.0 - y * y)), warp.cos_sin_2pi(turn + 1.5)
    density = _density(environment, cell, (i, j), (row, column))
    return (r * sine, y, -r * cosine), (float(row), float(column)), density
