"""Error measures against pictures whose errors are known."""

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.image import errors


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def reference(rng):
    return rng.uniform(0.2, 1.0, (40, 56, 3))


@pytest.fixture
def disc():
    y, x = np.mgrid[0:40, 0:56]
    return (x - 28) ** 2 + (y - 20) ** 2 < 18**2


def test_relmse_of_a_constant_factor(reference):
    assert errors.relmse(1.1 * reference, reference, epsilon=0) == pytest.approx(0.01)
    black = np.zeros_like(reference)
    assert errors.relmse(black + 0.1, black) == pytest.approx(1.0)  # 0.1^2 / (0 + 0.01)


def test_only_the_mask_counts(reference, disc):
    spoiled = np.where(disc[..., None], 1.05 * reference, 1e6)
    assert errors.relmse(spoiled, reference, disc, epsilon=0) == pytest.approx(0.05**2)
    np.testing.assert_allclose(errors.mean_bias(spoiled, reference, disc), 0.05)
    blocks = errors.block_errors(spoiled, reference, disc, block=8)
    np.testing.assert_allclose(blocks[~np.isnan(blocks)], 0.05)
    assert np.isnan(blocks[0, 0]).all()


def test_mean_bias_is_signed_and_one_a_channel(reference):
    np.testing.assert_allclose(
        errors.mean_bias(reference * [1.1, 1.0, 0.8], reference), [0.1, 0, -0.2], atol=1e-12
    )


def test_block_errors_find_what_the_mean_hides(reference):
    image = reference.copy()
    image[8:16, 16:24, 1] *= 0.7
    blocks = errors.block_errors(image, reference, block=8)
    assert blocks.shape == (5, 7, 3)
    assert blocks[1, 2, 1] == pytest.approx(-0.3)
    assert np.count_nonzero(np.abs(blocks) > 1e-12) == 1
    assert errors.worst(blocks) == pytest.approx(-0.3)


def test_blocks_that_the_mask_barely_touches_do_not_count(reference):
    mask = np.zeros((40, 56), bool)
    mask[:8, :8] = True
    mask[8:16, :3] = True  # 24 of 64 pixels
    blocks = errors.block_errors(reference, reference, mask, block=8)
    assert np.isnan(blocks[..., 0]).sum() == 34
    assert (
        np.isnan(errors.block_errors(reference, reference, mask, block=8, coverage=0.3)[..., 0]).sum() == 33
    )
    assert np.isnan(errors.worst(np.full((2, 2, 3), np.nan)))


def test_efficiency_is_a_law_of_mean_variance_and_time(rng, disc):
    def estimate(spp):
        return 0.5 + rng.normal(0, 0.3 / np.sqrt(spp), (200, 200, 3))

    assert errors.efficiency(estimate(1), estimate(1), 2.0) == pytest.approx(0.25 / (0.09 * 2), rel=0.03)
    # Four times the samples in four times the time: as efficient.
    assert errors.efficiency(estimate(4), estimate(4), 8.0) == pytest.approx(0.25 / (0.09 * 2), rel=0.03)
    same = np.ones((4, 4, 3))
    assert errors.efficiency(same, same, 1.0) == np.inf


def test_z_scores_are_standard_normal_for_pictures_that_agree(rng):
    shape = (120, 160, 3)
    deviation = rng.uniform(0.01, 0.2, shape)
    a, b = (0.5 + s * deviation * rng.normal(size=shape) for s in (1.0, 2.0))
    for block in (1, 4):
        z = errors.z_scores(a, b, deviation**2, 4 * deviation**2, block=block)
        assert z.mean() == pytest.approx(0, abs=4 / np.sqrt(z.size))
        assert z.std() == pytest.approx(1, abs=3 / np.sqrt(z.size))
        assert np.abs(z).max() < errors.z_limit(z.size, 1e-3)


def test_z_scores_of_blocks_find_a_small_bias(rng):
    shape, sigma = (120, 160, 3), 0.1
    a, b = (0.5 + sigma * rng.normal(size=shape) for _ in range(2))
    variance = np.full(shape, sigma**2)
    z = errors.z_scores(1.05 * a, b, variance, variance, block=20)
    assert np.abs(z).max() > errors.z_limit(z.size)


def test_z_scores_without_variance_and_outside_the_mask():
    a, zero = np.ones((2, 2, 3)), np.zeros((2, 2, 3))
    b = a.copy()
    b[0, 0] = 2.0
    mask = np.array([[True, True], [True, False]])
    z = errors.z_scores(a, b, zero, zero, mask)
    assert z[0, 0, 0] == -np.inf
    assert z[0, 1, 0] == 0
    assert np.isnan(z[1, 1]).all()


def test_z_limit_of_one_score_is_the_two_sided_quantile():
    assert errors.z_limit(1, 0.05) == pytest.approx(1.959964, abs=1e-5)
    assert errors.z_limit(10000) > errors.z_limit(100) > errors.z_limit(1)


def test_difference_is_relative_and_quiet_in_the_dark(reference, disc):
    reference[:4] = 0
    noisy = 1.2 * reference
    noisy[:4] += 1e-4
    found = errors.difference(noisy, reference)
    np.testing.assert_allclose(found[10:], 0.2, rtol=0.1)
    assert np.abs(found[:4]).max() < 0.02
    outside = errors.difference(noisy, reference, disc)
    assert np.isnan(outside[~disc]).all()
    assert np.isfinite(outside[disc]).all()


def test_misuse_is_refused(reference):
    with pytest.raises(ParameterError, match="shape"):
        errors.relmse(reference, reference[:-1])
    with pytest.raises(ParameterError, match="mask has the shape"):
        errors.relmse(reference, reference, np.ones((2, 2)))
    with pytest.raises(ParameterError, match="empty"):
        errors.mean_bias(reference, reference, np.zeros((40, 56)))
    with pytest.raises(ParameterError, match="seconds"):
        errors.efficiency(reference, reference, 0)
    with pytest.raises(ParameterError, match="blocks"):
        errors.block_errors(reference, reference, block=64)
    with pytest.raises(ParameterError, match="significance"):
        errors.z_limit(10, 1.5)
