"""Queries find what a search through all nodes finds, and never what lies on the far side."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.transport.nearby import Nearby

REACH = 0.2


def _surface(shift=0.0, count=3000):
    """Return points on both sides of a thin leaf, moved along x, and their normals."""
    rng = np.random.default_rng(5)
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    points = np.column_stack([rng.uniform(-1, 1, (count, 2)), 0.001 * side]) + np.array([shift, 0.0, 0.0])
    return points, np.column_stack([np.zeros((count, 2)), side])


def _query(count=500):
    rng = np.random.default_rng(6)
    side = np.where(rng.random(count) < 0.5, 1.0, -1.0)
    return np.column_stack([rng.uniform(-0.95, 0.95, (count, 2)), 0.001 * side]), side


def _up(side):
    return mi.Vector3f(0.0, 0.0, mi.Float(side))


def test_nearest_is_what_a_search_through_all_nodes_finds():
    one, two = _surface(), _surface(shift=10.0)
    nearby = Nearby([(*one, REACH), (*two, 0.5 * REACH)])
    p, side = _query()
    for number, shift in enumerate((0.0, 10.0)):
        at = p + np.array([shift, 0.0, 0.0])
        found = np.array(
            nearby.nearest(mi.UInt32(number), mi.Point3f(at.T), _up(side), dr.full(mi.Bool, True, len(p)))
        )
        apart = np.linalg.norm(nearby.points[None] - at[:, None], axis=2)
        apart[nearby.normals[None, :, 2] != side[:, None]] = np.inf
        near = apart.min(1) < 0.5 * REACH
        assert near.mean() > 0.9
        assert (found == apart.argmin(1))[near].all()


def test_a_mean_is_exact_for_what_is_constant_on_each_side_and_smooth():
    nearby = Nearby([(*_surface(), REACH)])
    values = np.repeat(nearby.normals[:, None, 2:], 4, axis=1) * np.array([1.0, 2.0, 3.0])
    table = mi.Float(values.astype(np.float32).ravel())
    p, side = _query()
    active = dr.full(mi.Bool, True, len(p))
    means = nearby.mean(mi.UInt32(0), mi.Point3f(p.T), _up(side), table, active)
    for mean in means:
        assert side[:, None] * [1.0, 2.0, 3.0] == pytest.approx(np.array(mean).T, abs=2e-3)
    x = np.linspace(-0.5, 0.5, 4001)
    line = np.column_stack([x, 0.1 + 0 * x, 0.001 + 0 * x])
    slope = np.repeat(nearby.points[:, None, :], 4, axis=1)
    table = mi.Float(slope.astype(np.float32).ravel())
    active = dr.full(mi.Bool, True, len(x))
    along = nearby.mean(mi.UInt32(0), mi.Point3f(line.T), _up(np.ones(len(x))), table, active)[0]
    assert np.abs(np.diff(np.array(along.x))).max() < 10 * (x[1] - x[0])  # no jumps between cells
