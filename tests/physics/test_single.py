"""Single scattering in a slab: the simulation's, where faces reflect nothing, and limits."""

import math

import numpy as np
import pytest

from nephrite.image.errors import z_limit
from nephrite.physics import fresnel, searchlight
from nephrite.physics.single import deep_share, single_scattering_share, slab_shares


@pytest.mark.parametrize(("g", "thickness"), [(0.0, 0.1), (0.0, 2.0), (0.8, 1.0), (-0.5, 0.5)])
def test_shares_are_those_of_a_simulation(g, thickness):
    """Without an interface no path is left out; a right program fails with probability 1e-3 in all."""
    light = searchlight.simulate(
        1.0, g, thickness=thickness, incidence="diffuse", paths=2**18, seed=3, radii=(1.0, 2.0, 1)
    )
    crosses = light.total(1.0, True, first=0, last=0)
    for share, transmitted in zip(slab_shares(g, 1.0, thickness), (False, True), strict=True):
        found = light.total(1.0, transmitted, first=1, last=1)
        scattered = 1.0 - float(crosses.value)
        error = math.hypot(float(found.error), share * float(crosses.error)) / scattered
        assert abs(float(found.value) / scattered - share) < z_limit(8, 1e-3) * error


@pytest.mark.parametrize("g", [0.0, 0.7])
def test_an_interface_that_reflects_little_changes_little(g):
    """What is left out: paths on which a face reflects, some 3 % of a thick slab's at an index of 1.3."""
    light = searchlight.simulate(
        1.3, g, thickness=3.0, incidence="diffuse", paths=2**18, seed=4, radii=(1.0, 2.0, 1)
    )
    scattered = 1.0 - sum(float(light.total(1.0, far, first=0, last=0).value) for far in (False, True))
    for share, transmitted in zip(slab_shares(g, 1.3, 3.0), (False, True), strict=True):
        found = light.total(1.0, transmitted, first=1, last=1)
        assert share == pytest.approx(float(found.value) / scattered, abs=2e-3)


def test_limits():
    near, far = slab_shares(0.3, 1.3, math.inf)
    assert near == single_scattering_share(0.3, 1.3)
    assert far == 0.0
    assert sum(slab_shares(0.6, 1.0, 1e-6)) == pytest.approx(1.0, abs=1e-3)  # all of it leaves a film
    assert np.diff(slab_shares(0.0, 1.3, 1e-6)) == pytest.approx(0.0, abs=1e-5)  # which has no sides


@pytest.mark.parametrize("g", [0.0, 0.8])
def test_steep_light_goes_deeper_and_the_mean_is_one(g):
    """The mean is that over diffuse light, of which 1 - F gets in."""
    cosine = (np.arange(2000) + 0.5) / 2000
    entering = cosine * (1.0 - fresnel.reflectance(cosine, 1.4))
    share = deep_share(cosine, g, 1.4)
    assert (entering * share).sum() / entering.sum() == pytest.approx(1.0, abs=1e-5)
    assert (np.diff(share) > 0).all()
    assert share[-1] > 1.0 > share[0]
