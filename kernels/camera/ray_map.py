"""Ray maps: a ray for each pixel, and any camera's rays at its pixels' centres."""

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import Ray


@jit
def _between(table, row, column, fractions, first):
    """Return three values of a table from `first` on, interpolated between four pixels."""
    s, t = fractions
    found = (0.0, 0.0, 0.0)
    for i in range(2):
        for j in range(2):
            weight = (t if i else 1.0 - t) * (s if j else 1.0 - s)
            if weight != 0.0:
                at, beside = row + i, column + j
                x, y = table[at, beside, first], table[at, beside, first + 1]
                part = x, y, table[at, beside, first + 2]
                found = vec.add(found, vec.scale(part, weight))
    return found


@jit
def mapped_ray(camera, x, y):
    """Return a ray between those of the nearest pixels' centres; at a centre, its own.

    Beyond the outermost centres, rays go on as they do between the last two.
    """
    table = camera.optics.projection.table
    rows, columns = table.shape[0], table.shape[1]
    x, y = x - 0.5, y - 0.5
    column = max(min(int(x), columns - 2), 0)
    row = max(min(int(y), rows - 2), 0)
    s = x - column if columns > 1 else 0.0
    t = y - row if rows > 1 else 0.0
    fractions = (s, t)
    return Ray(
        _between(table, row, column, fractions, 0), _between(table, row, column, fractions, 3)
    )
