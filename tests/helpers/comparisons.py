"""Comparisons in standard errors, and counts against densities."""

import numpy as np
from scipy import stats


def assert_within(values, truth, error, sigmas=4.0, slack=1e-6):
    """Assert that values lie within so many standard errors of the truth."""
    deviation = np.abs(np.asarray(values, float) - truth)
    allowed = sigmas * np.asarray(error, float) + slack * np.abs(truth)
    worst = np.unravel_index(np.argmax(deviation - allowed), deviation.shape)
    assert (deviation <= allowed).all(), (
        f"{np.asarray(values)[worst]} is not {np.broadcast_to(truth, deviation.shape)[worst]} "
        f"± {sigmas} · {np.broadcast_to(error, deviation.shape)[worst]} at {worst}"
    )


def assert_invisible(result, sky):
    """Assert that all that covers whole pixels is as bright as an even sky; return the error."""
    inside = result.coverage == 1.0
    value, error = result.radiance[inside], result.errors["radiance"][inside]
    assert inside.any()
    total = np.sqrt((error**2).sum()) / error.size
    assert abs(value.mean() - sky) < 4.0 * total + 0.003 * sky
    return total


def assert_blocks_agree(one, other, side=4):
    """Assert that two renders agree in blocks of pixels, at 0.1% for all together, within 1%."""
    height, width, bands = one.radiance.shape
    shape = height // side, side, width // side, side, bands
    errors = np.hypot(one.standard_error("radiance"), other.standard_error("radiance"))
    blocks = [image.reshape(shape).mean(axis=(1, 3)) for image in (one.radiance, other.radiance)]
    error = np.sqrt((errors**2).reshape(shape).sum(axis=(1, 3))) / side**2
    z = (blocks[0] - blocks[1]) / np.hypot(error, 0.01 * blocks[1].mean())
    assert np.abs(z).max() < stats.norm.isf(1e-3 / z.size)


def chi_squared(counts, expected):
    """Return the p-value of counts against expected ones, rare cells pooled."""
    keep = expected > 10
    counts = np.append(counts[keep], counts[~keep].sum())
    expected = np.append(expected[keep], expected[~keep].sum())
    keep = expected > 0
    assert counts[~keep].sum() == 0, "samples where the density is 0"
    return stats.chisquare(counts[keep], expected[keep] * counts.sum() / expected.sum()).pvalue
