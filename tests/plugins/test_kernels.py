"""The jump's tables on the device: what they hold is the model's, in scene units, and reciprocal where it varies."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import kernel
from nephrite.plugins.kernels import HalfSpaces, _flat
from nephrite.profiles import MODELS


class _Entry:
    def __init__(self, eta, g):
        self.eta, self.g = eta, g


def _place(kernels, number, sigma_a, sigma_s_prime, g=0.0):
    sigma_s = mi.Spectrum(sigma_s_prime) / (1 - g)
    return kernels.place(mi.UInt32(number), mi.Spectrum(sigma_a), sigma_s, mi.Float(g))


@pytest.mark.parametrize("model", MODELS)
def test_lookups_are_the_models_values(model):
    """Less than 1 % of the light that leaves the plane leaves elsewhere."""
    kernels = HalfSpaces([_Entry(1.5, 0.0), _Entry(1.3, 0.5)], model)
    extinction = 2.5
    r = np.geomspace(0.005, 100, 400)
    for number, (eta, g) in enumerate(((1.5, 0.0), (1.3, 0.5)), start=1):
        for absorbed in (0.001, 0.01, 0.1, 0.4):
            place = _place(kernels, number, absorbed * extinction, (1 - absorbed) * extinction, g)
            found = np.exp2(np.array(kernels.log_kernel(place, mi.Float(r)))[0])
            exact = kernel.multiple(model, 1 - absorbed, extinction * r, eta, g) * extinction**2
            ring = r**2  # even in ln r: an area of 2 pi r dr
            assert np.sum(np.abs(found - exact) * ring) < 0.01 * np.sum(exact * ring)


def test_empty_channels_send_nothing():
    kernels = HalfSpaces([_Entry(1.3, 0.0)], "dipole")
    place = _place(kernels, 1, [1.0, 0.0, 0.5], [0.0, 0.0, 0.5])
    value = np.exp2(np.array(kernels.log_kernel(place, mi.Float([0.1, 1.0, 10.0]))))
    assert np.all(np.isfinite(value))
    assert np.all(value[0] < 1e-20)
    assert np.all(value[2] > 0)
    for channel in kernels.poles(place):
        assert all(np.isfinite(np.array(part)).all() for part in channel)


def test_jumps_draw_distances_that_their_density_states():
    """Over a plane: the mean of 1 / density over what is drawn within a disc is its area (4 sigma: 6e-5)."""
    from nephrite.bssrdf import probe

    kernels = HalfSpaces([_Entry(1.3, 0.0)], "dipole")
    place = _place(kernels, 1, 0.02, 1.0)
    (first, second, share), *_ = kernels.poles(place)
    rng = np.random.default_rng(2)
    count = 1 << 18
    z = dr.select(mi.Float(rng.random(count)) < share, first, second)
    r = np.array(probe.distance(z, mi.Float(rng.random(count))))
    flat = sum(
        float(s[0]) * float(d[0]) / (2 * np.pi * (r**2 + float(d[0]) ** 2) ** 1.5)
        for s, d in ((share, first), (1 - share, second))
    )
    inside = np.where(r < 3.0, 1 / flat, 0)
    assert float(inside.mean()) == pytest.approx(np.pi * 9, abs=4 * float(inside.std()) / count**0.5)


def test_a_vectors_table_is_aligned_and_whole():
    """Dr.Jit gathers vectors at once from there; from elsewhere by another kernel, which chance has compiled anew."""
    tables = [np.arange(12.0).reshape(3, 4), np.arange(8.0)]
    for _ in range(5):
        found = np.array(_flat(tables), copy=False)
        assert found.ctypes.data % 64 == 0
        assert np.array_equal(found, [*range(12), *range(8)])
