"""The tabulated profile against fresh simulations, exact totals and its own laws; see also `test_laws`.

Statistical tests fix their seeds; each fails a right program with probability 1e-4 a case, were the seed drawn anew.
"""

import math

import numpy as np
import pytest
from scipy import stats

from nephrite.errors import ParameterError
from nephrite.physics import halfspace, searchlight
from nephrite.physics.searchlight_walk import Counts, Setting, order_bins
from nephrite.physics.single import single_scattering_share
from nephrite.profiles import tabulate, tabulated_shape
from nephrite.profiles.tabulated import TabulatedProfile
from nephrite.profiles.tabulated_shape import albedo_of

KINDS = [("diffuse", "multiple"), ("normal", "all")]
WHITES = 1.0 - np.array([0.7, 0.3, 0.05, 2e-3, 1e-4, 3e-6, 0.0])


def test_file_is_small_and_holds_every_node():
    assert tabulated_shape.PACKAGED.stat().st_size < 2**20
    table = tabulated_shape.load()
    nodes = {(incidence, eta, g) for incidence, eta, g, _ in tabulate.cases()}
    assert nodes == {(i, eta, g) for i in tabulated_shape.INCIDENCES for eta in table.eta for g in table.g}
    assert np.all(np.isfinite(table.multiple))
    assert np.all(np.isfinite(table.single))
    assert table.multiple.shape[3:] == (tabulated_shape.T_NODES.size, tabulated_shape.KNOTS)


def test_what_is_written_is_read(tmp_path):
    table = tabulated_shape.load()
    path = tmp_path / "some" / "table.npz"
    tabulated_shape.write(path, table.eta, table.g, table.multiple + 1e-5, table.single)
    again = tabulated_shape.load(path)
    np.testing.assert_array_equal(again.multiple, table.multiple)
    np.testing.assert_array_equal(again.single, table.single)


@pytest.mark.parametrize(("incidence", "orders"), KINDS)
@pytest.mark.parametrize(("eta", "g"), [(1.0, 0.0), (1.013, 0.6), (1.37, 0.93), (2.4, -0.3)])
def test_totals_are_exact(eta, g, incidence, orders):
    profile = TabulatedProfile(1.0 - WHITES, WHITES, eta, g, incidence, orders)
    expected = [
        halfspace.total_reflectance(albedo_of(a, g), eta, g, incidence, orders == "multiple") for a in WHITES
    ]
    np.testing.assert_allclose(profile.albedo(), expected, rtol=2e-4)


@pytest.mark.parametrize("g", [0.0, 0.8])
@pytest.mark.parametrize("eta", [1.0, 1.3, 1.6])
def test_white_furnace(eta, g):
    """With what has scattered once, all light that entered a white half-space leaves it, and never more."""
    whites = np.array([0.9, 0.999, 1.0 - 1e-5, 1.0])
    once = albedo_of(whites, g) * single_scattering_share(g, eta)
    total = TabulatedProfile(1.0 - whites, whites, eta, g).albedo() + once
    assert total[-1] == pytest.approx(1.0, abs=3e-4)
    assert np.all(total < 1.0 + 1e-4)
    assert np.all(np.diff(total) > 0.0)


@pytest.mark.parametrize(
    ("eta", "g", "incidence", "orders", "paths"),
    [
        (1.25, 0.0, "diffuse", "multiple", 2**18),
        (1.55, 0.0, "diffuse", "multiple", 2**18),
        (1.02, 0.0, "normal", "all", 2**18),
        (1.33, 0.86, "normal", "all", 2**16),
    ],
)
def test_fresh_simulations_agree_off_the_nodes(eta, g, incidence, orders, paths):
    """Chi-square over rings, of which there are three a decade; and the L1 error asked for, noise included."""
    light = searchlight.simulate(
        eta, g, incidence=incidence, paths=paths, seed=77, longest=2**14, radii=(0.01, 100.0, 12)
    )
    for reduced in (0.37, 0.83, 0.985):
        albedo = albedo_of(reduced, g)
        rings = light.profile(albedo, first=2 if orders == "multiple" else 1)
        profile = TabulatedProfile(1.0 - reduced, reduced, eta, g, incidence, orders)
        within = np.array([*profile.cdf(rings.edges[:-1] * (1.0 - albedo * g)), 1.0])
        expected = profile.albedo() * np.diff(within)
        counts = expected > 2e-3 * profile.albedo()
        z = (rings.value[counts] - expected[counts]) / rings.error[counts]
        assert stats.chi2.sf(z @ z, z.size) > 1e-4, z
        noise = rings.error.sum() / profile.albedo()
        assert np.abs(rings.value - expected).sum() < (0.02 if g == 0.0 else 0.05) * profile.albedo()
        assert noise < 0.05


def test_normal_light_is_what_scattered_once_and_more_often():
    eta, g = 1.4, 0.3
    every, more = (TabulatedProfile(0.2, 0.8, eta, g, "normal", orders) for orders in ("all", "multiple"))
    albedo = albedo_of(0.8, g)
    r = np.geomspace(1e-3, 5.0, 200)
    assert np.all(every.eval(r) >= 0.999 * more.eval(r))
    exits = halfspace.emergent(albedo, eta, g, "normal")
    assert every.albedo() - more.albedo() == pytest.approx(exits.lobe @ exits.single, rel=1e-3)
    # near the beam, light that scattered once goes as 1/r
    once = (every.eval(r) - more.eval(r)) * r
    assert once[0] == pytest.approx(once[20], rel=0.1)


