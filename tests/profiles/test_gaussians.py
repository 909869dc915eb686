"""Sums of Gaussians: published ones, and fits to other profiles."""

import math

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.profiles import MODELS, StandardDipole
from nephrite.profiles.gaussians import DEVIATIONS, GaussianSum, fit

# d'Eon and Luebke (2007), figure 14-13: skin, variances in mm^2, weights of red, green and blue
VARIANCES = (0.0064, 0.0484, 0.187, 0.567, 1.99, 7.41)
SKIN = (
    (0.233, 0.100, 0.118, 0.113, 0.358, 0.078),
    (0.455, 0.336, 0.198, 0.007, 0.004, 0.0),
    (0.649, 0.344, 0.0, 0.007, 0.0, 0.0),
)


def test_the_published_skin_is_normalised_to_white():
    for weights in SKIN:
        assert GaussianSum(weights, VARIANCES).albedo() == pytest.approx(1.0, abs=1e-9)


def test_the_published_skin_lets_red_go_furthest():
    median = [float(np.median(GaussianSum(w, VARIANCES).sample(*np.random.default_rng(1).random((2, 20_000)))))
              for w in SKIN]  # fmt: skip
    assert median[0] > 1.9 * median[1]
    assert median[1] > 1.2 * median[2]


@pytest.mark.parametrize("weights", SKIN)
def test_a_fit_finds_the_sum_that_it_is_given(weights):
    found = fit(GaussianSum(weights, VARIANCES), [math.sqrt(v) for v in VARIANCES])
    np.testing.assert_allclose(found.weights, weights, atol=1e-9)


def test_one_gaussian_is_known_by_heart():
    profile = GaussianSum([0.6], [4.0])
    assert profile.eval(0.0) == pytest.approx(0.6 / (8.0 * math.pi))
    assert profile.cdf(2.0) == pytest.approx(1.0 - math.exp(-0.5))
    assert profile.sample(1.0 - math.exp(-0.5)) == pytest.approx(2.0)


def distance(fitted, profile):
    r = np.geomspace(1e-3, 1e3, 2000)
    mass = 2.0 * math.pi * r * r
    return float(np.sum(mass * np.abs(fitted.eval(r) - profile.eval(r))) / np.sum(mass * profile.eval(r)))


@pytest.mark.parametrize("absorbed", [0.5, 0.1, 0.01, 1e-3])
def test_the_model_is_near_to_what_it_is_fitted_to(absorbed):
    """Also between the albedos that are fitted: 10 Gaussians are within 8 % (L1)."""
    fitted = MODELS["gaussians"].make(absorbed, 1.0 - absorbed, 1.3)
    profile = MODELS["photon_beam"].make(absorbed, 1.0 - absorbed, 1.3)
    assert fitted.albedo() == pytest.approx(profile.albedo(), rel=5e-3)
    assert distance(fitted, profile) < 0.08


def test_any_profile_can_be_fitted():
    dipole = StandardDipole(0.02, 1.0, 2.0)
    fitted = fit(dipole, [2.0 * d for d in DEVIATIONS])
    assert distance(fitted, dipole) < 0.03
    assert fitted.albedo() == pytest.approx(dipole.albedo())
    assert min(fitted.weights) >= 0.0


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="2 weights and 1 variances"):
        GaussianSum([0.1, 0.2], [1.0])
    with pytest.raises(ParameterError, match="above 0"):
        fit(StandardDipole(0.1, 1.0, 2.0), [1.0, 0.0])
