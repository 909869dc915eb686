"""Laws of the directional dipole: reciprocity where it is claimed, energy's sign, symmetry, and its formula."""

import math

import numpy as np
import pytest

from nephrite.physics.fresnel import c1, c2, lobe_normalization, reflectance
from nephrite.profiles.directional import DirectionalDipole, ReciprocalDirectionalDipole

BOTH = pytest.mark.parametrize("kind", [DirectionalDipole, ReciprocalDirectionalDipole])
MEDIA = [(0.05, 1.0, 1.3, 0.0), (0.4, 0.3, 1.5, 0.6), (1e-5, 2.0, 1.0, 0.0), (0.1, 1.0, 0.8, 0.0)]


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def pairs(count=400, seed=3):
    """Points on a bumpy surface with normals, and directions from the upper hemispheres."""
    rng = np.random.default_rng(seed)
    result = []
    for _ in range(2):
        x = rng.uniform(-3.0, 3.0, (count, 3)) * (1.0, 1.0, 0.2)
        n = unit(np.array([0.0, 0.0, 1.0]) + 0.4 * rng.normal(size=(count, 3)))
        w = unit(n + 0.9 * unit(rng.normal(size=(count, 3))))
        result.append((x, n, w))
    return result


@pytest.mark.parametrize("medium", MEDIA)
def test_the_reciprocal_one_is_reciprocal_and_the_plain_one_not(medium):
    (x_i, n_i, w_i), (x_o, n_o, w_o) = pairs()
    model = ReciprocalDirectionalDipole(*medium)
    there, back = model.eval(x_i, n_i, w_i, x_o, n_o, w_o), model.eval(x_o, n_o, w_o, x_i, n_i, w_i)
    assert np.count_nonzero(there) > 150
    np.testing.assert_allclose(there, back, rtol=1e-12)
    plain = DirectionalDipole(*medium)
    there, back = plain.eval(x_i, n_i, w_i, x_o, n_o, w_o), plain.eval(x_o, n_o, w_o, x_i, n_i, w_i)
    assert not np.allclose(there, back, rtol=0.05)


@BOTH
@pytest.mark.parametrize("medium", [*MEDIA, (0.0, 1.0, 1.3, 0.0), (1.0, 0.0, 1.3, 0.0), (0.0, 0.0, 1.3, 0.0)])
def test_values_are_numbers_and_none_is_negative(kind, medium):
    model = kind(*medium)
    (x_i, n_i, w_i), (x_o, n_o, w_o) = pairs()
    up, side = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    for arguments in (
        (x_i, n_i, w_i, x_o, n_o, w_o),
        (x_i, n_i, w_i, x_i, n_i, w_i),  # the same point
        (0 * up, up, side, side, up, up),  # grazing
        (0 * up, up, up, -up, -up, -up),  # right through, along the normal
        (0 * up, up, up, 1e-9 * side, up, up),
        (0 * up, up, up, 1e6 * side, up, up),
    ):
        values = model.eval(*arguments)
        assert np.all(np.isfinite(values))
        assert np.all(np.asarray(values) >= 0.0)
        if medium[1] == 0.0:
            assert np.all(np.asarray(values) == 0.0)
    below = model.eval(0 * up, up, -up, side, up, up), model.eval(0 * up, up, up, side, up, -up)
    assert below == (0.0, 0.0)


@BOTH
def test_turning_moving_and_scaling_change_nothing(kind):
    (x_i, n_i, w_i), (x_o, n_o, w_o) = pairs()
    expected = kind(0.05, 1.0, 1.3, 0.4).eval(x_i, n_i, w_i, x_o, n_o, w_o)
    turn = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))[0]
    shift = np.array([3.0, -1.0, 2.0])
    turned = [v @ turn for v in (x_i, n_i, w_i, x_o, n_o, w_o)]
    turned[0], turned[3] = turned[0] + shift, turned[3] + shift
    np.testing.assert_allclose(kind(0.05, 1.0, 1.3, 0.4).eval(*turned), expected, rtol=1e-8, atol=1e-15)
    scaled = kind(0.5, 10.0, 1.3, 0.4).eval(0.1 * x_i, n_i, w_i, 0.1 * x_o, n_o, w_o)
    np.testing.assert_allclose(scaled, 100.0 * expected, rtol=1e-9)


def test_s_is_exitance_between_two_transmittances():
    model = DirectionalDipole(0.05, 1.0, 1.3)
    (x_i, n_i, w_i), (x_o, n_o, w_o) = pairs()
    factor = (1 - reflectance((n_i * w_i).sum(-1), 1.3)) * (1 - reflectance((n_o * w_o).sum(-1), 1.3))
    expected = factor * model.exitance(x_i, n_i, w_i, x_o, n_o) / (math.pi * lobe_normalization(1.3))
    np.testing.assert_allclose(model.eval(x_i, n_i, w_i, x_o, n_o, w_o), expected, rtol=1e-12)


