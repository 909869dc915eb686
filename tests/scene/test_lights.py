"""Light rigs: what they hold, that they scale with the object, and that B1 is the benchmark's scene."""

from __future__ import annotations

import math

import mitsuba as mi
import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.scene import camera, lights


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def grey_ball(name: str, size: float) -> mi.Scene:
    """A diffuse ball as large as the object would be, in the rig `name`."""
    return mi.load_dict(
        {
            "type": "scene",
            **lights.rig(name, size),
            "sensor": camera.benchmark(size, (32, 24)),
            "ball": {
                "type": "sphere",
                "center": [0, size / 2, 0],
                "radius": size / 2,
                "bsdf": {"type": "diffuse", "reflectance": 0.5},
            },
        }
    )


def picture(scene: mi.Scene, spp: int = 64) -> np.ndarray:
    return np.array(mi.render(scene, integrator=mi.load_dict({"type": "path", "max_depth": 4}), spp=spp))


@pytest.mark.parametrize("name", lights.names())
def test_a_rig_looks_the_same_at_every_size(name: str) -> None:
    small, large = picture(grey_ball(name, 3.0)), picture(grey_ball(name, 700.0))
    assert small.mean() > 0.01
    assert large.mean() == pytest.approx(small.mean(), rel=0.05)


FLOORED = [name for name in lights.names() if name != "environment"]


@pytest.mark.parametrize("name", FLOORED)
def test_the_object_stands_on_something(name: str) -> None:
    size = 100.0
    down = mi.Ray3f(o=mi.Point3f(0.8 * size, 1.0, 0.1 * size), d=mi.Vector3f(0, -1, 0))
    scene = grey_ball(name, size)  # Dr.Jit traces late: the scene must outlive the line
    assert scene.ray_intersect(down).t.numpy()[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("name", FLOORED)
def test_no_lamp_is_in_the_picture(name: str) -> None:
    scene = mi.load_dict({"type": "scene", **lights.rig(name, 1.0)})
    lamps = [shape for shape in scene.shapes() if shape.is_emitter()]
    assert lamps
    across = np.linspace(0.005, 0.995, 60)
    u, v = np.meshgrid(across, across)
    for resolution in ((800, 600), (1920, 1080), (600, 600), (600, 800)):
        for shape in ((1, 1, 1), (1, 0.7, 0.4), (0.1, 1, 0.1), (1, 0.1, 1), (0.1, 0.1, 1)):
            corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * shape
            corners[:, 1] += shape[1] / 2
            view = camera.framing(corners, resolution)
            if name == "benchmark":  # it has its own picture, and only that one
                view = camera.benchmark(1.0, (400, 300))
            spots = mi.Point2f(u.ravel(), v.ravel())
            ray, _ = mi.load_dict(view).sample_ray(0.0, 0.5, spots, mi.Point2f(0.5, 0.5))
            hit = scene.ray_intersect(ray).shape
            for lamp in lamps:
                assert not np.any((hit == mi.ShapePtr(lamp)).numpy()), (resolution, shape)


def test_the_environment_rig_is_white_everywhere() -> None:
    scene = mi.load_dict({"type": "scene", **lights.rig("environment", 10.0)})
    directions = np.random.default_rng(1).normal(size=(3, 64))
    directions /= np.linalg.norm(directions, axis=0)
    ray = mi.Ray3f(o=mi.Point3f(0, 5, 0), d=mi.Vector3f(directions))
    seen = scene.environment().eval(scene.ray_intersect(ray))
    np.testing.assert_allclose(np.array(seen), 1.0, rtol=1e-6)


def test_b1_is_the_scene_of_the_benchmark() -> None:
    size = 100.0
    rig = lights.rig("benchmark", size)
    assert "sampling_weight" not in rig["light"]["emitter"] | rig["sky"]  # Mitsuba's own
    scene = mi.load_dict({"type": "scene", **rig})
    lamp = next(shape for shape in scene.shapes() if shape.is_emitter())
    floor = next(shape for shape in scene.shapes() if not shape.is_emitter())
    assert lamp.surface_area().numpy()[0] == pytest.approx(70.0**2, rel=1e-5)
    box = lamp.bbox()
    np.testing.assert_allclose((np.array(box.min) + np.array(box.max)) / 2, [-90, 160, -90], atol=1e-3)
    towards = np.array([0, 30, 0]) - np.array([-90, 160, -90])
    ray = mi.Ray3f(o=mi.Point3f(0, 30, 0), d=mi.Vector3f(-towards / np.linalg.norm(towards)))
    hit = scene.ray_intersect(ray)
    assert hit.t.numpy()[0] == pytest.approx(np.linalg.norm(towards), rel=1e-5)
    np.testing.assert_allclose(np.array(hit.emitter(scene).eval(hit)).ravel(), 25.0, rtol=1e-5)
    assert floor.surface_area().numpy()[0] == pytest.approx(1200.0**2, rel=1e-5)
    assert (np.array(floor.bbox().max)[1], np.array(floor.bbox().min)[1]) == pytest.approx((0, 0), abs=1e-3)
    sky = scene.environment().eval(scene.ray_intersect(mi.Ray3f(mi.Point3f(0, 1, 0), mi.Vector3f(0, 1, 0))))
    np.testing.assert_allclose(np.array(sky).ravel(), [0.15, 0.15, 0.17], rtol=1e-5)


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf])
def test_an_impossible_size_is_refused(size: float) -> None:
    with pytest.raises(ParameterError, match="positive and finite"):
        lights.rig("studio", size)


def test_an_unknown_rig_is_refused_with_a_suggestion() -> None:
    with pytest.raises(ParameterError, match="Did you mean 'studio'"):
        lights.rig("studoi", 100.0)
    assert all(lights.describe(name) for name in lights.names())
