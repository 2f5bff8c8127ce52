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


def chi_squared(counts, expected):
    """Return the p-value of counts against expected ones, rare cells pooled."""
    keep = expected > 10
    counts = np.append(counts[keep], counts[~keep].sum())
    expected = np.append(expected[keep], expected[~keep].sum())
    keep = expected > 0
    assert counts[~keep].sum() == 0, "samples where the density is 0"
    return stats.chisquare(counts[keep], expected[keep] * counts.sum() / expected.sum()).pvalue
