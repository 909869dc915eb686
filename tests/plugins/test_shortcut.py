"""Two events at once, and roulette where lights have been connected to: the light stays what it was, but for noise.

Statistical, with fixed seeds: each test fails a right program with probability `measure.FALSE_ALARM`.
"""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import glints, path, roulette
from support import measure, scenes


def _lit_from_behind(shape, material):
    """An object, with a lamp behind it that is seen straight through where it is thin."""
    scene = scenes.trial(scenes.Trial(shape, material), "translucent", resolution=12)
    lamp = {"type": "sphere", "center": [2.0, 3.0, -30.0], "radius": 3.0}
    return scene | {"behind": lamp | {"emitter": {"type": "area", "radiance": scenes.rgb(3.0)}}}


def _rendered(scene, seed):
    return measure.passes(scene, scenes.ours(model="dipole"), 512, 16, seed)


def _step_by_step(scene, media, lamps, number, ray, β, ratio, *rest):
    """Leave all to the walk."""
    nothing = mi.Float(0)
    return β, ratio, ray, nothing, mi.UInt32(0), nothing


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "material"), [("sphere", "skin"), ("slab", "skin"), ("cube", "marble")])
def test_two_events_at_once_bring_what_two_steps_bring(shape, material, monkeypatch):
    scene = mi.load_dict(_lit_from_behind(shape, material))
    at_once = _rendered(scene, 100)
    monkeypatch.setattr(path, "hurry", _step_by_step)
    measure.assert_same(at_once, _rendered(scene, 500), label=f"{shape}, {material}")


@pytest.mark.slow
def test_what_roulette_spares_brings_as_much(monkeypatch):
    scene = mi.load_dict(_lit_from_behind("sphere", "skin"))
    thinned = _rendered(scene, 100)
    monkeypatch.setattr(roulette, "AFTER_LIGHT", 1e6)
    measure.assert_same(thinned, _rendered(scene, 500), label="roulette")


def test_half_of_the_paths_go_on_from_where_lights_were_connected_to():
    chances = np.array(roulette.lit(mi.Float([0.0, 0.5, 1.0, 4.0]), mi.Float(1.0)))
    assert chances == pytest.approx([0, 0.25, 0.5, 1])
    assert np.array(roulette.lit(mi.Float(0), mi.Float(0))) == pytest.approx(0)


def test_lamps_are_looked_for_as_far_as_they_may_shine_through():
    sphere = [(mi.Point3f(0, 0, 10), mi.Float(0.5))]
    toward = mi.Ray3f(mi.Point3f(0), mi.Vector3f(0, 0, 1))
    away = mi.Ray3f(mi.Point3f(0), mi.Vector3f(0, 0, -1))
    sigma_t = mi.Spectrum(20.0, 10.0, 5.0)

    def looked(ray, weight):
        found = glints.horizon(sphere, ray, mi.Spectrum(weight), sigma_t, mi.Float(1.4))
        return float(dr.slice(found, 0))

    assert looked(toward, 1.0) == pytest.approx(np.log(1e3) / 5.0, rel=1e-4)
    assert looked(away, 1.0) == 0
    assert looked(toward, 1e-4) == 0
