"""The multipole's totals have a closed form of their own; a thick slab is a dipole."""

import math

import numpy as np
import pytest

from nephrite.profiles import StandardDipole
from nephrite.profiles.multipole import Multipole


def totals(absorbed, boundary, thickness):
    """Both fluxes of the slab in one dimension, where the fluence is a difference of exponentials."""
    outside = 2.0 / 3.0 * boundary
    scattered = -math.expm1(-thickness)
    depth = 1.0 - thickness * math.exp(-thickness) / scattered
    whole, strength = thickness + 2.0 * outside, (1.0 - absorbed) * scattered
    near, far = outside + depth, outside + thickness - depth
    if absorbed == 0.0:
        return strength * far / whole, strength * near / whole
    s = math.sqrt(3.0 * absorbed)
    scale = strength * math.cosh(s * outside) / math.sinh(s * whole)
    return scale * math.sinh(s * far), scale * math.sinh(s * near)


@pytest.mark.parametrize("absorbed", [0.0, 1e-5, 0.01, 0.2, 0.9])
@pytest.mark.parametrize("thickness", [0.01, 0.3, 1.0, 5.0, 30.0])
@pytest.mark.parametrize("boundary", [1.0, 2.7])
def test_totals_are_those_of_infinitely_many_poles(absorbed, thickness, boundary):
    profile = Multipole(absorbed, 1.0 - absorbed, boundary, thickness)
    reflected, transmitted = totals(absorbed, boundary, thickness)
    assert profile.albedo() == pytest.approx(reflected, rel=1e-5)
    assert profile.transmitted().albedo() == pytest.approx(transmitted, rel=1e-4)


@pytest.mark.parametrize("absorbed", [0.0, 1e-4, 0.1])
def test_a_thick_slab_is_the_standard_dipole(absorbed):
    r = np.geomspace(0.01, 30.0, 50)
    dipole = StandardDipole(absorbed, 1.0 - absorbed, 2.0)
    for thickness in (math.inf, 1e6):
        slab = Multipole(absorbed, 1.0 - absorbed, 2.0, thickness)
        np.testing.assert_allclose(slab.eval(r), dipole.eval(r), rtol=1e-4)
        np.testing.assert_allclose(slab.cdf(r), dipole.cdf(r), atol=5e-4)
    assert Multipole(0.1, 0.9, 2.0).transmitted().albedo() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("thickness", [0.0, 1e-6, 0.2, 3.0, 100.0])
def test_without_absorption_all_that_scatters_leaves(thickness):
    profile = Multipole(0.0, 1.0, 2.0, thickness)
    leaves = profile.albedo() + profile.transmitted().albedo()
    assert leaves == pytest.approx(-math.expm1(-thickness), rel=1e-9, abs=1e-15)
    assert np.all(np.isfinite(profile.eval(np.array([0.0, 1.0]))))


def test_light_that_crosses_a_thin_slab_spreads_like_what_returns():
    """With its only source in the middle, a slab does not tell its faces apart."""
    r = np.geomspace(0.01, 3.0, 20)
    profile = Multipole(0.01, 0.99, 2.0, 1e-3)
    np.testing.assert_allclose(profile.eval(r), profile.transmitted().eval(r), rtol=1e-3)


def test_the_far_field_decays_as_in_one_dimension():
    """Far out only the slowest mode is left: e^(-pi r / L) / sqrt(r), L the thickness between vanishing fluences."""
    boundary, thickness = 1.0, 2.0
    profile = Multipole(0.0, 1.0, boundary, thickness)
    whole = thickness + 4.0 / 3.0 * boundary
    near, far = profile.eval(np.array([2.0, 4.0]) * whole)
    assert near / far == pytest.approx(math.exp(2.0 * math.pi) * math.sqrt(2.0), rel=0.05)


def test_thickness_can_vary_and_be_differentiated():
    import drjit as dr
    from drjit.llvm.ad import Float64

    thickness = Float64(0.5, 2.0, 8.0)
    dr.enable_grad(thickness)
    total = Multipole(0.1, 0.9, 2.0, thickness).transmitted().albedo()
    dr.backward(total)
    for i, t in enumerate((0.5, 2.0, 8.0)):
        plus, minus = (Multipole(0.1, 0.9, 2.0, t + d).transmitted().albedo() for d in (1e-5, -1e-5))
        assert dr.grad(thickness)[i] == pytest.approx((plus - minus) / 2e-5, rel=1e-5)
