"""Errors of pictures: right where they are known, and without the noise's share."""

from __future__ import annotations

import numpy as np
import pytest

from nephrite.atlas.compared import Difference, Estimate, block_map, difference

SHAPE = (48, 64, 3)
MASK = np.zeros(SHAPE[:2], bool)
MASK[4:44, 8:60] = True
LIGHT = 1.0 + 0.5 * np.sin(np.arange(64.0) / 9.0)[None, :, None] * np.array([1.0, 0.5, 0.2]) + np.zeros(SHAPE)


def noisy(mean, sigma, seed):
    noise = np.random.default_rng(seed).normal(size=SHAPE)
    return Estimate(mean + sigma * noise, np.full(SHAPE, sigma))


def test_the_same_picture_has_no_error():
    exact = Estimate(LIGHT, np.zeros(SHAPE))
    found = difference(exact, exact, MASK)
    assert found == Difference(0.0, 0.0, 0.0, 0.0, (0.0,) * 3, (0.0,) * 3, 0.0, 0.0)


@pytest.mark.parametrize("factor", [0.0, 0.7, 1.2])
def test_a_factor_is_the_error_everywhere(factor):
    zero = np.zeros(SHAPE)
    found = difference(Estimate(factor * LIGHT, zero), Estimate(LIGHT, zero), MASK)
    assert found.bias == pytest.approx(factor - 1.0)
    assert found.error == pytest.approx(abs(factor - 1.0))
    assert found.channels == pytest.approx((abs(factor - 1.0),) * 3)
    assert found.worst == pytest.approx(factor - 1.0)


def test_the_worst_block_is_found_with_its_sign():
    wrong = LIGHT.copy()
    wrong[16:32, 32:48] *= 0.5
    found = difference(Estimate(wrong, 0 * LIGHT), Estimate(LIGHT, 0 * LIGHT), MASK)
    assert found.worst == pytest.approx(-0.5)
    assert -0.2 < found.bias < 0.0


def test_noise_adds_nothing_to_the_square_of_the_error_and_is_foretold():
    """Over 400 pairs: means within 4 standard errors (false alarms: 6e-5 each), spreads within 20 %."""
    squares, biases, told, foretold = [], [], [], []
    for seed in range(400):
        a, b = noisy(0.9 * LIGHT, 0.3, 2 * seed), noisy(LIGHT, 0.3, 2 * seed + 1)
        found = difference(a, b, MASK)
        squares.append(found.error**2)
        biases.append(found.bias)
        told.append(found.error_error * 2.0 * found.error)
        foretold.append(found.bias_error)
    squares, biases = np.array(squares), np.array(biases)
    assert abs(squares.mean() - 0.01) < 4.0 * squares.std() / 20.0
    assert abs(biases.mean() + 0.1) < 4.0 * biases.std() / 20.0
    assert np.mean(foretold) == pytest.approx(biases.std(), rel=0.2)
    assert np.median(told) == pytest.approx(squares.std(), rel=0.25)


def test_a_perfect_model_has_no_error_but_noise():
    """An error above 3 of its standard errors is a false alarm in less than 1 % of pictures."""
    alarms = 0
    for seed in range(200):
        found = difference(noisy(LIGHT, 0.3, seed), noisy(LIGHT, 0.3, 1000 + seed), MASK)
        alarms += found.error > 3.0 * found.error_error
    assert alarms <= 6


def test_maps_show_differences_on_the_object_alone():
    shown = block_map(Estimate(1.1 * LIGHT, 0 * LIGHT), Estimate(LIGHT, 0 * LIGHT), MASK)
    assert np.isnan(shown[~MASK]).all()
    assert shown[MASK] == pytest.approx(0.1)


def test_the_noise_of_blocks():
    spread = noisy(LIGHT, 0.4, 0).noise_of_blocks(4)
    assert spread == pytest.approx(0.1)
