import math
from itertools import pairwise

import drjit as dr
import numpy as np
import pytest
from drjit.scalar import ArrayXf
from scipy.integrate import quad

from nephrite.errors import ParameterError
from nephrite.physics import fresnel


@pytest.mark.parametrize("eta", [1.3, 1.5, 2.4, 0.75])
def test_normal_incidence_is_the_square_of_the_index_contrast(eta):
    expected = ((eta - 1) / (eta + 1)) ** 2
    assert fresnel.reflectance(1.0, eta) == pytest.approx(expected, rel=1e-12)
    assert fresnel.reflectance(-1.0, eta) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("eta", [1.05, 1.3, 1.5, 2.4, 0.75])
def test_reflection_is_the_same_from_both_ends_of_a_path(eta):
    cosine = np.linspace(0.02, 1, 50)
    refracted = fresnel.refracted_cosine(cosine, eta)
    seen = refracted > 0
    there, back = fresnel.reflectance(cosine, eta), fresnel.reflectance(-refracted, eta)
    np.testing.assert_allclose(there[seen], back[seen], atol=1e-12)


def test_total_reflection_starts_at_the_critical_angle():
    eta = 1.5
    critical = math.sqrt(1 - 1 / eta**2)
    assert fresnel.reflectance(-critical + 1e-6, eta) == 1.0
    assert fresnel.reflectance(-critical - 1e-3, eta) < 0.9
    assert fresnel.refracted_cosine(critical - 1e-6, 1 / eta) == 0.0


def test_parallel_light_passes_at_brewsters_angle():
    eta = 1.5
    cosine = 1 / math.sqrt(1 + eta**2)
    refracted = fresnel.refracted_cosine(cosine, eta)
    perpendicular = (cosine - eta * refracted) / (cosine + eta * refracted)
    assert fresnel.reflectance(cosine, eta) == pytest.approx(perpendicular**2 / 2, rel=1e-12)


def test_limits():
    assert fresnel.reflectance(0.0, 1.5) == 1.0
    np.testing.assert_array_equal(fresnel.reflectance(np.linspace(-1, 1, 9), 1.0), 0.0)
    assert isinstance(fresnel.reflectance(0.3, 1.3), float)


def test_drjit_arrays_give_what_numpy_gives():
    cosine = np.linspace(-1, 1, 41)
    result = fresnel.reflectance(ArrayXf(cosine), 1.3)
    assert dr.is_array_v(result)
    np.testing.assert_allclose(np.array(result), fresnel.reflectance(cosine, 1.3), atol=2e-6)


def integral(order, eta):
    kink = math.sqrt(max(1 - 1 / eta**2, 0.0))
    parts = [0.0, kink, 1.0] if kink else [0.0, 1e-3, 0.05, 1.0]
    return sum(
        quad(lambda mu: fresnel.reflectance(-mu, eta) * mu**order, a, b, epsabs=1e-12, limit=400)[0]
        for a, b in pairwise(parts)
    )


@pytest.mark.parametrize("eta", [0.5, 0.75, 1 / 1.3, 0.99, 1.001, 1.01, 1.3, 1.5, 2.0, 4.0])
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_moments_equal_an_adaptive_integral(order, eta):
    assert fresnel.moment(order, eta) == pytest.approx(integral(order, eta), abs=2e-9)


@pytest.mark.parametrize("eta", np.linspace(1.0, 2.0, 11).tolist())
def test_moments_agree_with_the_fits_of_deon_and_irving_inside(eta):
    e = eta
    two_c1 = -9.23372 + 22.2272 * e - 20.9292 * e**2 + 10.2291 * e**3 - 2.54396 * e**4 + 0.254913 * e**5
    three_c2 = -1641.1 + 1213.67 * e - 568.556 * e**2 + 164.798 * e**3 - 27.0181 * e**4 + 1.91826 * e**5
    three_c2 += 135.926 / e**3 - 656.175 / e**2 + 1376.53 / e
    assert 2 * fresnel.c1(e) == pytest.approx(two_c1, abs=0.006)
    assert 3 * fresnel.c2(e) == pytest.approx(three_c2, abs=0.008)


@pytest.mark.parametrize("eta", np.linspace(0.5, 0.95, 10).tolist())
def test_moments_agree_with_the_fits_of_deon_and_irving_outside(eta):
    e = eta
    two_c1 = 0.919317 - 3.4793 * e + 6.75335 * e**2 - 7.80989 * e**3 + 4.98554 * e**4 - 1.36881 * e**5
    assert 2 * fresnel.c1(e) == pytest.approx(two_c1, abs=0.002)


def test_published_diffuse_reflectances():
    assert fresnel.external_diffuse_reflectance(1.3) == pytest.approx(0.0612, abs=1e-4)
    assert fresnel.external_diffuse_reflectance(1.5) == pytest.approx(0.0918, abs=1e-4)
    assert fresnel.internal_diffuse_reflectance(1.3) == pytest.approx(0.44, abs=0.005)
    assert 1 - fresnel.lobe_normalization(1.3) == pytest.approx(0.061, abs=5e-4)
    assert 1 - fresnel.lobe_normalization(1.5) == pytest.approx(0.092, abs=5e-4)


@pytest.mark.parametrize("eta", [1.01, 1.3, 1.5, 2.0])
def test_diffuse_reflectances_satisfy_the_second_law(eta):
    # As much light must pass an interface between two black bodies one way as the other.
    inward = 1 - fresnel.external_diffuse_reflectance(eta)
    outward = eta**2 * (1 - fresnel.internal_diffuse_reflectance(eta))
    assert inward == pytest.approx(outward, rel=1e-8)


def test_boundary_factor():
    assert fresnel.boundary_factor(1.0) == 1.0
    for eta in np.linspace(1, 3, 41):
        assert fresnel.fdr(eta) == pytest.approx(fresnel.fdr_fit(eta), abs=0.0017 if eta <= 2 else 0.02)
    assert fresnel.boundary_factor(1.3) == pytest.approx(2.60, abs=0.005)


@pytest.mark.parametrize("eta", [0, -1.3, math.nan, math.inf, "glass", None])
def test_impossible_indices_are_refused(eta):
    for function in (fresnel.boundary_factor, fresnel.external_diffuse_reflectance, fresnel.fdr_fit):
        with pytest.raises(ParameterError, match="eta"):
            function(eta)


def test_out_of_range_arguments_say_the_remedy():
    with pytest.raises(ParameterError, match=r"fdr\(eta\)"):
        fresnel.fdr_fit(0.9)
    with pytest.raises(ParameterError, match="order"):
        fresnel.moment(-1, 1.3)
