"""Lamps on their own: those that are met by a formula are seen where the search tree would find them."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.relighting import stage

TURNED = [[0.8, 0.0, 0.6, 1.0], [0.0, 2.0, 0.0, 2.0], [-0.6, 0.0, 0.8, 3.0], [0.0, 0.0, 0.0, 1.0]]
SLANTED = [[1.0, 0.7, 0.0, 1.0], [0.0, 1.0, 0.0, 2.0], [0.3, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]]


@pytest.mark.parametrize(
    ("kind", "to_world"),
    [("rectangle", TURNED), ("rectangle", SLANTED), ("disk", TURNED), ("sphere", np.diag([2.0, 2.0, 2.0, 1.0])),
     ("cylinder", np.eye(4)), ("cube", TURNED)],
)  # fmt: skip
def test_lamps_are_seen_where_they_are(kind, to_world):
    """Neither beyond the ends of rays, nor from behind."""
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 2.0, 3.0]}}
    shape = mi.load_dict({"type": kind, "to_world": mi.ScalarTransform4f(to_world), "emitter": emitter})
    lamp = stage.Lamp(shape.emitter(), shape)
    rng = np.random.default_rng(3)
    middle = np.array(to_world)[:3, 3:]
    origin, target = (middle + rng.normal(0, width, (3, 20_000)) for width in (5.0, 0.7))
    ray: Any = mi.Ray3f(mi.Point3f(origin), dr.normalize(mi.Vector3f(target - origin)))
    ray.maxt = mi.Float(rng.uniform(1, 12, 20_000))
    found = np.array(lamp.seen(ray))
    si = stage._scene([shape]).ray_intersect(ray)
    expected = np.array(dr.select(si.is_valid(), shape.emitter().eval(si), 0))
    assert 0.05 < np.mean(expected[0] > 0) < 0.9
    assert np.mean(np.abs(found - expected).max(axis=0) > 1e-6) < 1e-3  # but for rays along an edge


def test_a_formula_is_used_for_the_light_of_the_benchmark():
    turn = mi.ScalarTransform4f().look_at([-90, 160, -90], [0, 30, 0], [0, 1, 0]).scale(35)
    shape = mi.load_dict({"type": "rectangle", "to_world": turn, "emitter": {"type": "area"}})
    assert stage.Lamp(shape.emitter(), shape)._by_formula()
