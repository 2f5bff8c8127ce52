"""Two-level Monte Carlo: the radiosity cache as a control variate of paths.

Where the cache answers C for a surface, and a path that goes on from there would estimate P, the
light is estimated by

    C                   with probability 1 − p,
    C + (P − C) / p     with probability p.

Its mean is that of P, whatever the cache holds: Russian roulette that ends at a good guess, not at
0 (Heinrich 2001, "Multilevel Monte Carlo methods"). The path that goes on looks nothing up again:
one level more would multiply the variance by albedo² / p, which may be above 1.
"""

from photonmap.kernels.core.bands import add_product, divide
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import INDIRECT
from photonmap.kernels.core.rng import draw


@jit
def goes_on_from(cache, followed, cell, state, scratch):
    """Return whether a path goes on from a cell whose C was added, and the random state.

    With p = `followed`, throughput T becomes T / p where it does, and C · T / p is taken from row
    INDIRECT. It never does if `followed` is None.
    """
    if followed is None:
        return False, state
    xi, state = draw(state)
    if xi >= followed:
        return False, state
    divide(scratch.throughput, followed)
    add_product(scratch.irradiance, INDIRECT, cache.radiosity, cell, scratch.throughput, -1.0)
    return True, state
