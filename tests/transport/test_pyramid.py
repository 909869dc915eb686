"""The stored operator: it makes of light what the walks make of it, with less noise."""

import numpy as np
import pytest

from nephrite.transport.counted import Walks
from nephrite.transport.grids import Grids
from nephrite.transport.nodes import interpolation
from nephrite.transport.pyramid import Pyramid
from support import nodes

SPACING, EACH, FREE = 0.05, 64, 0.05


def _walks(points, seed, along=0.0, begun=EACH):
    """Return walks from every node of a plane to places around it, of weight 1 in half of all cases."""
    rng = np.random.default_rng(seed)
    start = np.repeat(np.arange(len(points)), begun)
    target = points[start, :2] + rng.normal(0.0, 0.1, (len(start), 2)) * rng.choice(
        [0.5, 1.5], (len(start), 1)
    )
    end = np.concatenate(
        [
            np.linalg.norm(points[None, :, :2] - part[:, None], axis=2).argmin(1)
            for part in np.array_split(target, 64)
        ]
    )
    weight = (rng.random(len(start)) < 0.5) * np.ones((3, 1), np.float32)
    length = np.linalg.norm(points[start] - points[end], axis=1)
    direction = np.zeros((3, len(start)), np.float32)
    direction[0] = along
    return Walks(start, end, length, weight, direction, direction)


def _operator(plane, seed, along=0.0):
    return Pyramid.of(
        Grids.over(*plane, SPACING), FREE, _walks(plane[0], seed, along), np.full(len(plane[0]), EACH)
    )


@pytest.fixture(scope="module")
def plane():
    return nodes.plane(SPACING)


def _arriving(points, mean, moment=0.0):
    arriving = np.zeros((len(points), 4, 3))
    arriving[:, 0] = np.reshape(mean, (-1, 1))
    arriving[:, 1] = moment
    return arriving


def test_even_light_stays_even(plane):
    """Half of it arrives, and little is left of the noise of each node's own 64 walks, .063."""
    operator = _operator(plane, 1)
    found = operator.apply(_arriving(plane[0], 1.0))[:, 0]
    inner = np.abs(plane[0]).max(1) < 0.6
    assert found.mean() == pytest.approx(0.5, rel=0.01)
    assert found[inner].std() < 0.01


def test_where_more_walks_begin_no_more_light_arrives(plane):
    """Four times as many on one side, and the same half of even light on both, and where they meet."""
    points = plane[0]
    begun = np.where(points[:, 0] > 0, 128, 32)
    walks = _walks(points, 7, begun=begun)
    found = Pyramid.of(Grids.over(*plane, SPACING), FREE, walks, begun).apply(_arriving(points, 1.0))[:, 0]
    inner = np.abs(points[:, 1]) < 0.6
    for low, high in ((-0.6, -0.2), (-0.2, 0.2), (0.2, 0.6)):
        strip = inner & (points[:, 0] >= low) & (points[:, 0] < high)
        assert found[strip].mean() == pytest.approx(0.5, rel=0.015)


def test_what_comes_of_the_light_that_scatters_twice_is_smooth_where_its_share_is_not(plane):
    """The share rises fourfold on .4, cells are as wide: within .05 of sums over the walks, in strips of 110 nodes.

    Divided by the nodes' own shares, light that is averaged over cells would be .13 too bright in the strip at -.25.
    """
    points = plane[0]
    second = 0.625 + 0.375 * np.tanh(points[:, 0] / 0.15)
    walks = _walks(points, 8)
    carried = walks.weight[0] * second[walks.end]
    exact = np.bincount(walks.start, carried, len(points)) / EACH
    walks.weight = (carried * second[walks.start] * np.ones((3, 1))).astype(np.float32)
    begun = np.full(len(points), EACH)
    operator = Pyramid.of(Grids.over(*plane, SPACING), FREE, walks, begun, second[:, None] * np.ones(3))
    found = operator.apply(_arriving(points, 1.0))[:, 0, 0]
    inner = np.abs(points[:, 1]) < 0.7
    for low in np.arange(-0.6, 0.6, 0.1):
        strip = inner & (points[:, 0] >= low) & (points[:, 0] < low + 0.1)
        assert found[strip].mean() == pytest.approx(exact[strip].mean(), abs=0.05)


def test_it_is_linear_and_its_channels_are_their_own(plane):
    operator = _operator(plane, 2)
    rng = np.random.default_rng(3)
    a, b = (rng.random((len(plane[0]), 4, 3)) for _ in range(2))
    np.testing.assert_allclose(
        operator.apply(a + 2 * b), operator.apply(a) + 2 * operator.apply(b), atol=2e-4
    )
    b[:, :, 1:] = a[:, :, 1:]
    np.testing.assert_array_equal(operator.apply(a)[:, :, 1:], operator.apply(b)[:, :, 1:])


def test_an_edge_of_light_is_where_the_walks_take_it(plane):
    """Beside sums over the walks themselves, in strips of some 110 nodes: within four standard errors, .006 each."""
    points = plane[0]
    walks = _walks(points, 4)
    lit = (points[:, 0] > 0).astype(float)
    found = Pyramid.of(Grids.over(*plane, SPACING), FREE, walks, np.full(len(points), EACH)).apply(
        _arriving(points, lit)
    )[:, 0, 0]
    exact = np.bincount(walks.start, walks.weight[0] * lit[walks.end], len(points)) / EACH
    inner = np.abs(points[:, 1]) < 0.7
    for low in np.arange(-0.4, 0.4, 0.1):
        strip = inner & (points[:, 0] >= low) & (points[:, 0] < low + 0.1)
        assert found[strip].mean() == pytest.approx(exact[strip].mean(), abs=0.024)


def test_directions_are_remembered_at_both_ends(plane):
    """Walks with a memory of .5 along x bring .5 x .5 of the moment of 1, and see .5 of that along x."""
    operator = _operator(plane, 5, along=0.5)
    found = operator.apply(_arriving(plane[0], 1.0, moment=1.0))
    assert found[:, 0].mean() == pytest.approx(0.5 * (1.0 + 0.5), rel=0.02)
    assert found[:, 1].mean() == pytest.approx(0.5 * 0.5 * (1.0 + 0.5), rel=0.02)
    assert np.abs(found[:, 2:]).max() == 0.0


def test_the_coarse_operator_is_the_same_for_wide_light(plane):
    operator = _operator(plane, 6)
    wide = operator.averaged((1.0 + plane[0][:, 0]).astype(np.float32))
    fine = operator.apply(_arriving(plane[0], operator.interpolated(wide)))[:, 0, 0]
    inner = np.abs(operator.averaged(plane[0][:, 0].astype(np.float32))) < 0.5
    ratio = (operator.coarse()[0] @ wide)[inner] / operator.averaged(fine)[inner]
    assert np.abs(ratio.mean() - 1) < 0.02


def test_interpolation_is_a_mean_and_knows_sides():
    points = np.array([[0.0, 0, 0], [0.3, 0, 0], [0.0, 0, 0.01], [5.0, 0, 0]])
    normals = np.array([[0, 0, -1.0], [0, 0, -1.0], [0, 0, 1.0], [0, 0, 1.0]])
    matrix = interpolation(
        np.array([[0.1, 0, 0], [9.0, 0, 0]]), np.array([[0, 0, -1.0], [0, 0, 1.0]]), points, normals, 0.5
    )
    rows = matrix.toarray()
    np.testing.assert_allclose(rows.sum(1), 1.0, rtol=1e-6)
    assert rows[0, 0] > rows[0, 1] > 0.1
    assert rows[0, 2] < 1e-5
    assert rows[1, 3] == 1.0
