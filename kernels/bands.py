"""Band by band: rows of arrays whose last axis is N bands."""

import numpy as np

from photonmap.kernels.jit import jit


@jit
def add_row(target, i, source, j, factor):
    """Add factor · row j of source to row i of target, band by band."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * source[j, band]


@jit
def add_product(target, i, source, j, throughput, factor):
    """Add factor · throughput · row j of source to row i of target, band by band."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * throughput[band] * source[j, band]


@jit
def add_mix(target, i, weights, basis, factor):
    """Add factor · weights (three numbers) @ basis, (3, N), to row i of target."""
    for band in range(target.shape[1]):
        target[i, band] += np.float32(factor * mix(weights, basis, band))


@jit
def add_mix_product(target, i, weights, basis, throughput, factor):
    """Add factor · throughput · (weights @ basis) to row i of target."""
    for band in range(target.shape[1]):
        target[i, band] += throughput[band] * np.float32(factor * mix(weights, basis, band))


@jit
def mix(weights, basis, band):
    """Return weights (three numbers) @ basis, (3, N), in one band."""
    a, b, c = weights
    return a * basis[0, band] + b * basis[1, band] + c * basis[2, band]


@jit
def clear(target):
    """Set all rows of target to 0."""
    for row in range(target.shape[0]):
        for band in range(target.shape[1]):
            target[row, band] = 0.0


@jit
def total(source, i):
    """Return the sum of row i over bands."""
    result = np.float32(0.0)
    for band in range(source.shape[1]):
        result += source[i, band]
    return result


@jit
def attenuate(throughput, source, j, factor):
    """Multiply throughput, (N,), by factor · row j of source; return its largest, (old, new)."""
    factor = np.float32(factor)
    before = after = np.float32(0.0)
    for band in range(len(throughput)):
        before = max(before, throughput[band])
        throughput[band] *= source[j, band] * factor
        after = max(after, throughput[band])
    return before, after


@jit
def divide(throughput, divisor):
    """Divide throughput, (N,), by a number in place."""
    for band in range(len(throughput)):
        throughput[band] /= divisor
