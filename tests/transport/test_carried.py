"""The operator made of walks: what it makes of even light, of a direction, and of noise."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.transport.carried import Carried, Walks
from support import nodes

SPACING, EACH = 0.05, 16


def _walks(points, seed, along=0.0):
    """Return walks from every node of a plane to places around it, of weight 1 in half of all cases."""
    rng = np.random.default_rng(seed)
    start = np.repeat(np.arange(len(points)), EACH)
    target = points[start, :2] + rng.normal(0.0, 0.1, (len(start), 2))
    end = np.linalg.norm(points[None, :, :2] - target[:, None], axis=2).argmin(1)
    weight = (rng.random(len(start)) < 0.5).astype(float)
    length = np.linalg.norm(points[start] - points[end], axis=1)
    direction = mi.Vector3f(along, 0.0, 0.0)
    return Walks(
        mi.UInt32(start),
        mi.UInt32(end),
        mi.Float(length),
        mi.Spectrum(mi.Float(weight)),
        direction,
        direction,
    )


def _operator(points, normals, seed, along=0.0):
    operator = Carried(points, normals, SPACING, 0.05, EACH)
    operator.add(_walks(points, seed, along))
    operator.finish()
    return operator


def _arriving(points, mean, moment=0.0):
    zeros = dr.zeros(mi.Spectrum, len(points))
    return [zeros + mean, zeros + moment, zeros, zeros]


@pytest.fixture(scope="module")
def plane():
    return nodes.plane(SPACING)


def test_even_light_stays_even(plane):
    """Half of it arrives, and little is left of the noise of each node's own 16 walks, .125."""
    found = _operator(*plane, 1).apply(_arriving(plane[0], 1.0))[:, 0]
    inner = np.abs(plane[0]).max(1) < 0.7
    assert found.mean() == pytest.approx(0.5, rel=0.01)
    assert found[inner].std() < 0.035


def test_light_is_no_wider_than_the_walks_and_keeps_its_amount(plane):
    """An edge becomes as wide as a walk is long, .1, and what averaging adds, .06 at the most."""
    points = plane[0]
    lit = mi.Float((points[:, 0] > 0).astype(float))
    found = _operator(*plane, 2).apply(_arriving(points, mi.Spectrum(lit)))[:, 0, 0]
    inner = np.abs(points[:, 1]) < 0.7
    assert found[inner & (points[:, 0] > 0.35)].mean() == pytest.approx(0.5, rel=0.03)
    assert np.abs(found[inner & (points[:, 0] < -0.35)]).max() < 0.02
    dark = inner & (points[:, 0] < 0) & (points[:, 0] > -0.5)
    assert 2.0 * found[dark].sum() / (dark.sum() * 2.0) == pytest.approx(0.5 * 0.04 / 0.5, rel=0.35)


def test_directions_are_remembered_at_both_ends(plane):
    """Walks with a memory of .5 along x bring .5 x .5 of the moment of 1, and see .5 of that along x."""
    found = _operator(*plane, 3, along=0.5).apply(_arriving(plane[0], 1.0, moment=1.0))
    assert found[:, 0].mean() == pytest.approx(0.5 * (1.0 + 0.5), rel=0.02)
    assert found[:, 1].mean() == pytest.approx(0.5 * 0.5 * (1.0 + 0.5), rel=0.02)
    assert np.abs(found[:, 2:]).max() == 0.0
