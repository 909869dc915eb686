import math

import drjit as dr
import numpy as np
import pytest
from drjit.scalar import ArrayXf
from hypothesis import given
from hypothesis import strategies as st

from nephrite.errors import ParameterError
from nephrite.physics import from_albedo_and_radius, inversion
from nephrite.physics.color import albedo_to_color

ETAS = [0.7, 1.0, 1.3, 1.5, 2.0]


@given(st.floats(0, 1), st.floats(1e-3, 1e3), st.floats(-0.9, 0.95), st.floats(0.6, 2.5))
def test_round_trip_through_the_medium(albedo, radius, g, eta):
    medium = from_albedo_and_radius(albedo, radius, g, eta)
    assert medium.diffuse_reflectance[0] == pytest.approx(albedo, abs=1e-9)
    assert 1 / medium.sigma_t_prime[0] == pytest.approx(radius, rel=1e-9)
    assert (medium.g, medium.eta) == (g, eta)


@pytest.mark.parametrize("eta", ETAS)
def test_the_inverse_is_exact_over_the_whole_range(eta):
    albedo = np.concatenate([np.linspace(0, 1, 401), 1 - np.logspace(-9, -3, 20)])
    reflectance = inversion.diffuse_reflectance(albedo, eta)
    np.testing.assert_allclose(inversion.dipole_albedo(reflectance, eta), albedo, atol=1e-12)
    assert np.all(np.diff(reflectance[:401]) > 0)


def test_the_ends_are_exact():
    assert from_albedo_and_radius(1.0, 2.0).sigma_a == (0.0, 0.0, 0.0)
    black = from_albedo_and_radius(0.0, 2.0)
    assert black.sigma_s == (0.0, 0.0, 0.0)
    assert black.sigma_a == pytest.approx((0.5, 0.5, 0.5))


def test_channels_are_independent():
    medium = from_albedo_and_radius((0.1, 0.5, 0.9), (3.0, 2.0, 1.0), eta=1.5)
    assert medium.diffuse_reflectance == pytest.approx((0.1, 0.5, 0.9))
    assert medium.sigma_t_prime == pytest.approx((1 / 3, 0.5, 1.0))


def test_no_radius_becomes_diffuse():
    medium = from_albedo_and_radius((0.2, 0.5, 0.8), 0.0)
    assert medium.diffuse_reflectance == pytest.approx((0.2, 0.5, 0.8))
    assert 1 / medium.sigma_t_prime[0] == pytest.approx(inversion.MIN_RADIUS)


def test_drjit_textures_go_through_the_same_map():
    color = np.linspace(0, 1, 51)
    for function, tolerance in [
        (lambda c: inversion.dipole_albedo(c, 1.5), 2e-6),
        (inversion.chiang_albedo, 2e-6),
        (inversion.van_de_hulst_albedo, 1e-5),
        (inversion.chiang_color, 1e-5),
    ]:
        result = function(ArrayXf(color))
        assert dr.is_array_v(result)
        np.testing.assert_allclose(np.array(result), function(color), atol=tolerance)


def test_van_de_hulst_round_trip():
    color = np.linspace(0.0, 1.0, 21)
    for g in (0.0, 0.5, 0.9):
        albedo = inversion.van_de_hulst_albedo(color, g)
        np.testing.assert_allclose(inversion.van_de_hulst_color(albedo, g), color, atol=1e-4)


@pytest.mark.parametrize("albedo", [0.5, 0.8, 0.95, 0.99, 0.999])
def test_van_de_hulst_reproduces_the_exact_index_matched_half_space(albedo):
    assert inversion.van_de_hulst_color(albedo) == pytest.approx(albedo_to_color(albedo, 1.0), abs=2.5e-3)


def test_chiang_round_trip():
    color = np.linspace(0, 1, 21)
    np.testing.assert_allclose(inversion.chiang_color(inversion.chiang_albedo(color)), color, atol=1e-9)
    assert inversion.chiang_albedo(1.0) == pytest.approx(0.9989, abs=1e-4)


def test_the_index_matched_maps_agree_with_each_other_but_not_with_an_interface():
    color = np.linspace(0.1, 0.9, 9)
    chiang, hulst = inversion.chiang_albedo(color), inversion.van_de_hulst_albedo(color)
    np.testing.assert_allclose(chiang, hulst, atol=0.03)
    rendered = inversion.diffuse_reflectance(chiang, 1.5)
    assert np.max(np.abs(rendered / color - 1)) > 0.2


@pytest.mark.parametrize(
    ("albedo", "radius", "message"),
    [
        (1.2, 1.0, "albedo .*255"),
        ((0.5, 0.5, 1.01), 1.0, "albedo"),
        (-0.1, 1.0, "albedo .*negative"),
        (math.nan, 1.0, "albedo .*finite"),
        (0.5, -1.0, "radius .*negative"),
        (0.5, math.inf, "radius .*finite"),
    ],
)
def test_impossible_appearances_are_refused(albedo, radius, message):
    with pytest.raises(ParameterError, match=message):
        from_albedo_and_radius(albedo, radius)
