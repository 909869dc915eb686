"""Light that comes to a point: it is asked for where it brings something, and what is in the way is seen."""

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.plugins.exits import unblocked

POINTS = 10_000


def _shaded_plane():
    """Return a lamp and a sky over a plane, which a disk shades in part."""
    return mi.load_dict(
        {
            "type": "scene",
            "lamp": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
                "emitter": {"type": "area", "radiance": 3.0},
            },
            "sky": {"type": "constant", "radiance": 0.5},
            "disk": {"type": "disk", "to_world": mi.ScalarTransform4f().translate([0.5, 0, 1])},
            "plane": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale([4, 4, 1])},
        }
    )


def test_it_agrees_with_the_scene_s_own_shadow_rays():
    scene = _shaded_plane()
    numbers = np.random.default_rng(1).uniform(-2, 2, (2, POINTS)).astype(np.float32)
    down = mi.Ray3f(mi.Point3f(mi.Float(numbers[0]), mi.Float(numbers[1]), 0.5), mi.Vector3f(0, 0, -1))
    at = scene.ray_intersect(down)
    u = mi.Point2f(np.random.default_rng(2).random((2, POINTS)))

    _, expected = scene.sample_emitter_direction(at, u, True)
    ds, light = scene.sample_emitter_direction(at, u, False)
    above = dr.dot(ds.d, at.n) > 0
    found = unblocked(scene, at, ds, dr.select(above, light, 0), mi.Bool(True))

    np.testing.assert_array_equal(found, dr.select(above, expected, 0))
    shaded = (np.array(light) > 0).all(0) & (np.array(found) == 0).all(0) & np.array(above)
    assert 0.01 * POINTS < shaded.sum() < 0.5 * POINTS


def test_light_may_be_taken_away():
    """A lobe that remembers its direction is negative in some: what it takes counts as what it gives does."""
    scene = _shaded_plane()
    at = scene.ray_intersect(mi.Ray3f(mi.Point3f(-2, 0, 0.5), mi.Vector3f(0, 0, -1)))
    ds, light = scene.sample_emitter_direction(at, mi.Point2f(0.2, 0.5), False)
    assert np.min(light) > 0
    np.testing.assert_array_equal(unblocked(scene, at, ds, -light, mi.Bool(True)), -light)


def test_what_is_not_asked_for_is_nothing():
    scene = _shaded_plane()
    at = scene.ray_intersect(mi.Ray3f(mi.Point3f(-2, 0, 0.5), mi.Vector3f(0, 0, -1)))
    ds, light = scene.sample_emitter_direction(at, mi.Point2f(0.2, 0.5), False)
    np.testing.assert_array_equal(unblocked(scene, at, ds, light, mi.Bool(False)), 0)
