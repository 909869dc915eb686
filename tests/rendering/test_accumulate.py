"""The statistics of passes against their definitions."""

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.rendering.accumulate import Accumulator


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def accumulated(passes, spps):
    seen = Accumulator.empty(*passes[0].shape[:2])
    for pixels, spp in zip(passes, spps, strict=True):
        seen = seen.add(pixels, spp)
    return seen


def test_mean_is_that_of_all_samples_and_variance_is_the_weighted_one(rng):
    spps = [1, 1, 2, 4, 8, 8]
    passes = [rng.uniform(0, 2, (5, 7, 3)).astype(np.float32) for _ in spps]
    seen = accumulated(passes, spps)
    weights = np.array(spps, float)[:, None, None, None]
    mean = (weights * passes).sum(axis=0) / weights.sum()
    squares = (weights * (np.array(passes) - mean) ** 2).sum(axis=0)
    np.testing.assert_allclose(seen.mean, mean, rtol=1e-5)
    np.testing.assert_allclose(seen.variance(), squares / (len(spps) - 1) / weights.sum(), rtol=1e-4)
    assert (seen.spp, seen.passes, seen.dropped) == (24, 6, 0)
    assert seen.mean.dtype == seen.variance().dtype == np.float32


def test_variance_predicts_the_error_of_the_mean_whatever_the_split(rng):
    # 40,000 pixels of known mean, exponentially distributed samples (variance 1).
    for spps in ([4] * 8, [1, 1, 2, 4, 8, 16], [1] * 32):
        passes = [1.0 * rng.exponential(size=(n, 200, 200, 3)).mean(axis=0) for n in spps]
        seen = accumulated(passes, spps)
        expected = 1.0 / sum(spps)
        assert seen.variance().mean() == pytest.approx(expected, rel=0.03)
        assert np.mean((seen.mean - 1.0) ** 2) == pytest.approx(expected, rel=0.03)
        assert seen.noise() == pytest.approx(np.sqrt(expected), rel=0.12)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_not_finite_is_left_out_of_its_pass_alone(rng, bad):
    passes = [rng.uniform(0.5, 1, (3, 4, 3)).astype(np.float32) for _ in range(4)]
    good = accumulated(passes, [2, 2, 2, 2])
    spoiled = passes[1].copy()
    spoiled[0, 0, 2] = bad
    seen = accumulated([passes[0], spoiled, *passes[2:]], [2, 2, 2, 2])
    without = accumulated([passes[0], *passes[2:]], [2, 2, 2])
    assert seen.dropped == 1
    np.testing.assert_allclose(seen.mean[0, 0], without.mean[0, 0], rtol=1e-6)
    np.testing.assert_allclose(seen.variance()[0, 0], without.variance()[0, 0], rtol=1e-4)
    np.testing.assert_array_equal(seen.mean[1:], good.mean[1:])


def test_a_pixel_that_was_never_finite_is_black_and_its_variance_infinite():
    bad = np.full((2, 2, 3), np.nan, np.float32)
    bad[0, 0] = 0.5
    seen = accumulated([bad] * 3, [1, 2, 4])
    assert seen.dropped == 9
    np.testing.assert_array_equal(seen.mean[0, 0], 0.5)
    np.testing.assert_array_equal(seen.mean[1, 1], 0.0)
    assert np.isinf(seen.variance()[1, 1]).all()
    assert seen.noise() == 0.0


def test_noise_is_unknown_before_two_passes_and_without_light():
    assert accumulated([np.ones((2, 2, 3))], [4]).noise() == np.inf
    assert accumulated([np.zeros((2, 2, 3))] * 4, [4] * 4).noise() == np.inf


def test_the_noise_of_dark_pixels_does_not_decide(rng):
    def passes(dark):
        bright = 1 + 0.1 * rng.normal(size=(16, 100, 100, 3))
        bright[:, :30] = dark * rng.exponential(size=(16, 30, 100, 3))
        return bright

    lit, dim = (accumulated(passes(level), [1] * 16).noise() for level in (1.0, 1e-4))
    assert lit == pytest.approx(np.sqrt((0.7 * 0.01 + 0.3) / 16), rel=0.25)
    assert dim == pytest.approx(np.sqrt(0.7 * 0.01 / 16), rel=0.1)


def test_adding_leaves_the_earlier_statistics_alone(rng):
    first = accumulated([rng.uniform(size=(2, 2, 3))], [1])
    mean = first.mean.copy()
    first.add(np.full((2, 2, 3), 9.0), 1)
    np.testing.assert_array_equal(first.mean, mean)


def test_passes_of_different_sizes_are_refused():
    with pytest.raises(ParameterError, match="shape"):
        Accumulator.empty(2, 2).add(np.zeros((2, 3, 3)), 1)
