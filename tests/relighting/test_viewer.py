"""The viewer: the walk's picture, whatever the lights; linear in them; the same for the same lights and camera.

Comparisons with the walk state the bias that is allowed; noise is below a third of it.
"""

import gc

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.errors import ParameterError, VariantError
from nephrite.plugins import walked
from nephrite.relighting import Viewer
from support import measure, scenes

WALKS = 1_000_000
SIDE = 96


def _scene(**more):
    """Return a ball of skim milk on a floor, with a lamp, a dim sky, and what else is given."""
    scene = scenes.camera(SIDE) | {"sky": scenes.environment(0.2), "lamp": scenes.light((0.6, 0.7, 0.3))}
    sigma_a, sigma_s, eta = scenes.SKIM_MILK
    scene["ball"] = {"type": "sphere", "radius": 8.0} | scenes.translucent(sigma_a, sigma_s, eta=eta)
    to_world = mi.ScalarTransform4f().translate([0, -10, 0]).rotate([1, 0, 0], -80).scale(14)
    scene["floor"] = {"type": "rectangle", "to_world": to_world, "bsdf": {"type": "diffuse"}}
    return scene | more


def _turned(lamp, angle):
    turn = mi.Transform4f().rotate([0, 1, 0], angle)
    lamp["to_world"] = turn @ mi.Transform4f(lamp["to_world"])
    lamp.update()


def _steady(viewer, count=16):
    for _ in range(count - 1):
        viewer.frame()
    return viewer.frame()


@pytest.fixture(scope="module")
def viewer():
    return Viewer(mi.load_dict(_scene()), walks=WALKS)


@pytest.fixture
def fresh(viewer):
    """Return a function that makes a viewer of a scene with the same transport."""
    return lambda scene: Viewer(mi.load_dict(scene), viewer.transport)


@pytest.mark.slow
def test_nothing_is_lost_in_even_light():
    """A ball that absorbs nothing vanishes under an even sky: within 1.5 %, and 3 % in blocks of 4 x 4.

    Each frame of the same light makes it less noisy; in the first one a block may be 3 % off by that alone.
    """
    scene = scenes.camera(16, fov=10.0) | {"sky": scenes.environment(1.0)}
    scene["ball"] = {"type": "sphere", "radius": 9.0} | scenes.translucent(0.0, 1.0)
    viewer = Viewer(mi.load_dict(scene), walks=WALKS)
    picture = [viewer.frame() for _ in range(64)][-1]
    assert picture.mean() == pytest.approx(1.0, abs=0.015)
    blocks = picture.reshape(4, 4, 4, 4, 3).mean((1, 3))
    assert np.abs(blocks - 1).max() < 0.03


@pytest.mark.slow
def test_moved_lights_compile_nothing(viewer):
    """Their places are no numbers in kernels: to compile those takes longer than the frame."""
    lamp, found = viewer.light("lamp"), []
    before = mi.Transform4f(lamp["to_world"])
    for shift in (1.0, 2.0, 3.0):
        gc.collect()  # objects that other tests have left behind are parts of kernels, as long as they are there
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            lamp["to_world"] = mi.Transform4f().translate([shift, 0, 0]) @ before
            lamp.update()
            viewer.frame()
            found.append({k["hash"] for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT})
            dr.kernel_history_clear()
    lamp["to_world"] = before
    lamp.update()
    assert len(found[0]) > 5
    assert found[2] <= found[0] | found[1]


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 120.0, 240.0])
def test_a_frame_is_the_walks_picture(fresh, angle):
    """Within 3 % on the ball and 2 % around it, wherever the lamp is."""
    scene = mi.load_dict(_scene())
    viewer = fresh(_scene())
    _turned(viewer.light("lamp"), angle)
    parameters = mi.traverse(scene)
    parameters["lamp.to_world"] = viewer.light("lamp")["to_world"]
    parameters.update()
    walk = measure.passes(scene, scenes.ours(), 32, 4, 100).mean
    frame = _steady(viewer)
    ball = np.hypot(*(np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2)) < SIDE / 3
    for mask, bound in ((ball, 0.03), (~ball, 0.02)):
        ratio = frame[mask].mean(0) / walk[mask].mean(0) - 1
        print(angle, ratio)
        assert np.abs(ratio).max() < bound


