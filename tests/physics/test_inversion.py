"""The maps that other renderers ship, against the exact one, and media from what a map finds."""

import math

import drjit as dr
import numpy as np
import pytest
from drjit.scalar import ArrayXf

from nephrite.physics import inversion
from nephrite.physics.color import albedo_to_color

COLORS = np.linspace(0.0, 1.0, 21)


def test_drjit_textures_go_through_the_same_map():
    for function, tolerance in ((inversion.chiang_albedo, 2e-6), (inversion.van_de_hulst_albedo, 1e-5)):
        result = function(ArrayXf(COLORS))
        assert dr.is_array_v(result)
        np.testing.assert_allclose(np.array(result), function(COLORS), atol=tolerance)


@pytest.mark.parametrize("g", [0.0, 0.5, 0.9])
def test_van_de_hulst_is_the_exact_map_without_an_interface(g):
    albedo = inversion.van_de_hulst_albedo(COLORS, g)
    shown = albedo_to_color(albedo * (1 - g) / (1 - g * albedo), 1.0, g)
    np.testing.assert_allclose(shown, COLORS, atol=2.5e-3)


def test_chiang_is_near_the_exact_map_without_an_interface():
    """Least near to white, which it cannot reach."""
    shown = albedo_to_color(inversion.chiang_albedo(COLORS), 1.0)
    np.testing.assert_allclose(shown[COLORS <= 0.8], COLORS[COLORS <= 0.8], atol=0.01)
    assert inversion.chiang_albedo(1.0) == pytest.approx(0.9989, abs=1e-4)


def test_a_medium_has_the_falloff_and_the_radius():
    falloff = (0.0, 0.7, math.sqrt(3.0))
    medium = inversion.medium_from_falloff(falloff, (2.0, 3.0, 0.0), 0.5, 1.4)
    found = [tr / t for tr, t in zip(medium.sigma_tr, medium.sigma_t_prime, strict=True)]
    assert found == pytest.approx(falloff)
    assert medium.sigma_t_prime == pytest.approx((1 / 2.0, 1 / 3.0, 1 / inversion.MIN_RADIUS))
    assert (medium.sigma_a[0], medium.sigma_s[2], medium.g, medium.eta) == (0.0, 0.0, 0.5, 1.4)
