"""Models against the simulation: rings add up, the simulation agrees with exact totals, models with themselves."""

import math

import numpy as np
import pytest

from nephrite.physics import Medium, halfspace
from nephrite.profiles import StandardDipole, accuracy
from nephrite.profiles.base import Model
from nephrite.profiles.models import find

MEDIUM = Medium((0.02, 0.5, 1.0), (1.0, 1.5, 0.0), eta=1.3)
PATHS = 1 << 17


@pytest.fixture(scope="module")
def truths():
    return accuracy.simulate(MEDIUM, PATHS, seed=3)


def test_totals_are_the_exact_ones(truths):
    """Each within 4.4 standard errors: two of them fail a right program once in 50,000 seeds."""
    for channel in (0, 1):
        exact = halfspace.total_reflectance(MEDIUM.albedo[channel], MEDIUM.eta)
        assert abs(truths[channel].total - exact) < 4.4 * truths[channel].total_error
        assert truths[channel].light.sum() == pytest.approx(truths[channel].total, rel=1e-9)
        assert truths[channel].total_error < 0.01 * exact


def test_a_channel_that_does_not_scatter_has_no_truth(truths):
    assert truths[2] is None


def test_rings_are_in_millimetres(truths):
    """Channels with the same albedo' differ by their mean free path alone."""
    small, large = accuracy.simulate(Medium((0.1, 0.01, 0.01), (0.9, 0.09, 0.09)), 4096)[:2]
    np.testing.assert_allclose(large.edges[:-1], 10 * small.edges[:-1])
    np.testing.assert_array_equal(large.light, small.light)


def test_rings_of_a_profile_are_its_cdf():
    profile = StandardDipole(0.1, 1.0, 2.0)
    edges = np.concatenate([[0.0], np.geomspace(1e-2, 50.0, 30), [math.inf]])
    light = accuracy.rings(profile, edges)
    np.testing.assert_allclose(light[:-1].cumsum(), profile.albedo() * profile.cdf(edges[1:-1]), rtol=1e-6)
    assert light.sum() == pytest.approx(profile.albedo(), rel=1e-6)


class Known:
    """A profile that is what a truth says, ring by ring, times a factor."""

    def __init__(self, truth, factor, part):
        self.truth, self.factor, self.part = truth, factor, part

    def eval(self, r):
        ring = np.searchsorted(self.truth.edges, r) - 1
        return self.factor * self.part[ring] / self.truth.area[ring]

    def albedo(self):
        return self.factor * self.part.sum()


@pytest.mark.parametrize(
    ("terms", "factor", "expected"), [("single+multiple", 1.1, 0.1), ("multiple", 1.0, 0.0)]
)
def test_errors_are_those_that_were_put_in(truths, terms, factor, expected):
    truth = truths[0]
    part = truth.light if terms == "single+multiple" else truth.light - truth.single
    model = Model("known", "", "", terms, lambda *_: Known(truth, factor, part))
    found = accuracy.compare(model, MEDIUM, 0, truth)
    assert found.total_error == pytest.approx(expected, abs=1e-3)
    assert found.profile_error == pytest.approx(expected, abs=1e-3)


def test_diffusion_is_good_for_white_media_and_far_off_for_dark_ones(truths):
    light, dark = (accuracy.compare(find("dipole"), MEDIUM, i, truths[i]) for i in (0, 1))
    assert abs(light.total_error) < 0.1
    assert dark.profile_error > 0.3
    assert truths[0].noise < 0.03
