"""Nodes are spread evenly, and averages over neighbours stay on their side of a thin part."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from nephrite.transport.nodes import DENSITY, interpolation, smoothing, spread, squared_distance

SPACING = 0.1


def _leaf(count=20_000):
    """Return points on both sides of a leaf, a hundredth of the spacing thick, and their normals."""
    rng = np.random.default_rng(3)
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    points = np.column_stack([rng.uniform(-1, 1, (count, 2)), 0.0005 * side])
    return points, np.column_stack([np.zeros((count, 2)), side])


def test_nodes_keep_their_distance_and_leave_no_gap():
    points, normals = _leaf()
    kept = spread(points, normals, SPACING)
    for side in (-1.0, 1.0):
        nodes, all_points = points[kept][normals[kept, 2] == side], points[normals[:, 2] == side]
        tree = KDTree(nodes)
        assert tree.query(nodes, k=2)[0][:, 1].min() > SPACING
        assert tree.query(all_points)[0].max() <= SPACING
        assert len(nodes) / 4.0 * SPACING**2 == pytest.approx(DENSITY, rel=0.15)


def test_the_first_in_a_random_order_stay():
    """Found in rounds, of parts of the points, it is what going through them one by one finds."""
    rng = np.random.default_rng(5)
    points = rng.uniform(0, 1, (2000, 3)) * [2, 2, 0.1]
    normals = rng.normal([0.0, 0.0, 1.0], 1.0, (2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    stay: list[int] = []
    for i in np.random.default_rng(0).permutation(len(points)):
        near = squared_distance(points[stay] - points[i], normals[stay], normals[i]) < SPACING**2
        if not np.any(near & (normals[stay] @ normals[i] > 0)):
            stay.append(i)
    assert np.array_equal(spread(points, normals, SPACING), np.sort(stay))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_few_points_all_stay(count):
    points, normals = np.arange(3.0 * count).reshape(count, 3), np.tile([0.0, 0.0, 1.0], (count, 1))
    assert np.array_equal(spread(points, normals, SPACING), np.arange(count))


def test_averages_keep_to_their_side():
    points, normals = _leaf()
    kept = spread(points, normals, SPACING)
    matrix = smoothing(points[kept], normals[kept], SPACING)
    assert np.asarray(matrix.sum(axis=1)).ravel() == pytest.approx(1.0, abs=1e-5)
    side = normals[kept, 2]
    assert matrix @ side == pytest.approx(side, abs=1e-5)


def test_what_lies_above_is_no_neighbour():
    """Two sheets that face the same way, nearer to each other than nodes look: each has nodes of its own."""
    points, _ = _leaf()
    sheet = np.arange(len(points)) % 2
    points[:, 2], up = 0.8 * SPACING * sheet, np.tile([0.0, 0.0, 1.0], (len(points), 1))
    kept = spread(points, up, SPACING)
    matrix = interpolation(points, up, points[kept], up[kept], 1.75 * SPACING)
    assert np.abs(matrix @ sheet[kept] - sheet).max() < 1e-5


def test_an_average_is_as_wide_as_asked_for():
    points, normals = _leaf()
    kept = spread(points, normals, SPACING)
    middle = np.flatnonzero(np.abs(points[kept]).max(1) < 0.5)
    weights = smoothing(points[kept], normals[kept], 1.5 * SPACING)[middle].toarray()
    apart = points[kept][None, :, 0] - points[kept][middle][:, None, 0]
    assert np.sqrt((weights * apart**2).sum(1).mean()) == pytest.approx(1.5 * SPACING, rel=0.1)
