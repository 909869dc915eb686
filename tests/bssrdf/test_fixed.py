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


ALBEDOS = kernel.albedos()
SEEN = [0, 5, 20, 35, 50]  # rows


def _slab(thickness, eta=1.3, g=0.0):
    """Return the table of one slab: its faces, and the totals of each, (2, ROWS)."""
    found = fixed.slabs((thickness,), eta, g)
    return found.log_kernel.reshape(2, kernel.ROWS, -1), fixed.totals(found).reshape(2, -1)


@pytest.mark.parametrize("thickness", [0.5, 2.0, 10.0, 50.0])
@pytest.mark.parametrize("g", [0.0, 0.8])
def test_a_slab_sends_out_what_its_profiles_do(thickness, g):
    """With what leaves after one event: the multipole's own totals, by its closed form, of both faces."""
    _, found = _slab(thickness, 1.3, g)
    for row in SEEN:
        reduced = ALBEDOS[row]
        near = multipole.make(1.0 - reduced, reduced, 1.3, g, thickness)
        extinction = 1.0 - reduced + reduced / (1.0 - g)
        albedo = reduced / (1.0 - g) / extinction
        scattered, shares = -math.expm1(-thickness), slab_shares(g, 1.3, thickness * extinction)
        again = (1.0 - single_scattering_share(g, 1.3)) / (1.0 - sum(shares))
        for total, face, share in zip(found[:, row], (near, near.transmitted()), shares, strict=True):
            expected = max(face.albedo() / scattered, albedo * share)
            assert total / again + albedo * share == pytest.approx(expected, rel=2e-3 if g else 1e-6)


@pytest.mark.parametrize("thickness", [0.05, 0.5, 3.0, 40.0])
@pytest.mark.parametrize(("eta", "g"), [(1.3, 0.0), (1.5, 0.5)])
def test_without_absorption_all_that_arrives_leaves(thickness, eta, g):
    _, found = _slab(thickness, eta, g)
    assert found[:, 0].sum() == pytest.approx(1.0 - single_scattering_share(g, eta), rel=1e-6)


def test_a_thick_slab_is_the_dipole():
    """Jensen's, less what leaves after one event; its far face is dark."""
    row = 36  # reduced albedo .89
    near, far = _slab(1e3)[0]
    r = np.exp2(kernel.FIRST + kernel.STEP * np.arange(kernel.EDGES))
    exact = kernel.multiple("dipole", ALBEDOS[row], r, 1.3, 0.0)
    lit = exact > 1e-9
    assert np.exp2(near[row][lit]) == pytest.approx(exact[lit], rel=1e-3)
    assert far[row].max() < -90


def test_a_slab_that_scatters_nothing_sends_nothing():
    table = fixed.slabs((1e-18,), 1.3, 0.0)
    assert table.log_kernel[[kernel.ROWS - 1, -1]].max() < -90
    assert np.isfinite(table.poles).all()


@pytest.mark.parametrize(
    ("least", "most"), [(1.0, 1.0), (0.7, 1.9), (1.0, 2.0), (1e-9, 1e9), (0.0, 0.0), (1e9, 1e9)]
)
def test_thicknesses_reach_from_the_least_to_the_most(least, most):
    found = fixed.thicknesses(least, most)
    assert 2 <= len(found) <= 82
    assert np.diff(np.log2(found)) == pytest.approx(1.0 / fixed.AN_OCTAVE)
    assert found[0] == min(max(least, 2.0**-10), 2.0**10)
    assert found[-1] >= min(most, 2.0**10) * 0.999
