"""Band by band: rows of arrays whose last axis is N bands."""

import numpy as np

from photonmap.kernels.core.jit import jit


@jit
def add_product(target, i, source, j, throughput, factor):
    """Add factor · throughput · row j of source to row i of target, band by band."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * throughput[band] * source[j, band]


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
def divide(throughput, divisor):
    """Divide throughput, (N,), by a number in place."""
    for band in range(len(throughput)):
        throughput[band] /= divisor


@jit
def largest(throughput):
    """Return the largest value over bands."""
    most = throughput[0]
    for band in range(1, len(throughput)):
        most = max(most, throughput[band])
    return most


@jit
def copy(source, target):
    """Copy source, (N,), to target."""
    for band in range(len(target)):
        target[band] = source[band]
