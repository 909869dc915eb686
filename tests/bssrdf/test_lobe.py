"""Laws of the exit lobe and of its memory of direction."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import lobe
from nephrite.physics import fresnel

ETAS = (1.0, 1.1, 1.3, 1.5, 2.4)


def _hemisphere(cosines=200, angles=16):
    """Directions and weights of a product quadrature over the upper hemisphere: (N, 3), (N,) in sr."""
    x, weight = np.polynomial.legendre.leggauss(cosines)
    # nodes crowd towards the horizon (cos = u^2), where the Fresnel term rises
    u = 0.5 * (x + 1)
    cosine, weight = u * u, u * weight
    phi = 2 * np.pi * (np.arange(angles) + 0.5) / angles
    c, p = (a.ravel() for a in np.meshgrid(cosine, phi, indexing="ij"))
    s = np.sqrt(1 - c * c)
    return np.stack([s * np.cos(p), s * np.sin(p), c], 1), np.repeat(weight, angles) * 2 * np.pi / angles


def _density(directions, eta):
    one = lobe.exit_lobe(eta)
    cosine = directions[:, 2]
    value = lobe.pdf(mi.Float(cosine), mi.Float(fresnel.reflectance(cosine, eta)), one.normalization)
    return np.array(value)


def _kernel(v, w, eta, linear=1.0, quadratic=1.0):
    """Kernel of every v with every w: (len(v), len(w))."""
    one = lobe.exit_lobe(eta)
    every_v, every_w = np.repeat(v, len(w), axis=0), np.tile(w, (len(v), 1))
    n = mi.Vector3f(0, 0, 1)
    value = lobe.kernel(mi.Vector3f(every_v.T), mi.Vector3f(every_w.T), n, one.m2, one.m4, linear, quadratic)
    return np.array(value).reshape(len(v), len(w))


def _directions(count=64):
    """Random directions of the upper hemisphere, the normal and a grazing one among them."""
    directions = np.random.default_rng(11).normal(size=(count, 3))
    directions[:, 2] = np.abs(directions[:, 2])
    directions[:2] = (0, 0, 1), (1, 0, 1e-3)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.parametrize("eta", ETAS)
def test_pdf_integrates_to_one(eta):
    directions, weight = _hemisphere()
    assert weight @ _density(directions, eta) == pytest.approx(1.0, abs=1e-4)


def test_a_rarer_inside_is_normalised_within_a_thousandth():
    # total reflection from the outside leaves a kink in the integrand
    for eta in (0.5, 0.7, 0.9):
        assert lobe.exit_lobe(eta).normalization == pytest.approx(fresnel.lobe_normalization(eta), abs=1e-3)


@pytest.mark.parametrize("eta", ETAS)
def test_pdf_is_normalised_by_the_external_reflectance(eta):
    # with the internal one everything would be 1.8 times too bright at 1.3
    assert lobe.exit_lobe(eta).normalization == pytest.approx(fresnel.lobe_normalization(eta), abs=1e-5)


def test_nothing_leaves_below_the_horizon():
    assert np.all(np.array(lobe.pdf(mi.Float([-1.0, -0.1, 0.0]), mi.Float(0.1), 0.9)) == 0)


@pytest.mark.parametrize("eta", ETAS)
def test_moments_are_those_of_the_lobe(eta):
    directions, weight = _hemisphere()
    density = weight * _density(directions, eta)
    r2 = directions[:, 0] ** 2 + directions[:, 1] ** 2
    one = lobe.exit_lobe(eta)
    assert one.m2 == pytest.approx(density @ r2, abs=1e-4)
    assert one.m4 == pytest.approx(density @ r2**2, abs=1e-4)


def test_a_matched_surface_has_lamberts_moments():
    one = lobe.exit_lobe(1.0)
    assert one.normalization == pytest.approx(1.0)
    assert (one.m2, one.m4) == (pytest.approx(1 / 2), pytest.approx(1 / 3))


@pytest.mark.parametrize("eta", ETAS)
@pytest.mark.parametrize(("linear", "quadratic"), [(1.0, 1.0), (0.7, 0.2), (0.0, 0.0)])
def test_kernel_makes_and_loses_no_light(eta, linear, quadratic):
    directions, weight = _hemisphere()
    mean = _kernel(_directions(), directions, eta, linear, quadratic) @ (weight * _density(directions, eta))
    np.testing.assert_allclose(mean, 1.0, atol=5e-4)


@pytest.mark.parametrize("eta", ETAS)
def test_kernel_reproduces_every_quadratic_radiance(eta):
    """Orthonormality: the mean of kernel(v, w) f(w) under the lobe is f(v) for the six functions of the expansion."""
    directions, weight = _hemisphere()
    v = _directions()

    def functions(d):
        x, y = d[:, 0], d[:, 1]
        return np.stack([np.ones_like(x), x, y, x * x + y * y, x * x - y * y, x * y], -1)

    mean = _kernel(v, directions, eta) @ (
        (weight * _density(directions, eta))[:, None] * functions(directions)
    )
    np.testing.assert_allclose(mean, functions(v), atol=2e-3)


@pytest.mark.parametrize("eta", ETAS)
def test_the_usual_direction_is_the_mean_under_the_lobe(eta):
    """Radiance `1 + 3 u.w` inside, u = drift / 2, which leaves through the interface."""
    drift = np.array([0.2, -0.1, 0.3])
    directions, weight = _hemisphere()
    inside = 1 + 1.5 * (directions[:, :2] / eta) @ drift[:2]
    one = lobe.exit_lobe(eta)
    mean = (weight * _density(directions, eta) * inside) @ directions[:, :2]
    usual = np.array(lobe.usual(mi.Vector3f(drift.tolist()), eta, one.m2)).ravel()
    np.testing.assert_allclose(usual[:2], mean, atol=1e-4)


@pytest.mark.parametrize("eta", ETAS)
def test_the_kernel_has_the_usual_direction_where_the_own_is_forgotten(eta):
    usually, one = np.array([0.1, 0.05, 0.0]), lobe.exit_lobe(eta)
    directions, weight = _hemisphere()
    n, v = mi.Vector3f(0, 0, 1), mi.Vector3f(0.6, 0, 0.8)
    value = lobe.kernel(
        v, mi.Vector3f(directions.T), n, one.m2, one.m4, 0.0, 0.0, mi.Vector3f(usually.tolist())
    )
    mean = (weight * _density(directions, eta) * np.array(value)) @ directions
    np.testing.assert_allclose(mean[:2], usually[:2], atol=1e-4)


@pytest.mark.parametrize("steps", [8, 40])
def test_walks_have_come_by_half_their_mean_direction(steps):
    """Regression of the last direction on displacement over length; false alarms below 1e-5 (5 standard errors)."""
    rng = np.random.default_rng(5)
    count = 100_000
    direction = rng.normal(size=(count, steps, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    length = rng.exponential(size=(count, steps, 1))
    drift = (direction * length).sum(1) / length.sum(1)
    product, square = (direction[:, -1] * drift).sum(1), (drift**2).sum(1)
    slope = product.mean() / square.mean()
    error = (product - slope * square).std() / np.sqrt(count) / square.mean()
    # n <l^2> = 2 n l^2 in n^2 l^2 (1 + 1/n): steps of a given number, whose length varies
    assert abs(slope - 0.5) < 0.6 / steps + 5 * error


def test_kernel_is_symmetric_and_turns_with_its_frame():
    rng = np.random.default_rng(3)
    v, w, n = rng.normal(size=(3, 3))
    v, w, n = (x / np.linalg.norm(x) for x in (v, w, n))
    one = lobe.exit_lobe(1.3)

    def value(a, b, c):
        a, b, c = (mi.Vector3f(x.tolist()) for x in (a, b, c))
        return lobe.kernel(a, b, c, one.m2, one.m4)[0]

    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    assert value(v, w, n) == pytest.approx(value(w, v, n), rel=1e-4)
    assert value(v, w, n) == pytest.approx(value(turn @ v, turn @ w, turn @ n), rel=1e-4)


def test_memory_fades_with_reduced_order():
    linear, quadratic = (np.array(x) for x in lobe.memory(mi.Float([0, 1, 10, 100, 1e6]), mi.Float(0.0)))
    for values in (linear, quadratic):
        assert values[0] == 1
        assert np.all(np.diff(values) < 0)
        assert values[-1] == pytest.approx(0)
    assert np.all(quadratic <= linear)
    forward = lobe.memory(mi.Float(50.0), mi.Float(0.8))[0]
    assert forward[0] == pytest.approx(lobe.memory(mi.Float(10.0), mi.Float(0.0))[0][0], rel=1e-5)


def test_lobes_are_computed_once():
    assert lobe.exit_lobe(1.37) is lobe.exit_lobe(1.37)
    assert dr.is_array_v(lobe.pdf(mi.Float(0.5), 0.0, 1.0))