def test_within_the_first_radius_light_is_even():
    profile = TabulatedProfile(0.2, 0.8, 1.3, 0.9, "normal", "all")
    r = tabulated_shape.R_MIN * np.array([0.25, 0.5, 1.0])
    np.testing.assert_allclose(profile.cdf(r) / profile.cdf(r[-1]), [1 / 16, 1 / 4, 1.0], rtol=1e-6)
    np.testing.assert_allclose(profile.eval(r), profile.eval(r[-1]), rtol=1e-9)


def test_nodes_are_met_and_cubics_between_them():
    """What weighs the table's nodes in eta and ln(1 - g) interpolates, and is exact for cubic polynomials."""
    table = tabulated_shape.load()
    for j, k in ((0, 0), (3, 2), (7, 6)):
        multiple, single, _ = table.at(table.eta[j], table.g[k], "normal")
        np.testing.assert_allclose(multiple, table.multiple[1, j, k], atol=1e-9)
        np.testing.assert_allclose(single, table.single[1, j, k], atol=1e-9)
    grid_eta, grid_g = table.eta[:, None], np.log(1.0 - table.g)
    values = (grid_eta**3 - grid_g**2 + grid_eta * grid_g)[None, :, :, None]
    shapes = tabulated_shape.Shapes(table.eta, table.g, values[..., None], values)
    eta, g = 1.27, 0.6
    expected = eta**3 - math.log(1.0 - g) ** 2 + eta * math.log(1.0 - g)
    assert shapes.at(eta, g, "diffuse")[1] == pytest.approx(expected)


def test_reach_holds_nearly_all():
    for eta in (1.0, 1.5):
        profile = TabulatedProfile(1.0 - WHITES, WHITES, eta)
        np.testing.assert_allclose(profile.cdf(profile.reach()), 0.99, atol=1e-3)


@pytest.mark.parametrize(("eta", "g"), [(1.0, 0.0), (1.3, 0.7), (1.55, 0.95)])
def test_slope_of_the_lobe(eta, g):
    whites = WHITES[:-1]
    profile = TabulatedProfile(1.0 - whites, whites, eta, g)
    expected = [halfspace.lobe_slope(albedo_of(a, g), eta, g) for a in whites]
    np.testing.assert_allclose(profile.lobe_slope(), [slope for slope, _ in expected], atol=3e-3)
    assert profile.mean_cosine == pytest.approx(expected[0][1])


def test_values_change_smoothly():
    """Third differences are small: between the rows and columns of the table there are no kinks (5e-5 if linear)."""
    t = np.linspace(0.2, 0.85, 2000)
    values = np.log(TabulatedProfile(t**4, 1.0 - t**4, 1.3).eval(1.0))
    assert np.abs(np.diff(values, n=3)).max() < 1e-5
    values = np.log(TabulatedProfile(0.05, 0.95, 1.3).eval(np.geomspace(0.01, 30.0, 4000)))
    assert np.abs(np.diff(values, n=3)).max() < 1e-5
    values = np.log([TabulatedProfile(0.05, 0.95, eta).eval(1.0) for eta in (1.28, 1.29, 1.3, 1.31, 1.32)])
    assert np.abs(np.diff(values, n=2)).max() < 1e-3


@pytest.mark.parametrize(
    "parameters", [{"incidence": "norma"}, {"orders": "single"}, {"g": 1.0}, {"eta": 0.0}]
)
def test_nonsense_is_refused(parameters):
    with pytest.raises(ParameterError):
        TabulatedProfile(**{"sigma_a": 0.1, "sigma_s_prime": 0.9, "eta": 1.3} | parameters)


def test_fit_finds_what_the_counts_were_drawn_from():
    """Counts of a known profile: the fit's L1 error is well below the counts' own."""
    radii, rate, paths = np.geomspace(1e-4, 3e5, 191), 0.2, 200_000
    x = np.log(radii)
    fine = np.linspace(x[:-1], x[1:], 21)
    density = tabulated_shape.reference(fine, rate) * np.exp(0.4 * np.tanh(fine - 1.0))
    light = np.trapezoid(density, fine, axis=0)
    light /= light.sum()
    rings = np.zeros((2, 2, order_bins(200), 192))
    rings[0, :, 2, 1:-1] = np.random.default_rng(5).multinomial(paths, light)
    setting = Setting(1.3, 0.0, math.inf, "diffuse", 0.0, 200, radii, 1)
    one = searchlight.Searchlight(
        setting, 0.0, Counts(paths, rings, np.zeros((2, 2, order_bins(200), 1)), 0.0)
    )
    spline = tabulate.fit((one, one), 1.0, 2, None, rate, 1.0)
    middle = 0.5 * (x[1:] + x[:-1])
    found = tabulated_shape.light(middle, spline, rate) * np.diff(x)
    raw = np.abs(rings[0, 0, 2, 1:-1] / paths - light).sum()
    assert np.abs(found - light).sum() < 0.35 * raw
    assert found.sum() == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_the_command_makes_the_same_again():
    """One node as `python -m nephrite.profiles.tabulate` makes it, to a unit of the last digit that is stored."""
    table = tabulated_shape.load()
    incidence, eta, g, seed = next(case for case in tabulate.cases() if case[:3] == ("normal", 1.3, 0.0))
    multiple, single = tabulate.node(tabulate.simulate(incidence, eta, g, seed))
    place = (1, list(table.eta).index(eta), list(table.g).index(g))
    np.testing.assert_allclose(table.multiple[place], multiple, atol=6e-4)
    np.testing.assert_allclose(table.single[place], single, atol=6e-4)
