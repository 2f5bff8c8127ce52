"""Statistics of means over passes, in plain Python: for kernels and for NumPy's arrays alike.

A spread is a sum of squared deviations from a mean, a co-moment a sum of products of the
deviations of two quantities from their means.
"""


def welford_step(value, mean, weight):
    """Take one value more into a mean, with weight 1 / count (Welford 1962).

    Returns the new mean, what its spread gains, and the deviation from the old mean.
    """
    deviation = value - mean
    new_mean = mean + deviation * weight
    return new_mean, deviation * (value - new_mean), deviation


def shift_ratio(spread, comoment, denominator_spread, old, new):
    """Return the spread of x − new·y from that of x − old·y: the delta method.

    To first order, the ratio ρ of the means of x and y has the error of the mean of x − ρ y over
    the mean of y. So `old` is 0 where the spread is that of x itself. With an earlier ratio as
    `old`, an error known about it moves to another, without the cancellation of going through x.

    Parameters
    ----------
    spread : of x − old·y
    comoment : of x and y
    denominator_spread : of y
    """
    step = new - old
    return spread - 2.0 * step * comoment + step * (new + old) * denominator_spread
