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


def _beside(nearby, p, up, count, seed=7):
    """Return nodes found beside each of the points `count` times, [points, count]."""
    many = np.repeat(p, count, axis=0)
    u = np.random.default_rng(seed).random((2, len(many))).astype(np.float32)
    active = dr.full(mi.Bool, True, len(many))
    normal = _up(np.repeat(up, count))
    found = nearby.beside(mi.UInt32(0), mi.Point3f(many.T), normal, mi.Point2f(u), active)
    return np.array(found).reshape(len(p), count)


def test_what_lies_beside_a_point_faces_as_it_does_and_is_within_reach():
    nearby = Nearby([(*_surface(), REACH)])
    p, side = _query()
    found = _beside(nearby, p, side, 64)
    assert (nearby.normals[found][..., 2] == side[:, None]).all()
    assert np.linalg.norm(nearby.points[found] - p[:, None], axis=2).max() < 1.5 * REACH


def test_beside_an_edge_nodes_are_found_too():
    points, normals = _surface()
    right, up = points[:, 0] > 0, normals[:, 2] > 0
    nearby = Nearby([(points[right & up], normals[right & up], REACH)])  # nothing at all to the left
    found = _beside(nearby, np.array([[0.001, 0.0, 0.001], [0.001, 0.5, 0.001]]), np.ones(2), 4096)
    assert (
        np.linalg.norm(nearby.points[found][:, :, :2] - [[[0.0, 0.0]], [[0.0, 0.5]]], axis=2).max()
        < 2 * REACH
    )


@pytest.mark.slow
def test_in_the_mean_what_is_looked_up_beside_a_point_is_smooth_in_it():
    """A ramp is found again within 3 % of reach: its steps from node to node, of .04, are not."""
    nearby = Nearby([(*_surface(), REACH)])
    x = np.linspace(-0.5, 0.5, 401)
    line = np.column_stack([x, 0.1 + 0 * x, 0.001 + 0 * x])
    found = nearby.points[_beside(nearby, line, np.ones(len(x)), 1 << 14)][..., 0].mean(axis=1)
    assert np.abs(found - x).max() < 0.03 * REACH
    assert np.abs(np.diff(found)).max() < 2 * (x[1] - x[0])


def test_vectors_are_gathered_from_where_it_is_done_at_once():
    """Dr.Jit does so at multiples of 64 bytes; elsewhere by another kernel, which chance has compiled anew."""
    kept = [Nearby([(*_surface(count=20), REACH)]) for _ in range(10)]
    for nearby in kept:
        for table in (nearby._place, nearby._layout):
            assert np.array(table, copy=False).ctypes.data % 64 == 0
