"""Russian roulette."""

from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.rng import draw


@jit
def russian_roulette(before, after, state, throughput):
    """End a path with the probability of what it lost, and divide what goes on by its own.

    `before` and `after` are the largest values over bands of `throughput`, (N,), before some loss
    and now.

    Returns
    -------
    whether the path goes on, state of the random stream
    """
    if after <= 0.0:
        return False, state
    if after >= before:
        return True, state
    xi, state = draw(state)
    if xi * before >= after:
        return False, state
    divide(throughput, after / before)
    return True, state
