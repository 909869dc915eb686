"""Tables of measured profiles and of slabs: what leaves in all is what the profile's own quadrature says."""

import math

import numpy as np
import pytest

from nephrite.bssrdf import fixed, kernel
from nephrite.physics.single import single_scattering_share, slab_shares
from nephrite.profiles import multipole
from nephrite.profiles.measured import MeasuredProfile


def test_the_total_of_a_table_is_its_integral():
    """A kernel 1 / (1 + r^2)^2: pi."""
    table = kernel.table(lambda r: 1.0 / (1.0 + r**2) ** 2, 1)
    assert fixed.totals(table) == pytest.approx(math.pi, rel=1e-3)


def test_measured_profiles_keep_their_totals_and_values():
    profiles = (
        MeasuredProfile([0.1, 0.4, 1.0, 1.7, 4.0], [0.105, 0.08, 0.025, 0.03, 0.0005]),
        MeasuredProfile([0.0, 1.0], [0.2, 0.2]),
        MeasuredProfile([0.0, 1.0, 2.0, 30.0], [0.1, 0.0, 0.0, 1e-5]),
    )
    table = fixed.measured(profiles)
    assert fixed.totals(table) == pytest.approx([profile.albedo() for profile in profiles], rel=1e-6)
    for row, profile in zip(table.log_kernel, profiles, strict=True):
        length = profile.reach() / fixed.PER_REACH
        r = np.exp2(kernel.FIRST + kernel.STEP * np.arange(kernel.EDGES)) * length
        inside = (r < 0.99 * profile.reach()) & (profile.eval(r) > 0)
        assert np.exp2(row[inside]) / length**2 == pytest.approx(profile.eval(r[inside]), rel=0.02)
        assert np.all(row[r > 1.01 * profile.reach()] < -99)


@pytest.mark.parametrize("albedo", [0.5, 0.9, 0.99, 1.0])
@pytest.mark.parametrize("thickness", [0.5, 2.0, 10.0, 50.0])
def test_a_slab_sends_out_what_its_profiles_do(albedo, thickness):
    """With what leaves after one event: the multipole's own totals, by its closed form, of both faces."""
    found = fixed.totals(fixed.slab(albedo, thickness, 1.3, 0.0))
    near = multipole.make(1.0 - albedo, albedo, 1.3, 0.0, thickness)
    scattered, shares = -math.expm1(-thickness), slab_shares(0.0, 1.3, thickness)
    again = (1.0 - single_scattering_share(0.0, 1.3)) / (1.0 - sum(shares))
    for total, face, share in zip(found, (near, near.transmitted()), shares, strict=True):
        expected = max(face.albedo() / scattered, albedo * share)
        assert total / again + albedo * share == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("thickness", [0.05, 0.5, 3.0, 40.0])
@pytest.mark.parametrize(("eta", "g"), [(1.3, 0.0), (1.5, 0.5)])
def test_without_absorption_all_that_arrives_leaves(thickness, eta, g):
    total = fixed.totals(fixed.slab(1.0, thickness, eta, g)).sum()
    assert total == pytest.approx(1.0 - single_scattering_share(g, eta), rel=1e-6)


def test_a_thick_slab_is_the_dipole():
    """Jensen's, less what leaves after one event; its far face is dark."""
    found = fixed.slab(0.9, 1e3, 1.3, 0.0).log_kernel
    r = np.exp2(kernel.FIRST + kernel.STEP * np.arange(kernel.EDGES))
    exact = kernel.multiple("dipole", 0.9, r, 1.3, 0.0)
    lit = exact > 1e-9
    assert np.exp2(found[0][lit]) == pytest.approx(exact[lit], rel=1e-3)
    assert found[1].max() < -90


def test_a_slab_that_scatters_nothing_sends_nothing():
    table = fixed.slab(0.0, 1e-18, 1.3, 0.0)
    assert table.log_kernel.max() < -90
    assert np.isfinite(table.poles).all()
