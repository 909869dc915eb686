"""The laws of radial profiles, for every model: a new one is tested by being in MODELS."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace
from nephrite.profiles import MODELS, RadialProfile, StandardDipole, find

# absorption, reduced scattering, eta, g
MEDIA = {
    "skin": (0.03, 0.97, 1.3, 0.0),
    "dark": (0.6, 0.4, 1.3, 0.0),
    "forward": (0.2, 1.8, 1.3, 0.5),
    "milk": (1e-5, 1.0 - 1e-5, 1.3, 0.0),
    "matched": (0.05, 0.95, 1.0, 0.0),
    "bubble": (0.1, 0.9, 0.75, 0.0),
}
# at the ends of the parameters' ranges some lengths are infinite: values must not be NaN
ENDS = {
    "white": (0.0, 1.0, 1.3, 0.0),
    "white-matched": (0.0, 1.0, 1.0, 0.0),
    "black": (1.0, 0.0, 1.3, 0.0),
    "empty": (0.0, 0.0, 1.3, 0.0),
}


def slab(sigma_a, sigma_s_prime, eta, g):
    thickness = 1.7 / namespace(sigma_a).maximum(sigma_a + sigma_s_prime, 1e-3)
    return MODELS["multipole"].make(sigma_a, sigma_s_prime, eta, g, thickness)


VARIANTS = {
    "slab": slab,
    "slab-through": lambda *medium: slab(*medium).transmitted(),
}
MAKES = {**{name: model.make for name, model in MODELS.items()}, **VARIANTS}

each = pytest.mark.parametrize("make", MAKES.values(), ids=MAKES.keys())
medium = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA.keys())


def mass(profile, r):
    return 2.0 * math.pi * r * r * np.asarray(profile.eval(r))


@each
@medium
def test_profile_integrates_to_its_albedo(make, medium):
    profile = make(*medium)
    r = np.geomspace(1e-7, 1e7, 4001)
    total = integrate.simpson(mass(profile, r), x=np.log(r))
    assert total == pytest.approx(profile.albedo(), rel=1e-4)
    assert 0.0 < profile.albedo() < 1.1


@each
@pytest.mark.parametrize("medium", [*MEDIA.values(), *ENDS.values()], ids=[*MEDIA, *ENDS])
def test_values_are_numbers_and_none_is_negative(make, medium):
    profile = make(*medium)
    r = np.array([0.0, 1e-30, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6, 1e12])
    u = np.array([0.0, 1e-9, 0.3, 0.9, 1.0 - 1e-7])
    for values in (profile.eval(r), profile.pdf(r), profile.cdf(r), profile.sample(u, u[::-1])):
        assert np.all(np.isfinite(values))
        assert np.all(np.asarray(values) >= 0.0)
    assert np.all(np.asarray(profile.cdf(r)) <= 1.0 + 1e-12)
    assert 0.0 <= profile.albedo() < 1.1
    assert 0.0 < profile.reach() < math.inf
    if medium[1] == 0.0:
        assert profile.albedo() == 0.0
        assert np.all(np.asarray(profile.eval(r)) == 0.0)


@each
@medium
def test_profile_falls(make, medium):
    """From where a simulation tells distances apart; nearer, R is flat, or grows like a logarithm or 1/r."""
    values = make(*medium).eval(np.geomspace(0.02, 30.0, 300))
    assert np.all(np.diff(values) <= 1e-9 * values[0])


@each
@medium
def test_cdf_grows_from_nothing_to_all_and_pdf_is_its_slope(make, medium):
    profile = make(*medium)
    assert profile.cdf(0.0) == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(profile.cdf(np.geomspace(1e-6, 1e6, 500))) >= -1e-6)
    assert profile.cdf(1e8) == pytest.approx(1.0, abs=1e-4)
    r = np.geomspace(0.01, 20.0, 40)
    slope = (profile.cdf(1.001 * r) - profile.cdf(0.999 * r)) / 0.002
    np.testing.assert_allclose(slope, r * profile.pdf(r), rtol=2e-3, atol=2e-4)
    np.testing.assert_allclose(r * profile.pdf(r), mass(profile, r) / profile.albedo(), rtol=1e-3, atol=1e-9)


@each
@medium
def test_samples_follow_the_profile(make, medium):
    """Chi-square; a right program fails with probability 1e-4 a case, 6e-3 in all, were the seed drawn anew."""
    profile = make(*medium)
    fixed, drawn = (
        np.random.default_rng(11).random((2, 20_000)),
        np.random.default_rng(12).random((2, 20_000)),
    )
    # edges from one half of the samples, counts from the other
    assert profile.sample(*fixed).shape == (20_000,)
    edges = np.quantile(profile.sample(*fixed), np.linspace(0.0, 1.0, 31)[1:-1])
    radii = profile.sample(*drawn)
    expected, low = [], 1e-7
    for high in [*edges, 1e7]:
        r = np.geomspace(low, high, 401)
        expected.append(integrate.simpson(mass(profile, r), x=np.log(r)))
        low = high
    seen = np.histogram(radii, [0.0, *edges, np.inf])[0]
    assert stats.chisquare(seen, np.array(expected) / sum(expected) * radii.size).pvalue > 1e-4


@each
def test_scaling_the_coefficients_scales_the_lengths(make):
    one, ten = make(0.1, 0.9, 1.3, 0.5), make(1.0, 9.0, 1.3, 0.5)
    assert ten.albedo() == pytest.approx(one.albedo())
    assert ten.eval(0.3) == pytest.approx(100.0 * one.eval(3.0))
    assert ten.cdf(0.3) == pytest.approx(one.cdf(3.0))
    assert ten.sample(0.4, 0.2) == pytest.approx(one.sample(0.4, 0.2) / 10.0)


@each
def test_arrays_broadcast_to_what_numbers_give(make):
    """As the integrator tabulates: [A, 1] of albedos against [1, N] of distances."""
    albedos, r = np.array([[0.0], [0.4], [0.99], [1.0]]), np.array([[0.01, 0.5, 20.0]])
    profile = make(1.0 - albedos, albedos, 1.3, 0.5)
    for name in ("eval", "cdf", "pdf"):
        values = getattr(profile, name)(r)
        for i, j in ((1, 0), (2, 1), (3, 2), (1, 2), (0, 1)):
            one = getattr(make(1.0 - albedos[i, 0], albedos[i, 0], 1.3, 0.5), name)(r[0, j])
            assert values[i, j] == pytest.approx(one, rel=1e-9, abs=1e-12)
            assert isinstance(one, float)
    assert np.shape(profile.albedo() + 0.0 * albedos) == (4, 1)
    assert profile.sample(0.0 * r + 0.3, 0.6).shape == (4, 3)


CALLS = {"eval": (0.7,), "albedo": (), "cdf": (0.7,), "pdf": (0.7,), "sample": (0.4, 0.3), "reach": ()}


@each
def test_drjit_and_numpy_give_the_same(make):
    import mitsuba as mi
    from drjit.llvm import Float64

    a, s = [0.3, 0.01, 0.0], [0.7, 1.5, 0.0]
    numbers = [make(a[i], s[i], 1.3, 0.5) for i in range(3)]
    doubles = make(Float64(a), Float64(s), 1.3, 0.5)
    singles = make(mi.Color3f(a), mi.Color3f(s), 1.3, 0.5)
    for name, arguments in CALLS.items():
        expected = [getattr(one, name)(*arguments) for one in numbers]
        high = getattr(doubles, name)(*(Float64(x, x, x) for x in arguments)).numpy()
        np.testing.assert_allclose(high, expected, rtol=1e-7, atol=1e-15, err_msg=name)
        low = np.ravel(getattr(singles, name)(*(mi.Float(x) for x in arguments)).numpy())
        np.testing.assert_allclose(low, expected, rtol=1e-3, atol=1e-6, err_msg=name)


@each
def test_derivatives_match_finite_differences(make):
    import drjit as dr
    from drjit.llvm.ad import Float64

    start, step = (0.15, 1.1, 1.3, 0.5), 1e-5
    for name, arguments in CALLS.items():
        if name == "reach":
            continue

        def value(parameters, name=name):
            return getattr(make(*parameters[:4]), name)(*parameters[4:])

        point = [*start, *arguments]
        if name == "sample" and value(point) != value([*point[:5], 0.9]):
            continue  # the choice between parts has no derivative
        expected = []
        for i in range(len(point)):
            plus, minus = list(point), list(point)
            plus[i], minus[i] = point[i] + step, point[i] - step
            expected.append((value(plus) - value(minus)) / (2.0 * step))
        variables = [Float64(x) for x in point]
        dr.enable_grad(variables)
        dr.backward(value(variables))
        found = [dr.grad(x)[0] for x in variables]
        np.testing.assert_allclose(found, expected, rtol=5e-4, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("name", MODELS)
def test_derivatives_are_those_upwards_where_tables_begin(name):
    """At g = 0; and near eta = 1, where Fresnel's factors bend."""
    import drjit as dr
    from drjit.llvm.ad import Float64

    make, step = MODELS[name].make, 1e-5
    for index, point in ((3, [0.15, 1.1, 1.3, 0.0]), (2, [0.15, 1.1, 1.001, 0.3])):
        number = Float64(point[index])
        dr.enable_grad(number)
        varied = [*point[:index], number, *point[index + 1 :]]
        value = make(*varied).eval(0.7)
        if index == 3 and name in ("dipole", "better_dipole", "multipole"):
            assert not dr.is_array_v(value)  # they know of no g
            continue
        dr.backward(value)
        values = []
        for k in range(3):
            varied[index] = point[index] + k * step
            values.append(make(*varied).eval(0.7))
        slope = (4.0 * values[1] - values[2] - 3.0 * values[0]) / (2.0 * step)
        assert dr.grad(number)[0] == pytest.approx(slope, rel=1e-3, abs=1e-7)


