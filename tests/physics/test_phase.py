import math
from itertools import pairwise

import drjit as dr
import numpy as np
import pytest
from drjit.scalar import ArrayXf
from scipy.integrate import quad
from scipy.stats import chisquare

from nephrite.errors import ParameterError
from nephrite.physics import phase

MEANS = [-0.9, -0.3, 0.0, 5e-4, 0.3, 0.8, 0.97]


@pytest.mark.parametrize("g", MEANS)
def test_integral_is_one_and_the_mean_cosine_is_g(g):
    def over_sphere(f):
        return 2 * math.pi * quad(f, -1, 1, points=[-0.99, 0.99], epsabs=1e-12, limit=200)[0]

    assert over_sphere(lambda mu: phase.eval(mu, g)) == pytest.approx(1, abs=1e-9)
    assert over_sphere(lambda mu: mu * phase.eval(mu, g)) == pytest.approx(g, abs=1e-9)


def test_isotropic_is_constant():
    np.testing.assert_allclose(phase.eval(np.linspace(-1, 1, 9), 0.0), 1 / (4 * math.pi))


@pytest.mark.parametrize("g", MEANS)
def test_sample_follows_pdf(g):
    rng = np.random.default_rng(7)
    count = 200_000
    x, y, z = phase.sample(rng.random(count), rng.random(count), g)
    np.testing.assert_allclose(x * x + y * y + z * z, 1, atol=1e-12)
    edges = np.quantile(z, np.linspace(0, 1, 33)[1:-1])
    edges = np.concatenate([[-1.0], edges, [1.0]])
    # expected from the density, not from the sampler: fixed bins, chosen with another half of the numbers
    fresh = phase.sample_cosine(rng.random(count), g)
    observed, _ = np.histogram(fresh, edges)
    expected = [
        2 * math.pi * quad(phase.pdf, a, b, args=(g,), epsabs=1e-13, limit=200)[0] for a, b in pairwise(edges)
    ]
    expected = np.array(expected) / np.sum(expected) * count
    assert chisquare(observed, expected).pvalue > 1e-4
    angle, _ = np.histogram(np.arctan2(y, x), 16, (-math.pi, math.pi))
    assert chisquare(angle).pvalue > 1e-4


@pytest.mark.parametrize("g", [-0.999999, 0.999999, 1e-9, -1e-3, 1e-3])
def test_extreme_means_stay_finite(g):
    u = np.linspace(0, 1, 101)
    for single in (u, u.astype(np.float32)):
        cosine = phase.sample_cosine(single, g)
        assert np.all(np.abs(cosine) <= 1)
        assert np.all(np.diff(cosine) <= 1e-4)
        assert np.all(np.isfinite(phase.eval(cosine, g)))


def test_the_series_meets_the_closed_form():
    u = np.linspace(0, 1, 11)
    below, above = phase.sample_cosine(u, 0.000999), phase.sample_cosine(u, 0.001001)
    np.testing.assert_allclose(below, above, atol=1e-5)


def test_drjit_arrays_give_what_numpy_gives():
    u1, u2, g = (
        np.linspace(0.01, 0.99, 7),
        np.linspace(0, 1, 7),
        np.array([-0.9, -0.2, 0, 1e-4, 0.3, 0.8, 0.95]),
    )
    result = phase.sample(ArrayXf(u1), ArrayXf(u2), ArrayXf(g))
    expected = phase.sample(u1, u2, g)
    for ours, theirs in zip(result, expected, strict=True):
        assert dr.is_array_v(ours)
        np.testing.assert_allclose(np.array(ours), theirs, atol=2e-4)


def test_floats_stay_floats():
    assert isinstance(phase.eval(0.3, 0.5), float)
    assert all(isinstance(v, float) for v in phase.sample(0.1, 0.2, 0.5))


@pytest.mark.parametrize("g", [1, -1, 1.5, math.nan, "forward"])
def test_impossible_means_are_refused(g):
    with pytest.raises(ParameterError, match="g is"):
        phase.check_g(g)