def test_frames_are_linear_in_the_lights(fresh):
    viewer = fresh(_scene(other=scenes.light((-0.7, 0.5, 0.4), radiance=(5.0, 10.0, 20.0))))
    whole = viewer.frame()
    parts = []
    for name in ("lamp", "other", "sky"):
        kept = {}
        for other, parameters in viewer.lights.items():
            key = "radiance.value" if other == "sky" else "emitter.radiance.value"
            if other != name:
                kept[other] = key, mi.Color3f(parameters[key])
                parameters[key] = mi.Color3f(0.0)
                parameters.update()
        parts.append(viewer.frame())
        for other, (key, value) in kept.items():
            viewer.light(other)[key] = value
            viewer.light(other).update()
    np.testing.assert_allclose(sum(parts), whole, rtol=1e-3, atol=1e-5)


def test_a_moved_lamp_needs_no_walks_and_leaves_no_trace(viewer, fresh, monkeypatch):
    calls = []
    monkeypatch.setattr(walked, "walk", lambda *given: calls.append(given))
    other = fresh(_scene())
    before = other.frame()
    _turned(other.light("lamp"), 120.0)
    moved = other.frame()
    assert np.abs(moved - before).mean() > 0.1 * before.mean()
    there = fresh(_scene())
    _turned(there.light("lamp"), 120.0)
    np.testing.assert_allclose(there.frame(), moved, rtol=1e-4, atol=1e-6)
    assert not calls


def test_parameters_of_the_whole_scene_move_it_too(viewer):
    scene = mi.load_dict(_scene())
    other = Viewer(scene, viewer.transport)
    other.frame()
    parameters = mi.traverse(scene)
    parameters["lamp.to_world"] = mi.Transform4f().rotate([0, 1, 0], 120.0) @ mi.Transform4f(
        parameters["lamp.to_world"]
    )
    parameters.update()
    moved = other.frame()
    third = Viewer(mi.load_dict(_scene()), viewer.transport)
    _turned(third.light("lamp"), 120.0)
    np.testing.assert_allclose(third.frame(), moved, rtol=1e-4, atol=1e-6)


@pytest.mark.slow
def test_frames_get_better_while_lights_rest(fresh):
    viewer = fresh(_scene())
    first = viewer.frame()
    fourth = _steady(viewer, 3)
    best = _steady(viewer, 60)
    assert np.abs(fourth - best).mean() < 0.7 * np.abs(first - best).mean()
    assert first.mean() == pytest.approx(best.mean(), rel=0.01)


def test_the_scene_keeps_its_names(viewer):
    scene = mi.load_dict(_scene())
    before = list(mi.traverse(scene).keys())
    Viewer(scene, viewer.transport).frame()
    assert list(mi.traverse(scene).keys()) == before


@pytest.mark.slow
def test_a_moved_camera_sees_the_other_side(fresh):
    scene = mi.load_dict(_scene())
    viewer = fresh(_scene())
    parameters = mi.traverse(scene.sensors()[0])
    second = Viewer(scene, viewer.transport)
    second.frame()
    view = mi.ScalarTransform4f().look_at(origin=[40, 10, -40], target=[0, 0, 0], up=[0, 1, 0])
    parameters["to_world"] = mi.Transform4f(view.matrix)
    parameters.update()
    moved = second.frame()
    described = _scene()
    described["sensor"] = described["sensor"] | {"to_world": view}
    np.testing.assert_allclose(fresh(described).frame(), moved, rtol=1e-4, atol=1e-6)


def test_what_is_not_shown_is_refused_by_name(viewer):
    with pytest.raises(ParameterError, match=r"unknown light 'lmap'.*Did you mean 'lamp'"):
        viewer.light("lmap")
    mirror = {"type": "sphere", "radius": 1.0, "center": [0, 20, 0], "bsdf": {"type": "conductor"}}
    with pytest.raises(ParameterError, match="'mirror' is a mirror or glass"):
        Viewer(mi.load_dict(_scene(mirror=mirror)), walks=1000)
    rough = {"type": "sphere", "radius": 8.0} | scenes.translucent(0.0, 1.0, alpha=0.2)
    with pytest.raises(ParameterError, match="rough surface"):
        Viewer(mi.load_dict(_scene(ball=rough)), walks=1000)
    dark = _scene()
    del dark["lamp"], dark["sky"]
    with pytest.raises(ParameterError, match="no light"):
        Viewer(mi.load_dict(dark), walks=1000)
    without = _scene()
    del without["ball"]
    with pytest.raises(ParameterError, match="no translucent object"):
        Viewer(mi.load_dict(without), walks=1000)


def test_other_variants_are_refused(switching):
    mi.set_variant("llvm_ad_mono")
    with pytest.raises(VariantError, match="rgb"):
        Viewer(mi.load_dict(_scene()), walks=1000)
