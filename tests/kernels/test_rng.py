"""Streams are uniform and independent; Sobol points are stratified, scrambled and unbiased."""

import numpy as np
import pytest
from scipy import stats

from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel


@kernel
def fill(seed, item, out):
    state = rng.stream(seed, 0, item)
    for i in range(len(out)):
        out[i], state = rng.draw(state)


@kernel
def fill_sobol(key, first, out):
    for i in range(len(out)):
        out[i, 0], out[i, 1] = rng.sobol_2d(np.uint64(first + i), key)


@kernel
def fill_block(key, first, out):
    rng.sobol_block(np.uint64(first), key, out)


def draws(seed, item, n=100_000):
    out = np.zeros(n)
    fill(seed, item, out)
    return out


def test_streams_are_uniform():
    values = draws(1, 2)
    assert values.min() >= 0.0
    assert values.max() < 1.0
    assert stats.kstest(values, "uniform").pvalue > 1e-4


@pytest.mark.parametrize("other", [(1, 3), (2, 2), (2**63 - 1, 2)])
def test_streams_are_independent(other):
    pairs = np.histogram2d(draws(1, 2), draws(*other), 16)[0]
    assert stats.chisquare(pairs.ravel()).pvalue > 1e-4


@pytest.mark.parametrize("key", [0, 1, 2**64 - 1, 0x123456789ABCDEF])
def test_every_aligned_block_is_stratified(key):
    out = np.zeros((1024, 2))
    fill_sobol(np.uint64(key), 0, out)
    assert (out >= 0).all()
    assert (out < 1).all()
    for power in (2, 4, 6, 10):
        size = 1 << power
        for block in out.reshape(-1, size, 2):
            for x_bits in range(power + 1):
                x = (block[:, 0] * 2**x_bits).astype(int)
                y = (block[:, 1] * 2 ** (power - x_bits)).astype(int)
                assert len(np.unique(x * size + y)) == size


@pytest.mark.parametrize("first", [0, 8, 13, 2**32 - 8])
def test_a_block_holds_the_points_one_by_one(first):
    key = np.uint64(2**64 - 12345)
    block, points = np.zeros((2, 8)), np.zeros((8, 2))
    fill_block(key, first, block)
    fill_sobol(key, first, points)
    np.testing.assert_array_equal(block.T, points)


def test_scrambles_are_uniform_and_independent():
    points = np.zeros((20_000, 1, 2))
    for key, point in enumerate(points):
        fill_sobol(np.uint64(key), 5, point)
    x, y = points[:, 0, 0], points[:, 0, 1]
    assert stats.kstest(x, "uniform").pvalue > 1e-4
    assert stats.kstest(y, "uniform").pvalue > 1e-4
    cells = np.histogram2d(x, y, 10, [[0, 1], [0, 1]])[0]
    assert stats.chisquare(cells.ravel()).pvalue > 1e-4


def test_reverse_bits():
    assert int(rng.reverse_bits(np.uint64(1))) == 1 << 31
    assert int(rng.reverse_bits(np.uint64(0xF0000001))) == 0x8000000F