def test_sources_are_fluence_and_its_gradient():
    """Fluence of a ray source and, by finite differences, the flux that it sends through a surface."""
    medium = (0.2, 1.0, 1.3)
    model, diffusion, falloff = DirectionalDipole(*medium), 1.0 / 3.6, math.sqrt(3.0 * 0.2 * 1.2)
    rng = np.random.default_rng(6)
    x, beam, n = rng.uniform(-2, 2, (50, 3)), unit(rng.normal(size=(50, 3))), unit(rng.normal(size=(50, 3)))

    def fluence(x):
        r = np.linalg.norm(x, axis=-1)
        direction = 3.0 * diffusion * (1.0 + falloff * r) * (x * beam).sum(-1) / r**2
        return np.exp(-falloff * r) / (4.0 * math.pi * diffusion * r) * (1.0 + direction)

    flux = -diffusion * (fluence(x + 1e-5 * n) - fluence(x - 1e-5 * n)) / 2e-5
    expected = 0.25 * (1.0 - 2.0 * c1(1.3)) * fluence(x) + 0.5 * (1.0 - 3.0 * c2(1.3)) * flux
    found = model._source(*(tuple(v.T) for v in (x, beam, n)), (x * x).sum(-1)) / (4.0 * math.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)


def flat_total(model, w):
    """Integral of the exitance over a plane."""
    r = np.geomspace(1e-3, 1e4, 500)
    angle = 2.0 * math.pi * (np.arange(48) + 0.5) / 48
    x = np.stack([r[:, None] * np.cos(angle), r[:, None] * np.sin(angle), np.zeros((r.size, 48))], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    values = model.exitance(np.zeros(3), up, w, x, up, w)
    return float(np.sum(values.mean(axis=1) * r * r) * 2.0 * math.pi * math.log(r[1] / r[0]))


@pytest.mark.parametrize(
    ("albedo", "total"),
    [(0.5, 0.224), (0.8, 0.356), (0.95, 0.602), (0.99, 0.871), (0.999, 1.103), (1.0, 1.240)],
)
def test_a_plane_sends_out_what_the_documentation_says(albedo, total):
    """More than it should, that is: no paper promises energy. On a plane both kinds agree if w_i and w_o do."""
    up, slanted = np.array([0.0, 0.0, 1.0]), unit(np.array([0.5, 0.2, 1.0]))
    medium = (1.0 - albedo, albedo, 1.3)
    assert flat_total(DirectionalDipole(*medium), up) == pytest.approx(total, abs=2e-3)
    plain = flat_total(DirectionalDipole(*medium), slanted)
    assert flat_total(ReciprocalDirectionalDipole(*medium), slanted) == pytest.approx(plain, rel=1e-9)


def test_slanted_light_leaves_further_ahead():
    """The beam goes on into the medium away from where it comes from."""
    model, up = DirectionalDipole(0.05, 1.0, 1.3), np.array([0.0, 0.0, 1.0])
    w, ahead = unit(np.array([-1.0, 0.0, 0.5])), np.array([1.5, 0.0, 0.0])
    assert model.exitance(0 * up, up, w, ahead, up) > 1.1 * model.exitance(0 * up, up, w, -ahead, up)


@BOTH
def test_drjit_vectors_and_numpy_give_the_same_and_derivatives(kind):
    import drjit as dr
    from drjit.llvm.ad import Array3f64, Float64

    (x_i, n_i, w_i), (x_o, n_o, w_o) = pairs(20)
    arrays = (x_i, n_i, w_i, x_o, n_o, w_o)
    expected = kind(0.05, 1.0, 1.3, 0.2).eval(*arrays)
    vectors = [Array3f64(v.T) for v in arrays]
    numbers = kind(0.05, 1.0, 1.3, 0.2).eval(*vectors)
    np.testing.assert_allclose(
        numbers.numpy(), expected, rtol=1e-7
    )  # Fresnel's index is in single precision there
    medium = {"sigma_a": Float64(0.05), "sigma_s": Float64(1.0), "eta": Float64(1.3), "g": Float64(0.2)}
    dr.enable_grad(list(medium.values()), vectors[3])
    value = kind(*medium.values()).eval(*vectors)
    np.testing.assert_allclose(value.numpy(), expected, rtol=1e-12)
    dr.backward(dr.sum(value))

    def total(sigma_a=0.05, sigma_s=1.0, eta=1.3, g=0.2, shift=0.0):
        moved = x_o + np.array([shift, 0.0, 0.0])
        return float(np.sum(kind(sigma_a, sigma_s, eta, g).eval(x_i, n_i, w_i, moved, n_o, w_o)))

    for found, name, at in (
        *((dr.grad(x)[0], name, x[0]) for name, x in medium.items()),
        (dr.sum(dr.grad(vectors[3]).x)[0], "shift", 0.0),
    ):
        slope = (total(**{name: at + 1e-6}) - total(**{name: at - 1e-6})) / 2e-6
        assert found == pytest.approx(slope, rel=1e-5)
