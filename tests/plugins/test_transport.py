"""Light transport around translucent objects: other objects, media in media, every kind of light, instances.

Where `volpathmis` renders the same, a z-test compares; it fails a right program with probability `measure.FALSE_ALARM`.
"""

import math

import mitsuba as mi
import numpy as np
import pytest

from support import measure, scenes
from support.quick import slow

SIGMA_A, SIGMA_S = (0.05, 0.1, 0.2), (0.4, 0.5, 0.6)
EXACT = scenes.ours(model="walk", exit="exact")


def _ball(radius=7.0, center=(0.0, 0.0, 0.0)):
    return {"type": "sphere", "center": list(center), "radius": radius}


def _lit(half=24.0):
    scene = scenes.camera(12)
    scene["environment"] = scenes.environment(0.4)
    scene["light"] = scenes.light((0.6, 0.5, 0.6), half, 6.0 * (24.0 / half) ** 2)
    return scene


def _diffuse(value=0.6):
    return {"bsdf": {"type": "diffuse", "reflectance": scenes.rgb(value)}}


def _mirror():
    scene = _lit()
    scene["ball"] = _ball() | scenes.standard(SIGMA_A, SIGMA_S)
    to_world = mi.ScalarTransform4f().translate([0, -7, 0]).rotate([1, 0, 0], -80).scale(20)
    scene["floor"] = {
        "type": "rectangle",
        "to_world": to_world,
        "bsdf": {"type": "conductor", "material": "Ag"},
    }
    return scene


def _diffuse_inside():
    scene = _lit()
    scene["ball"] = _ball() | scenes.standard(0.01, 0.0)
    scene["inner"] = _ball(4.0) | _diffuse((0.8, 0.4, 0.2))
    return scene


def _diffuse_inside_a_cloudy_medium():
    scene = _lit()
    scene["ball"] = _ball() | scenes.standard(SIGMA_A, 0.1)
    scene["inner"] = _ball(4.0, (1.0, 1.0, 2.0)) | _diffuse((0.8, 0.4, 0.2))
    return scene


def _two():
    scene = _lit()
    scene["one"] = _ball(4.0, (-4.2, 0.0, 0.0)) | scenes.standard(SIGMA_A, SIGMA_S)
    scene["two"] = _ball(4.0, (4.2, 0.0, 0.0)) | scenes.standard((0.3, 0.02, 0.3), 0.7, g=0.5, eta=1.5)
    return scene


def _nested():
    scene = _lit()
    outer = scenes.standard((0.02, 0.01, 0.01), 0.15)
    outer["interior"]["id"] = "outer"
    inner = scenes.standard((0.01, 0.1, 0.3), 0.8, g=0.3, eta=1.5)
    inner["bsdf"]["ext_ior"] = 1.3
    scene["ball"] = _ball() | outer
    scene["inner"] = _ball(4.0, (0.5, 1.0, 1.0)) | inner | {"exterior": {"type": "ref", "id": "outer"}}
    return scene


def _clear_glass():
    scene = _lit()
    scene["ball"] = _ball() | {"bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}}
    scene["behind"] = _ball(6.0, (0.0, 0.0, -14.0)) | scenes.standard(SIGMA_A, SIGMA_S)
    return scene


AROUND = [_mirror, _diffuse_inside, _diffuse_inside_a_cloudy_medium, _two, _nested, _clear_glass]


@pytest.mark.slow
@pytest.mark.parametrize("make", AROUND, ids=lambda make: make.__name__[1:])
def test_surroundings_equal_volpathmis(make):
    scene = mi.load_dict(make())
    truth = measure.passes(scene, scenes.TRUTH, 256, 12, 100)
    own = measure.passes(scene, EXACT, 256, 12, 900)
    measure.assert_same(own, truth, label=make.__name__)


@pytest.mark.parametrize("model", ["auto", slow("walk"), slow("dipole"), slow("brdf")])
@pytest.mark.parametrize("make", AROUND, ids=lambda make: make.__name__[1:])
def test_every_model_renders_surroundings(make, model):
    picture = measure.picture(make(), scenes.ours(model=model), 32)
    assert np.isfinite(picture).all()
    assert picture.min() >= -1.0  # the lobe's kernel may be negative, one sample at a time
    assert picture.mean() > 0.05


def test_a_standard_scene_without_media_is_what_path_makes():
    scene = _lit()
    scene["ball"] = _ball() | _diffuse((0.8, 0.4, 0.2))
    scene["glass"] = _ball(3.0, (0.0, 0.0, 11.0)) | {"bsdf": {"type": "dielectric"}}
    scene["rough"] = _ball(3.0, (7.0, 0.0, 0.0)) | {"bsdf": {"type": "roughconductor", "alpha": 0.2}}
    scene = mi.load_dict(scene)
    measure.assert_same(
        measure.passes(scene, scenes.ours(), 256, 12, 100),
        measure.passes(scene, {"type": "path", "max_depth": -1}, 256, 12, 900),
    )


@pytest.mark.parametrize("depth", [1, 2, slow(3), slow(5)])
def test_max_depth_means_what_it_means_in_path(depth):
    scene = _lit()
    scene["ball"] = _ball() | _diffuse((0.9, 0.8, 0.7))
    scene["floor"] = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([0, -7, 0]).rotate([1, 0, 0], -80).scale(20),
        **_diffuse(0.9),
    }
    scene["glass"] = _ball(3.0, (0.0, 0.0, 11.0)) | {"bsdf": {"type": "dielectric"}}
    scene = mi.load_dict(scene)
    measure.assert_same(
        measure.passes(scene, scenes.ours(max_depth=depth), 128, 10, 100),
        measure.passes(scene, {"type": "path", "max_depth": depth}, 128, 10, 900),
        label=f"max_depth {depth}",
    )


