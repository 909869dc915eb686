"""Crowding: nothing sends out more than arrives, and what is smooth and thick is left alone."""

import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import auto
from nephrite.plugins.conserve import _jump, conserve
from nephrite.plugins.crowding import Crowding
from nephrite.plugins.media import Media
from support import scenes


def _media(shape, sigma_a, sigma_s, model="dipole"):
    description = scenes.camera(8)
    description["object"] = scenes.placed(shape) | scenes.translucent(sigma_a, sigma_s)
    scene = mi.load_dict(description)
    media = Media.of(scene)
    auto.choose(model, media, scene)
    return media, scene


def test_a_ratio_is_found_where_it_was_put():
    crowding = Crowding(2)
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (20000, 3)) * [4.0, 2.0, 1.0]
    ratios = np.where(points[:, :1] > 0, [2.0, 3.0, 1.0], [0.5, 1.0, 1.0]) * 0.985
    crowding.estimate(2, mi.ScalarBoundingBox3f([-4, -2, -1], [4, 2, 1]), points, ratios)
    at = mi.Point3f([3.0, -3.0], [0.5, 0.5], [0.2, 0.2])
    found = np.exp2(np.array(crowding.logarithm(mi.UInt32(2), at)))
    assert found[:, 0] == pytest.approx([2.0, 3.0, 1.0], rel=1e-3)
    assert found[:, 1] == pytest.approx([1.0, 1.0, 1.0], rel=1e-3)  # never below 1
    assert np.all(np.array(crowding.logarithm(mi.UInt32(1), at)) == 0)


def test_a_thick_smooth_object_is_not_crowded():
    media, scene = _media("sphere", 0.02, 5.0)
    conserve(media, scene)
    (shape,) = media.entries[0].shapes
    si, _ = _jump(media, 1, scene, shape)
    assert np.array(media.crowding.logarithm(mi.UInt32(1), si.p)).max() < 0.02


@pytest.mark.parametrize("model", ["dipole", "photon_beam", "directional"])
def test_what_jumps_bring_is_no_more_than_what_arrives(model):
    """On a thin plate without absorption, where each would bring more (mean of 2^18 jumps)."""
    media, scene = _media("slab", 0.0, 0.8, model)
    (shape,) = media.entries[0].shapes
    before = np.array(_jump(media, 1, scene, shape)[1]).mean()
    conserve(media, scene)
    after = np.array(_jump(media, 1, scene, shape)[1]).mean()
    print(model, before, after)
    assert before > 1.05
    assert 0.9 < after < 1.0
