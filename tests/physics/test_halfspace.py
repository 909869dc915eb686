"""The exact half-space: against H functions, published values, laws, and another program of the same mathematics."""

import math

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.physics import halfspace
from nephrite.physics.fresnel import external_diffuse_reflectance, lobe_normalization
from nephrite.physics.single import single_scattering_share

NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)
MU, WEIGHTS = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS
# 1 - H(1) sqrt(1 - albedo): diffuse reflectance of an index-matched, isotropic half-space at normal incidence
PUBLISHED = {0.5: 0.1152, 0.8: 0.2853, 0.95: 0.5355, 0.99: 0.7527, 0.999: 0.9128}


def _h(albedo):
    """Chandrasekhar's H function for isotropic scattering at `MU`, and at 1, by iteration (1960, section 40)."""
    left = math.sqrt(1.0 - albedo)
    h = np.ones_like(MU)
    for _ in range(3000):
        new = 1.0 / (left + 0.5 * albedo * (MU / (MU + MU[:, None])) @ (WEIGHTS * h))
        done = np.abs(new - h).max() < 1e-12
        h = new
        if done:
            break
    at_one = 1.0 / (left + 0.5 * albedo * np.sum(WEIGHTS * h * MU / (1.0 + MU)))
    return h, at_one


@pytest.mark.parametrize(("albedo", "published"), PUBLISHED.items())
def test_h_functions_give_the_same(albedo, published):
    h, at_one = _h(albedo)
    left = math.sqrt(1.0 - albedo)
    straight = halfspace.total_reflectance(albedo, 1.0, incidence="normal")
    assert straight == pytest.approx(1.0 - at_one * left, abs=1e-6)
    assert straight == pytest.approx(published, abs=5e-5)  # the published values hold for normal incidence
    diffuse = halfspace.total_reflectance(albedo, 1.0)
    assert diffuse == pytest.approx(1.0 - 2.0 * left * np.sum(WEIGHTS * MU * h), abs=1e-6)
    exits = halfspace.emergent(albedo, 1.0, 0.0, "normal")
    # radiance of light that leaves: albedo/4 H(mu) H(1) / (mu + 1) over pi, of flux pi
    expected = 0.25 * albedo * at_one * np.interp(exits.outside, MU, h) / (exits.outside + 1.0)
    np.testing.assert_allclose(exits.all, expected, rtol=2e-3)


@pytest.mark.parametrize(("eta", "incidence", "exact"), [
    (1.3, "normal", (0.063486, 0.181324, 0.407815, 0.656564, 0.871583)),
    (1.5, "diffuse", (0.048825, 0.144025, 0.344704, 0.594770, 0.839511)),
    (0.8, "normal", (0.109413, 0.275354, 0.525485, 0.746090, 0.910229)),
])  # fmt: skip
def test_totals_under_an_interface(eta, incidence, exact):
    """Against H functions and a linear system for the light that the interface turns back: another method."""
    found = [halfspace.total_reflectance(albedo, eta, 0.0, incidence) for albedo in PUBLISHED]
    np.testing.assert_allclose(found, exact, atol=1e-6)


@pytest.mark.parametrize("eta", [0.7, 1.0, 1.0001, 1.02, 1.3, 1.6, 2.4])
@pytest.mark.parametrize("g", [-0.5, 0.0, 0.5, 0.9, 0.95])
def test_nodes_are_enough(eta, g, monkeypatch):
    cases = [(a, i) for a in (0.5, 0.99, 0.9999) for i in ("normal", "diffuse")]
    values = [halfspace.total_reflectance(a, eta, g, i) for a, i in cases]
    monkeypatch.setattr(halfspace, "_NODES", 60)
    halfspace.emergent.cache_clear()
    finer = [halfspace.total_reflectance(a, eta, g, i) for a, i in cases]
    halfspace.emergent.cache_clear()
    np.testing.assert_allclose(values, finer, rtol=1e-7 if abs(g) < 0.6 else 1e-3, atol=1e-6)


