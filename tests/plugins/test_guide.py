"""Turns toward the lamps and the way out: as much light as without them, and less noise in thin parts."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import guide
from support import measure, scenes

_SURE = 5.0  # standard errors, of 48 numbers: a false alarm in 35,000 runs
_COUNT = 1 << 18
_AT, _ALONG = np.array([1.0, 2.0, 3.0]), np.array([0.6, 0.0, -0.8])
_ONE, _THREE = [(5, 9, 1)], [(0, 30, 0), (9, 2, 3), (1, 2, -9)]
_UP = np.array([0.0, 0.6, 0.8])


def _turned(g, lamps, active=True, eta=None):
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(5, _COUNT)
    spheres = [(mi.Point3f(*centre), mi.Float(1.0)) for centre in lamps]
    u = [sampler.next_1d(), sampler.next_1d()]
    cone = guide.Cone.of(mi.Vector3f(_UP), mi.Float(eta), mi.Bool(active)) if eta else None
    turned, favour = guide.turn(
        spheres, mi.Point3f(_AT), mi.Vector3f(_ALONG), mi.Float(g), u, sampler, mi.Bool(active), cone
    )
    return np.array(turned), np.array(favour * dr.ones(mi.Float, _COUNT))


@pytest.mark.parametrize("eta", [None, 1.5])
@pytest.mark.parametrize("lamps", [[], _ONE, _THREE])
@pytest.mark.parametrize("g", [0.0, 0.85])
def test_they_bring_what_the_phase_function_does(g, lamps, eta):
    """Its integral is 1, its mean direction g times that before. None is worth more than is said."""
    turned, favour = _turned(g, lamps, eta=eta)
    values = np.stack([favour, *(favour * turned)])
    known = np.concatenate([[1.0], g * _ALONG])
    error = values.std(axis=1) / _COUNT**0.5
    assert (np.abs(values.mean(axis=1) - known) <= _SURE * error + 1e-5).all()
    assert favour.max() < 1.0001 / (1 - guide.SHARE - guide.OUT)


def test_each_lamp_has_its_part():
    """Within 26 degrees of a lamp are 5 % of all directions, and .059 of these; .044 if it had no part."""
    turned, _ = _turned(0.0, _THREE)
    for toward in np.array(_THREE) - _AT:
        assert np.mean(toward / np.linalg.norm(toward) @ turned > 0.9) > 0.055


@pytest.mark.parametrize("eta", [1.0, 1.5])
def test_the_way_out_has_its_part(eta):
    """All directions up at an index of 1; at 1.5 a cone of 42 degrees, whose share of all directions is .127.

    Within five standard errors: a false alarm in 1.7 million runs of one of the two.
    """
    turned, _ = _turned(0.0, [], eta=eta)
    share = (1 - (1 - eta**-2) ** 0.5) / 2
    inside = np.mean(_UP @ turned > 1 - 2 * share)
    assert inside == pytest.approx(guide.OUT + (1 - guide.OUT) * share, abs=0.004)


def test_only_what_is_active_is_guided():
    np.testing.assert_array_equal(_turned(0.5, _ONE, active=False, eta=1.5)[0], _turned(0.5, [])[0])


def _compared(scene, integrator, monkeypatch, without="EVENTS"):
    """Assert that guiding changes nothing but the noise; return the variance with it to that without."""
    guided = measure.passes(scene, integrator, 64, 24, 100)
    monkeypatch.setattr(guide, without, 0)
    plain = measure.passes(scene, integrator, 64, 24, 200)
    measure.assert_same(guided, plain)
    ratio = guided.pictures.var(axis=0).mean() / plain.pictures.var(axis=0).mean()
    print(ratio)
    return ratio


def test_light_from_behind_is_the_same_and_less_noisy(monkeypatch):
    scene = scenes.camera(8, fov=2.0)
    scene["object"] = scenes.placed("slab") | scenes.translucent(0.1, 0.8)
    scene["lamp"] = scenes.light([0.5, 0.2, -1])
    assert _compared(scene, scenes.ours(terms="single"), monkeypatch) < 0.85


def test_what_leaves_after_one_event_is_less_noisy_by_the_way_out(monkeypatch):
    scene = scenes.camera(8, fov=12.0)
    scene["ball"] = {"type": "sphere", "radius": 30.0} | scenes.translucent(0.02, 1.0)
    scene["sensor"]["to_world"] = mi.ScalarTransform4f().look_at([0, 0, 300], [0, 0, 0], [0, 1, 0])
    scene["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    integrator = scenes.ours(model="transport", terms="single")
    assert _compared(scene, integrator, monkeypatch, "OUT") < 0.8


@pytest.mark.slow
def test_twins_turn_with_their_paths(monkeypatch):
    """Where transport is precomputed, twins take away what they bring, whatever the turn is worth."""
    scene = scenes.camera(8, fov=12.0)
    scene["ball"] = {"type": "sphere", "radius": 30.0} | scenes.translucent(0.02, 1.0)
    scene["sensor"]["to_world"] = mi.ScalarTransform4f().look_at([0, 0, 300], [0, 0, 0], [0, 1, 0])
    scene["lamp"] = scenes.light([1, 0.5, -0.5]) | {
        "to_world": mi.ScalarTransform4f().look_at([90, 40, 60], [0, 0, 0], [0, 1, 0]).scale(20)
    }
    _compared(
        mi.load_dict(scene),
        mi.load_dict(scenes.ours(model="transport", walks=200_000, terms="multiple")),
        monkeypatch,
    )
