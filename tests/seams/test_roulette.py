"""Russian roulette ends paths without a bias."""

import numpy as np
import pytest
from helpers.comparisons import assert_within

from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.rng import russian_roulette

GAMES = 100_000
SIGMAS = 5.0
"""Allowed standard errors: one in 1.7 million is beyond."""


@kernel
def _play(before, after, left, alive, same):
    for game in range(len(left)):
        state = rng.stream(3, 0, game)
        goes_on, next_state = russian_roulette(before, after, state, left[game])
        alive[game] = goes_on
        same[game] = next_state == state


def play(before, after, throughput):
    """Return each game's throughput, 0 where it was lost, and whether it drew a number."""
    left = np.tile(np.array(throughput, np.float32), (GAMES, 1))
    alive, same = np.empty((2, GAMES), np.bool_)
    _play(np.float32(before), np.float32(after), left, alive, same)
    left[~alive] = 0.0
    return left.astype(float), alive, ~same


@pytest.mark.parametrize(
    ("before", "after"), [(1.0, 0.5), (1.0, 0.999), (1.0, 1e-3), (8.0, 2.0), (1e-6, 3e-7)]
)
def test_the_mean_is_kept(before, after):
    """A path goes on with probability after / before, and its throughput is divided by that."""
    throughput = np.array([after, 0.3 * after, 0.0], np.float32)
    left, alive, drew = play(before, after, throughput)
    survival = after / before
    error = np.sqrt(survival * (1.0 - survival) / GAMES)
    assert abs(alive.mean() - survival) <= SIGMAS * error
    assert_within(left.mean(axis=0), throughput, throughput / survival * error, SIGMAS, 1e-5)
    np.testing.assert_allclose(left[alive].max(axis=1), before, rtol=1e-5)
    assert drew.all()


@pytest.mark.parametrize(("before", "after"), [(1.0, 1.0), (0.5, 0.75), (0.0, 0.1)])
def test_what_lost_nothing_goes_on_as_it_is(before, after):
    """No random number is drawn where the outcome is certain."""
    left, alive, drew = play(before, after, [after, 0.05])
    assert alive.all()
    assert not drew.any()
    np.testing.assert_array_equal(left, np.broadcast_to(np.float32([after, 0.05]), left.shape))


@pytest.mark.parametrize("before", [0.0, 1.0])
def test_what_has_nothing_left_ends(before):
    _, alive, drew = play(before, 0.0, [0.0, 0.0])
    assert not alive.any()
    assert not drew.any()


@kernel
def _play_on(rounds, left, alive):
    for game in range(len(left)):
        state = rng.stream(4, 0, game)
        for _ in range(rounds):
            before = left[game, 0]
            left[game, 0] *= np.float32(0.5)
            alive[game], state = russian_roulette(before, left[game, 0], state, left[game])
            if not alive[game]:
                break


def test_successive_games_keep_the_mean():
    """After six losses of a half 1 path in 64 goes on, with all that it began with."""
    left, alive = np.ones((GAMES, 1), np.float32), np.empty(GAMES, np.bool_)
    _play_on(6, left, alive)
    assert (left[alive] == 1.0).all()
    error = np.sqrt(2.0**-6 / GAMES)
    assert abs(alive.mean() - 2.0**-6) <= SIGMAS * error
