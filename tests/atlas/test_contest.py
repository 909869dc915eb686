"""Who is nearer to the truth: right where it is known, and with the noise that is told."""

from __future__ import annotations

import numpy as np
import pytest

from nephrite.atlas import contest
from nephrite.atlas.compared import Estimate

SHAPE = (48, 64, 3)
MASK = np.ones(SHAPE[:2], bool)
LIGHT = 1.0 + 0.5 * np.sin(np.arange(64.0) / 9.0)[None, :, None] * np.array([1.0, 0.5, 0.2]) + np.zeros(SHAPE)


def noisy(mean, sigma, seed):
    noise = np.random.default_rng(seed).normal(size=SHAPE)
    return Estimate(mean + sigma * noise, np.full(SHAPE, sigma))


def exact(mean):
    return Estimate(mean, np.zeros(SHAPE))


def test_without_noise_it_is_the_difference_of_the_squares():
    found, error = contest.lead(exact(0.9 * LIGHT), exact(1.2 * LIGHT), exact(LIGHT), MASK)
    assert found == pytest.approx(0.2**2 - 0.1**2)
    assert error == 0.0


def test_turned_round_it_changes_its_sign():
    pictures = noisy(0.9 * LIGHT, 0.2, 1), noisy(1.2 * LIGHT, 0.1, 2)
    truth = noisy(LIGHT, 0.3, 3)
    one, other = (contest.lead(*pair, truth, MASK) for pair in (pictures, pictures[::-1]))
    assert one[0] == pytest.approx(-other[0])
    assert one[1] == pytest.approx(other[1])


@pytest.mark.parametrize(("first", "second"), [(0.9, 0.9), (0.9, 1.2), (1.0, 1.05)])
def test_noise_adds_nothing_and_is_foretold(first, second):
    """Over 400 triples: the mean within 4 standard errors (false alarms: 6e-5), the spread within 20 %."""
    found = np.array(
        [
            contest.lead(
                noisy(first * LIGHT, 0.2, 3 * seed), noisy(second * LIGHT, 0.3, 3 * seed + 1),
                noisy(LIGHT, 0.4, 3 * seed + 2), MASK,
            )
            for seed in range(400)
        ]
    )  # fmt: skip
    values, told = found.T
    assert abs(values.mean() - ((second - 1) ** 2 - (first - 1) ** 2)) < 4.0 * values.std() / 20.0
    assert told.mean() == pytest.approx(values.std(), rel=0.2)


def test_models_that_are_alike_differ_by_less_than_the_truths_noise():
    """Two models, both 10 % off and nearly noiseless: their order is known although the truth has 40 % noise."""
    truth = noisy(LIGHT, 0.4, 1)
    pictures = {"tabulated": noisy(0.9 * LIGHT, 0.01, 2), "normalized": noisy(0.895 * LIGHT, 0.01, 3)}
    assert not contest.is_open(pictures, truth, MASK)


def test_an_order_is_open_while_noise_hides_it_and_closed_where_there_is_none():
    truth, equal = exact(LIGHT), noisy(0.9 * LIGHT, 0.3, 1)
    assert contest.is_open({"tabulated": equal, "photon_beam": noisy(0.9 * LIGHT, 0.3, 2)}, truth, MASK)
    assert not contest.is_open({"tabulated": equal, "dipole": equal}, truth, MASK)
    assert not contest.is_open({"photon_beam": equal, "normalized": equal}, truth, MASK)
    assert not contest.is_open({"tabulated": equal, "photon_beam": exact(2.0 * LIGHT)}, truth, MASK)