@pytest.mark.parametrize("incidence", ["diffuse", "normal"])
@pytest.mark.parametrize("g", [-0.4, 0.0, 0.8, 0.95])
@pytest.mark.parametrize("eta", [0.8, 1.0, 1.3, 1.7])
def test_totals_rise_from_nothing_to_all(eta, g, incidence):
    albedos = [0.0, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0 - 1e-5, 1.0 - 1e-8, 1.0]
    totals = [halfspace.total_reflectance(a, eta, g, incidence) for a in albedos]
    assert totals[0] == 0.0
    assert totals[-1] == pytest.approx(1.0, abs=1e-12)
    assert np.all(np.diff(totals) > 0)
    multiple = [halfspace.total_reflectance(a, eta, g, incidence, multiple=True) for a in albedos]
    assert np.all(np.diff(multiple) > 0)
    # near white the loss is proportional to the square root of what an event absorbs
    losses = [1.0 - halfspace.total_reflectance(1.0 - 10.0**-k, eta, g, incidence) for k in (6, 8)]
    assert losses[0] / losses[1] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("g", [-0.6, 0.0, 0.7, 0.95])
@pytest.mark.parametrize("eta", [1.0, 1.3, 1.6])
def test_single_scattering_is_the_other_quadrature(eta, g):
    exits = halfspace.emergent(0.7, eta, g)
    assert exits.lobe @ exits.single == pytest.approx(0.7 * single_scattering_share(g, eta), rel=2e-5)


@pytest.mark.parametrize("g", [0.0, 0.8])
@pytest.mark.parametrize("eta", [1.0, 1.3, 1.5])
def test_light_goes_both_ways(eta, g):
    """Radiance towards the normal, of diffuse light outside, is what straight light has as its total."""
    exits = halfspace.emergent(0.9, eta, g, "diffuse")
    straight = halfspace.total_reflectance(0.9, eta, g, "normal")
    towards_normal = np.polyval(np.polyfit(exits.outside[-6:], exits.all[-6:], 3), 1.0)
    assert towards_normal == pytest.approx(straight, rel=1e-4)


@pytest.mark.parametrize(("eta", "removed"), [(1.0, 0.5), (1.3, 0.9), (1.5, 0.95), (1.6, 0.95)])
@pytest.mark.parametrize("g", [0.0, 0.8, 0.95])
@pytest.mark.parametrize("albedo_prime", [0.5, 0.9])
def test_a_line_in_the_inner_cosine_is_most_of_the_lobe(eta, removed, g, albedo_prime):
    albedo = albedo_prime / (1.0 - g + albedo_prime * g)
    exits = halfspace.emergent(albedo, eta, g)
    slope, mean = halfspace.lobe_slope(albedo, eta, g)
    relative = exits.multiple / (exits.lobe @ exits.multiple)
    plain = exits.lobe @ np.abs(relative - 1.0)
    left = exits.lobe @ np.abs(relative - 1.0 - slope * (exits.inside - mean))
    assert left < (1.0 - removed) * plain
    assert exits.lobe @ (1.0 + slope * (exits.inside - mean)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("eta", [1.0, 1.3, 1.5])
def test_the_lobe_is_the_plain_one(eta):
    exits = halfspace.emergent(0.5, eta)
    assert exits.lobe.sum() == pytest.approx(1.0, abs=1e-12)
    assert lobe_normalization(eta) == pytest.approx(1.0 - external_diffuse_reflectance(eta))
    # its mean squared sine, by another quadrature
    density = 2.0 * WEIGHTS * MU * (1.0 - np.array([_reflectance(mu, eta) for mu in MU]))
    expected = density @ (1.0 - MU**2) / density.sum()
    assert exits.lobe @ (1.0 - exits.outside**2) == pytest.approx(expected, rel=1e-5)


def _reflectance(mu, eta):
    from nephrite.physics.fresnel import reflectance

    return reflectance(mu, eta)


@pytest.mark.parametrize(
    "call",
    [
        lambda: halfspace.total_reflectance(1.1, 1.3),
        lambda: halfspace.total_reflectance(0.5, -1.0),
        lambda: halfspace.total_reflectance(0.5, 1.3, 1.0),
        lambda: halfspace.total_reflectance(0.5, 1.3, 0.0, "slanted"),
    ],
)
def test_nonsense_is_refused(call):
    with pytest.raises(ParameterError):
        call()
