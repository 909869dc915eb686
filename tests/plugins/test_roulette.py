"""Roulette: who is spared from it, whom it thins out, and that light which it has thinned out stays as much.

The statistical test fails a right program with probability `measure.FALSE_ALARM`; its seeds are fixed.
"""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import roulette
from support import measure, scenes


def _entering(worth, of_camera=1.0, depth=1):
    return np.array(roulette.entering(mi.Float(worth), of_camera, mi.UInt32(depth)))


def test_paths_from_the_camera_all_begin_a_walk():
    assert np.all(_entering([1e-3, 0.5, 2.0], depth=0) == 1)


@pytest.mark.parametrize("of_camera", [1e-3, 1.0, 1e3])
def test_after_a_bounce_as_many_begin_one_as_light_is_left(of_camera):
    chances = _entering(np.array([0.0, 0.25, 1.0, 3.0]) * of_camera, of_camera)
    assert chances == pytest.approx([0, 0.25, 1, 1])


def test_short_walks_are_thinned_out_by_their_light_alone():
    orders = mi.Float([0.0, 1.0, roulette.ORDER])
    assert np.all(np.array(roulette.walking(mi.Float(roulette.SHARE), mi.Float(1.0), orders)) == 1)
    assert np.all(np.array(roulette.walking(mi.Float(0.1), mi.Float(2.0), orders)) == 0.05 / roulette.SHARE)


def test_four_times_as_long_walks_are_half_as_many():
    order = mi.Float([1.0, 4.0, 16.0]) * roulette.ORDER
    chances = np.array(roulette.walking(mi.Float(roulette.SHARE), mi.Float(1.0), order))
    assert chances == pytest.approx([1, 0.5, 0.25])


def test_nothing_is_no_division_by_zero():
    nothing = dr.zeros(mi.Float, 1)
    assert np.array(roulette.walking(nothing, nothing, nothing)) == pytest.approx(0)
    assert _entering([0.0], 0.0) == pytest.approx(0)


@pytest.mark.slow
def test_light_that_it_has_thinned_out_is_as_much():
    """A dark wall beside a ball that the camera does not see: few paths that come to the ball from it begin a walk."""
    scene = scenes.camera(8, fov=10.0)
    wall = mi.ScalarTransform4f().translate([0, 0, -8]).scale(60)
    dark = {"type": "diffuse", "reflectance": scenes.rgb(0.2)}
    ball = {"type": "sphere", "radius": 7, "center": [13, 0, 0]}
    scene["wall"] = {"type": "rectangle", "to_world": wall, "bsdf": dark}
    scene["object"] = ball | scenes.standard((0.002, 0.01, 0.05), (5.0, 5.0, 5.0))
    scene["environment"] = scenes.environment()
    loaded = mi.load_dict(scene)
    truth = measure.passes(loaded, scenes.TRUTH, 256, 16, 1000)
    walk = measure.passes(loaded, scenes.ours(model="walk", exit="exact"), 512, 16, 5000)
    measure.assert_same(walk, truth, label="dark wall")