@pytest.mark.slow
def test_a_walk_is_one_bounce():
    """Depth 1 sees lights alone; depth 2 all that one reflection or one walk brings.

    Walks are so short that none is thinned out: no light comes or goes by chance.
    """
    scene = scenes.camera(8, fov=10.0)
    scene["ball"] = _ball(9.0) | scenes.translucent(0.0, 0.05)
    scene["environment"] = scenes.environment(1.0)
    scene = mi.load_dict(scene)
    for exit_, tolerance in (("exact", 1e-4), ("lobe", 2e-2)):
        means = [measure.picture(scene, scenes.ours(max_depth=d, exit=exit_), 256).mean() for d in (1, 2, -1)]
        assert means[0] == 0
        assert means[1:] == pytest.approx([1.0, 1.0], abs=tolerance)


POINT = {"type": "point", "position": [30.0, 20.0, 30.0], "intensity": 5000.0}
SMALL = {"type": "sphere", "center": [30.0, 20.0, 30.0], "radius": 2.0}


@pytest.mark.parametrize("model", ["walk", slow("dipole"), slow("brdf")])
def test_a_point_light_is_a_small_lamp_of_the_same_power(model):
    """A sphere of radius 2 at a distance of 47: intensity = radiance pi r^2; within 2 %."""
    base = scenes.camera(8)
    base["ball"] = _ball(9.0) | scenes.translucent(SIGMA_A, SIGMA_S)
    radiance = POINT["intensity"] / (math.pi * SMALL["radius"] ** 2)
    lamp = SMALL | {"emitter": {"type": "area", "radiance": scenes.rgb(radiance)}}
    # the lamp itself is out of view; its mirror image in the ball, which a point has not, is in `reduced`
    terms = {"terms": "single+multiple"}
    point = measure.passes(base | {"light": POINT}, scenes.ours(model=model, **terms), 2048, 8, 100)
    sphere = measure.passes(base | {"light": lamp}, scenes.ours(model=model, **terms), 2048, 8, 900)
    a, b = (x.total().mean(1) for x in (point, sphere))
    error = math.hypot(a.std(ddof=1) / a.mean(), b.std(ddof=1) / b.mean()) / math.sqrt(8)
    print(f"{model}: {a.mean() / b.mean():.4f} +- {error:.4f}")
    assert error < 0.01
    assert a.mean() == pytest.approx(b.mean(), rel=0.02 + 3 * error)


@pytest.mark.slow
def test_a_directional_light_is_a_lamp_far_away():
    base = scenes.camera(8)
    base["ball"] = _ball(9.0) | scenes.translucent(SIGMA_A, SIGMA_S)
    far, radius = 4000.0, 100.0
    direction = np.array([0.6, 0.4, 0.6]) / math.sqrt(0.88)
    sun = {"type": "directional", "direction": (-direction).tolist(), "irradiance": scenes.rgb(3.0)}
    radiance = 3.0 / (math.pi * (radius / far) ** 2)
    lamp = {"type": "sphere", "center": (far * direction).tolist(), "radius": radius}
    lamp["emitter"] = {"type": "area", "radiance": scenes.rgb(radiance)}
    terms = {"terms": "single+multiple"}
    a, b = (
        measure.passes(base | {"light": light}, scenes.ours(**terms), 512, 8, seed)
        for light, seed in ((sun, 100), (lamp, 900))
    )
    assert a.mean.mean() == pytest.approx(b.mean.mean(), rel=0.03)


def test_an_environment_map_of_one_colour_is_a_constant_environment():
    base = scenes.camera(8)
    base["ball"] = _ball(9.0) | scenes.translucent(SIGMA_A, SIGMA_S)
    bitmap = mi.Bitmap(np.full((8, 16, 3), 0.7, dtype=np.float32))
    constant = measure.passes(base | {"e": scenes.environment(0.7)}, scenes.ours(), 256, 8, 100)
    mapped = measure.passes(base | {"e": {"type": "envmap", "bitmap": bitmap}}, scenes.ours(), 256, 8, 900)
    measure.assert_same(mapped, constant)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["walk", "dipole", "brdf"])
@pytest.mark.parametrize("kind", [scenes.translucent, scenes.standard])
def test_instances_are_what_they_are_instances_of(kind, model):
    base = _lit()
    inside = kind(SIGMA_A, SIGMA_S)
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 40).scale([5, 7, 6])
    group = {"type": "shapegroup", "cube": {"type": "cube", **inside}}
    instance = {"type": "instance", "shapegroup": {"type": "ref", "id": "group"}, "to_world": turned}
    if (
        model == "dipole"
    ):  # the factor that keeps it from making energy is taken from the shape as it is in its group
        group["cube"]["to_world"] = turned
        del instance["to_world"]
    single = {"type": "cube", **inside, "to_world": turned}
    measure.assert_same(
        measure.passes(base | {"group": group, "instance": instance}, scenes.ours(model=model), 64, 8, 100),
        measure.passes(base | {"single": single}, scenes.ours(model=model), 64, 8, 900),
    )
