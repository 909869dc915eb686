"""What faces through a body: the derivatives of the Green's function where the bracket is exact, and its laws."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import finite

SIGMA_TR = 0.8


def _facing(x, n_x, y, n_y, sigma_tr=SIGMA_TR):
    offset, n_o, n_i = (mi.Vector3f(*np.asarray(v, float).T) for v in (np.subtract(y, x), n_x, n_y))
    return np.array(finite.facing(offset, n_o, n_i, mi.Float(sigma_tr)))


def _derivative(x, n_x, y, n_y, step=1e-3):
    """Second difference of exp(-k d) / d along both normals, over what it is on a plane for the same distance."""

    def green(a, b):
        d = np.linalg.norm(np.subtract(y, x) + np.multiply(b, n_y) - np.multiply(a, n_x), axis=-1)
        return np.exp(-SIGMA_TR * d) / d

    mixed = green(step, step) - green(step, -step) - green(-step, step) + green(-step, -step)
    d = np.linalg.norm(np.subtract(y, x), axis=-1)
    plane = np.exp(-SIGMA_TR * d) * (1 + SIGMA_TR * d) / d**3
    return mixed / (4 * step**2) / plane


def test_it_is_the_derivative_along_both_normals_on_a_sphere():
    angles = np.linspace(0.6, np.pi, 20)
    n_y = np.stack([np.sin(angles), np.cos(angles), 0 * angles], axis=-1)
    n_x = np.tile([0.0, 1.0, 0.0], (20, 1))
    for radius in (0.5, 3.0):
        found = _facing(radius * n_x, n_x, radius * n_y, n_y)
        assert found == pytest.approx(_derivative(radius * n_x, n_x, radius * n_y, n_y), rel=1e-4)
        assert found.max() > 1.9


def test_it_is_the_derivative_straight_through_a_slab():
    up, down = [[0.0, 0.0, 1.0]], [[0.0, 0.0, -1.0]]
    top, bottom = [[0.0, 0.0, 2.0]], [[0.0, 0.0, 0.0]]
    found = _facing(top, up, bottom, down)
    assert found == pytest.approx(_derivative(top, up, bottom, down), rel=1e-4)


def test_it_is_1_on_a_plane_and_where_the_line_leaves_the_body():
    up, side = [[0.0, 0.0, 1.0]], [[-1.0, 0.0, 0.0]]
    assert _facing([[0.0, 0.0, 0.0]], up, [[3.0, 1.0, 0.0]], up) == pytest.approx(1.0)
    assert _facing([[0.0, 0.0, 0.0]], up, [[3.0, 0.0, 3.0]], side) == pytest.approx(
        1.0
    )  # up a wall, through air


def test_it_is_reciprocal():
    rng = np.random.default_rng(3)
    x, y, n_x, n_y = rng.normal(size=(4, 100, 3))
    n_x, n_y = (n / np.linalg.norm(n, axis=1, keepdims=True) for n in (n_x, n_y))
    there, back = _facing(x, n_x, y, n_y), _facing(y, n_y, x, n_x)
    assert there == pytest.approx(back, rel=1e-5)
    assert (there >= 1).all()


def test_the_same_point_is_no_nan():
    up = mi.Vector3f(0, 0, 1)
    value = finite.facing(mi.Vector3f(0, 0, 0), up, up, mi.Spectrum(1.0))
    assert dr.all(value == 1.0, axis=None)
