"""The limit of light between surfaces: exact for few modes, near it where one of them decays slowly."""

import numpy as np
import pytest

from nephrite.transport.limit import limit

MODES = np.array([0.95, 0.6, 0.3, 0.1])


def _rounds(count, modes):
    """Return `count` rounds of what decays by `modes` in a turned space, from light of one kind, and their limit."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(len(modes),) * 2))[0]
    operator = turn @ np.diag(modes) @ turn.T
    light = np.ones(len(modes))
    rounds = [light]
    for _ in range(count - 1):
        rounds.append(light + operator @ rounds[-1])
    exact = np.linalg.solve(np.eye(len(modes)) - operator, light)
    return [one.reshape(-1, 2, 1).astype(np.float32) for one in rounds], exact


def test_it_is_exact_once_there_is_a_round_for_each_mode():
    rounds, exact = _rounds(len(MODES) + 2, MODES)
    assert limit(rounds).ravel() == pytest.approx(exact, rel=2e-3)
    assert np.abs(rounds[-1].ravel() / exact - 1).max() > 0.3  # what the rounds alone come to


def test_slow_light_in_one_place_is_found_among_much_that_is_fast():
    """In gaps, a tenth of all places, .8 goes on each time: after four rounds a third of their light is missing."""
    modes = np.concatenate([np.linspace(0.0, 0.35, 180), np.full(20, 0.8)])
    rounds = [np.ones((200, 1, 1))]
    for _ in range(4):
        rounds.append(1.0 + modes.reshape(-1, 1, 1) * rounds[-1])
    error, before = (np.abs(x.ravel() * (1 - modes) - 1) for x in (limit(rounds), rounds[-1]))
    print(error.max(), error[:180].max(), before.max())
    assert before.max() > 0.3
    assert error.max() < 0.02


def test_channels_are_their_own_and_a_black_one_stays_black():
    rounds, exact = _rounds(6, MODES)
    both = [np.concatenate([one, 0 * one], axis=-1) for one in rounds]
    found = limit(both)
    assert found[..., 0].ravel() == pytest.approx(exact, rel=2e-3)
    assert np.all(found[..., 1] == 0)


def test_what_has_arrived_stays():
    light = np.ones((5, 4, 3))
    np.testing.assert_array_equal(limit([light, light, light]), light)
