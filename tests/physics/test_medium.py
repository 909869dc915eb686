import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nephrite.errors import ParameterError
from nephrite.physics import Medium

DERIVED = ["sigma_t", "albedo", "mfp", "sigma_s_prime", "sigma_t_prime", "albedo_prime", "sigma_tr", "dmfp"]
coefficient = st.one_of(st.just(0.0), st.floats(1e-12, 1e12))


def test_derived_coefficients_of_a_known_medium():
    medium = Medium((0.5, 0.0, 1.0), (2.0, 4.0, 0.0), g=0.75, eta=1.5)
    assert medium.sigma_t == (2.5, 4.0, 1.0)
    assert medium.albedo == (0.8, 1.0, 0.0)
    assert medium.mfp == (0.4, 0.25, 1.0)
    assert medium.sigma_s_prime == (0.5, 1.0, 0.0)
    assert medium.sigma_t_prime == (1.0, 1.0, 1.0)
    assert medium.albedo_prime == (0.5, 1.0, 0.0)
    assert medium.sigma_tr == pytest.approx((math.sqrt(1.5), 0.0, math.sqrt(3)))
    assert medium.dmfp == pytest.approx((1 / math.sqrt(1.5), math.inf, 1 / math.sqrt(3)))


def test_skim_milk_has_the_published_diffuse_reflectance():
    medium = Medium((0.0014, 0.0025, 0.0142), (0.70, 1.22, 1.90), eta=1.3)
    assert medium.diffuse_reflectance == pytest.approx((0.815, 0.813, 0.682), abs=6e-4)


def test_diffuse_reflectance_is_the_integral_of_the_dipole():
    from scipy.integrate import quad

    from nephrite.physics.fresnel import boundary_factor

    medium = Medium(0.05, 0.9, eta=1.4)
    zr = 1 / medium.sigma_t_prime[0]
    zv = zr * (1 + 4 / 3 * boundary_factor(1.4))
    k, albedo = medium.sigma_tr[0], medium.albedo_prime[0]

    def ring(r):
        terms = [(z, math.hypot(r, z)) for z in (zr, zv)]
        return 2 * math.pi * r * albedo / (4 * math.pi) * sum(
            z * (1 + k * d) * math.exp(-k * d) / d**3 for z, d in terms
        )  # fmt: skip

    total = quad(ring, 0, 20)[0] + quad(ring, 20, math.inf)[0]
    assert medium.diffuse_reflectance[0] == pytest.approx(total, rel=1e-7)


def test_empty_and_extreme_channels_never_warn_or_fail():
    empty = Medium(0, 0)
    assert (
        empty.albedo == empty.albedo_prime == empty.sigma_tr == empty.diffuse_reflectance == (0.0, 0.0, 0.0)
    )
    assert empty.mfp == empty.dmfp == (math.inf,) * 3
    white = Medium(0, 10)
    assert white.diffuse_reflectance == white.albedo == (1.0, 1.0, 1.0)
    black = Medium(10, 0)
    assert black.diffuse_reflectance == black.albedo == (0.0, 0.0, 0.0)
    assert black.dmfp == pytest.approx((1 / math.sqrt(300),) * 3)


@given(coefficient, coefficient, st.floats(-0.99, 0.99), st.floats(0.5, 3))
def test_laws_for_any_medium(sigma_a, sigma_s, g, eta):
    medium = Medium(sigma_a, sigma_s, g, eta)
    for name in DERIVED:
        values = getattr(medium, name)
        assert len(values) == 3
        assert all(isinstance(v, float) and v >= 0 for v in values)
    assert 0 <= medium.albedo[0] <= 1
    assert 0 <= medium.albedo_prime[0] <= 1
    assert 0 <= medium.diffuse_reflectance[0] <= 1 + 1e-12
    assert medium.diffuse_reflectance[0] <= medium.albedo_prime[0] + 1e-12


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_reflectance_does_not_know_units(sigma_a, factor):
    medium = Medium(sigma_a, 1.0)
    assert medium.scaled(factor).diffuse_reflectance == pytest.approx(medium.diffuse_reflectance, rel=1e-9)
    assert medium.scaled(factor).dmfp[0] * factor == pytest.approx(medium.dmfp[0], rel=1e-9)


def test_from_reduced_undoes_the_reduction():
    medium = Medium.from_reduced((0.1, 0.2, 0.3), (1.0, 2.0, 3.0), g=0.9, eta=1.4)
    assert medium.sigma_s_prime == pytest.approx((1.0, 2.0, 3.0))
    assert medium.sigma_s == pytest.approx((10.0, 20.0, 30.0))
    assert (medium.g, medium.eta) == (0.9, 1.4)


def test_numbers_arrays_and_lists_are_the_same():
    assert Medium(1, 2) == Medium([1, 1, 1], np.array([2.0, 2.0, 2.0])) == Medium(np.float32(1), (2, 2, 2))
    assert hash(Medium(1, 2)) == hash(Medium((1, 1, 1), 2))
    assert dataclasses.replace(Medium(1, 2), g=0.5) == Medium(1, 2, g=0.5)
    with pytest.raises(dataclasses.FrozenInstanceError):
        Medium(1, 2).g = 0.3  # type: ignore[misc]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sigma_a": -0.1}, "sigma_a .*negative"),
        ({"sigma_s": (1, 2, -3)}, "sigma_s .*negative"),
        ({"sigma_a": math.nan}, "sigma_a .*finite"),
        ({"sigma_s": math.inf}, "sigma_s .*finite"),
        ({"sigma_s": (1, 2)}, "sigma_s .*three"),
        ({"sigma_a": "red"}, "sigma_a .*three"),
        ({"sigma_a": "1"}, "sigma_a .*three"),
        ({"sigma_a": None}, "sigma_a"),
        ({"g": 1.0}, "g is 1.0"),
        ({"g": -1.0}, "g is -1.0"),
        ({"g": math.nan}, "g is nan"),
        ({"eta": 0.0}, "eta is 0.0"),
        ({"eta": -1.3}, "eta is -1.3"),
        ({"eta": math.inf}, "eta is inf"),
    ],
)
def test_impossible_media_are_refused(arguments, message):
    with pytest.raises(ParameterError, match=message):
        Medium(**({"sigma_a": 0.1, "sigma_s": 1.0} | arguments))