def test_an_index_belongs_to_a_material():
    from drjit.llvm.ad import Float64

    for name, model in MODELS.items():
        with pytest.raises(ParameterError, match=r"eta is \[1.3, 1.5\]"):
            model.make(0.1, 1.0, Float64(1.3, 1.5))
        if name not in ("dipole", "better_dipole", "multipole"):
            with pytest.raises(ParameterError, match=r"g is \[0.0, 0.5\]"):
                model.make(0.1, 1.0, 1.3, Float64(0.0, 0.5))


class OnlyValues(RadialProfile):
    """What a model without closed forms is: the defaults against the dipole's own."""

    def __init__(self, *medium):
        self.dipole = StandardDipole(*medium)

    def eval(self, r):
        return self.dipole.eval(r)

    def reach(self):
        return self.dipole.reach()


@pytest.mark.parametrize("sigma_a", [0.0, 1e-4, 0.05, 5.0])
def test_defaults_reproduce_closed_forms(sigma_a):
    numeric, closed = OnlyValues(sigma_a, 1.0, 2.5), StandardDipole(sigma_a, 1.0, 2.5)
    r = np.geomspace(1e-3, 100.0, 60)
    assert numeric.albedo() == pytest.approx(closed.albedo(), rel=2e-5)
    np.testing.assert_allclose(numeric.cdf(r), closed.cdf(r), atol=3e-5)
    np.testing.assert_allclose(numeric.pdf(r), closed.pdf(r), rtol=2e-5)
    u = np.linspace(0.01, 0.99, 50)
    np.testing.assert_allclose(closed.cdf(numeric.sample(u)), u, atol=3e-5)


def test_models_describe_themselves():
    for name, model in MODELS.items():
        assert model.name == name
        assert find(name) is model
        assert model.terms in ("multiple", "single+multiple")
        assert "" not in (model.title, model.source)
        assert isinstance(model.make(0.1, 1.0, 1.3), RadialProfile)
    with pytest.raises(ParameterError, match="Did you mean 'photon_beam'"):
        find("photonbeam")
