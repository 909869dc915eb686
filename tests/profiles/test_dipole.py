"""Laws of radial profiles, stated for the standard dipole, and values that were published for it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, stats

from nephrite.physics.fresnel import boundary_factor
from nephrite.profiles import StandardDipole

SKIM_MILK = ((0.0014, 0.0025, 0.0142), (0.70, 1.22, 1.90))
PUBLISHED = (0.815, 0.813, 0.682)  # diffuse reflectance: Jensen et al. (2001), table 1

coefficient = st.floats(1e-4, 1e4)
mediums = st.builds(
    lambda a, s, eta: StandardDipole(a, s, boundary_factor(eta)),
    coefficient,
    coefficient,
    st.floats(0.7, 2.5),
)


def _radii(profile, count=4000):
    """Radii, in lengths of the medium, over which R falls by everything that float64 shows."""
    far = 60.0 / profile.sigma_tr + 1e5 * profile.z_virtual
    return np.geomspace(1e-6 * profile.z_real, far, count)


@settings(max_examples=60, deadline=None)
@given(mediums)
def test_profile_integrates_to_its_albedo(profile):
    # over ln r, where the integrand r 2 pi r R is smooth
    r = _radii(profile, 20_000)
    total = integrate.simpson(2 * math.pi * r * r * profile.eval(r), x=np.log(r))
    assert total == pytest.approx(profile.albedo(), rel=1e-4)


@settings(max_examples=60, deadline=None)
@given(mediums)
def test_profile_is_never_negative_and_falls(profile):
    values = profile.eval(_radii(profile))
    assert np.all(values >= 0)
    assert np.all(np.diff(values) <= 1e-12 * values[0])
    assert 0 <= profile.albedo() <= 1


@settings(max_examples=60, deadline=None)
@given(mediums)
def test_pdf_is_the_derivative_of_the_cdf_and_the_normalised_profile(profile):
    r = np.geomspace(0.03 * profile.z_real, 5 * profile.z_virtual, 50)
    step = 1e-4 * r
    slope = (profile.cdf(r + step) - profile.cdf(r - step)) / (2 * step)
    np.testing.assert_allclose(profile.pdf(r), slope, rtol=1e-4, atol=1e-8 / profile.z_real)
    if profile.albedo() > 1e-12:
        np.testing.assert_allclose(
            profile.pdf(r), 2 * math.pi * r * profile.eval(r) / profile.albedo(), rtol=1e-6
        )


@settings(max_examples=60, deadline=None)
@given(mediums)
def test_cdf_goes_from_nothing_to_all(profile):
    values = profile.cdf(_radii(profile))
    assert profile.cdf(0.0) == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(values) >= -1e-9)
    assert values[-1] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("sigma_a", [1e-6, 0.01, 1.0, 100.0])
@pytest.mark.parametrize("eta", [1.0, 1.3, 1.5])
def test_samples_follow_the_pdf(sigma_a, eta):
    """Kolmogorov-Smirnov; a right program fails with probability 1e-3 a case, were the seed drawn anew."""
    profile = StandardDipole(sigma_a, 1.0, boundary_factor(eta))
    u, v = np.random.default_rng(7).random((2, 20_000))
    assert stats.kstest(profile.sample(u, v), profile.cdf).pvalue > 1e-3


@pytest.mark.parametrize("sigma_a", [1e-6, 1e-3, 0.02, 3.0, 100.0])
def test_samples_invert_each_pole_far_into_its_tail(sigma_a):
    profile = StandardDipole(sigma_a, 1.0, boundary_factor(1.3))
    u = np.append(np.linspace(0, 0.999, 1000), 1 - np.geomspace(1e-3, 1e-7, 20))
    for v, z in ((0.0, profile.z_real), (1.0, profile.z_virtual)):
        d = np.hypot(profile.sample(u, v), z)
        beyond = z / d * np.exp(-profile.sigma_tr * (d - z))
        np.testing.assert_allclose(1 - beyond, u, atol=1e-7)


@pytest.mark.parametrize("channel", range(3))
def test_skim_milk_reflects_what_was_published(channel):
    sigma_a, reduced = SKIM_MILK[0][channel], SKIM_MILK[1][channel]
    profile = StandardDipole(sigma_a, reduced, boundary_factor(1.3))
    assert profile.albedo() == pytest.approx(PUBLISHED[channel], abs=2e-3)


def test_limits():
    factor = boundary_factor(1.3)
    assert StandardDipole(0.0, 1.0, factor).albedo() == pytest.approx(1.0)  # nothing absorbed: all comes back
    assert StandardDipole(1.0, 0.0, factor).albedo() == 0.0
    assert StandardDipole(0.0, 0.0, factor).albedo() == 0.0  # glass: nothing scattered
    for r in (0.0, 1e-30, 1.0, 1e30):
        for sigma_a, reduced in ((0.0, 1.0), (1.0, 0.0), (0.0, 0.0), (1e4, 1e4), (1e-4, 1e-4)):
            profile = StandardDipole(sigma_a, reduced, factor)
            for value in (profile.eval(r), profile.pdf(r), profile.cdf(r), profile.sample(0.99, 0.5)):
                assert math.isfinite(value), (sigma_a, reduced, r)


def test_scaling_the_coefficients_scales_the_lengths():
    one, ten = StandardDipole(0.02, 1.0, 2.0), StandardDipole(0.2, 10.0, 2.0)
    assert ten.albedo() == pytest.approx(one.albedo())
    assert ten.eval(0.3) == pytest.approx(100 * one.eval(3.0))
    assert ten.sample(0.4, 0.2) == pytest.approx(one.sample(0.4, 0.2) / 10)


def test_drjit_arrays_and_floats_give_the_same():
    import mitsuba as mi

    sigma_a, reduced = SKIM_MILK
    spectrum = StandardDipole(mi.Color3f(sigma_a), mi.Color3f(reduced), 2.0)
    for i in range(3):
        one = StandardDipole(sigma_a[i], reduced[i], 2.0)
        for name, arguments in (
            ("eval", (1.5,)),
            ("pdf", (1.5,)),
            ("cdf", (1.5,)),
            ("albedo", ()),
            ("sample", (0.3, 0.6)),
        ):
            assert getattr(spectrum, name)(*arguments)[i][0] == pytest.approx(
                getattr(one, name)(*arguments), rel=2e-5
            ), name
