"""Albedo and normal of scenes where they are known."""

import numpy as np
import pytest

import nephrite  # noqa: F401 (first, for LLVM)
from nephrite.errors import ParameterError
from nephrite.rendering import schedule
from nephrite.rendering.features import albedo_normal


@pytest.fixture(scope="module")
def scene():
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    frame = mi.ScalarTransform4f().look_at(origin=[0, 0, 3], target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": 32, "height": 24, "rfilter": {"type": "box"}}
    colour = {"type": "rgb", "value": [0.8, 0.4, 0.1]}
    return mi.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "fov": 60, "to_world": frame, "film": film},
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": colour}},
            "light": {"type": "constant"},
        }
    )


def test_albedo_and_normal_of_a_ball(scene):
    albedo, normal = albedo_normal(scene, spp=16)
    assert albedo.shape == normal.shape == (24, 32, 3)
    assert albedo.dtype == normal.dtype == np.float32
    np.testing.assert_allclose(albedo[12, 16], [0.8, 0.4, 0.1], atol=1e-3)
    assert normal[12, 16, 2] > 0.98
    assert normal[12, 22, 0] > 0.3  # towards the right of the picture: +x
    assert normal[6, 16, 1] > 0.3  # towards the top: +y
    np.testing.assert_array_equal(normal[0, 0], 0)


def test_any_sensor_film_and_number_of_passes(scene, monkeypatch):
    import mitsuba as mi

    rgba = {"type": "hdrfilm", "width": 8, "height": 6, "pixel_format": "rgba"}
    frame = mi.ScalarTransform4f().look_at(origin=[0, 0, 3], target=[0, 0, 0], up=[0, 1, 0])
    sensor = mi.load_dict({"type": "perspective", "fov": 20, "to_world": frame, "film": rgba})
    monkeypatch.setattr(schedule, "MAX_SAMPLES", 48 * 4)
    albedo, normal = albedo_normal(scene, sensor, spp=10)
    assert albedo.shape == (6, 8, 3)
    np.testing.assert_allclose(albedo, np.broadcast_to(np.float32([0.8, 0.4, 0.1]), (6, 8, 3)), atol=1e-3)
    assert np.linalg.norm(normal, axis=2).max() <= 1.001


@pytest.mark.parametrize("variant", ["llvm_ad_mono", "llvm_ad_spectral"])
def test_other_variants(variant):
    import mitsuba as mi

    before = mi.variant() or "llvm_ad_rgb"
    try:
        mi.set_variant(variant)
        film = {"type": "hdrfilm", "width": 8, "height": 6}
        ball = {"type": "sphere", "radius": 9, "bsdf": {"type": "diffuse", "reflectance": 0.25}}
        scene = mi.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "ball": ball})
        albedo, normal = albedo_normal(scene, spp=64)
        np.testing.assert_allclose(albedo.mean(), 0.25, rtol=0.1)
        assert np.isfinite(normal).all()
    finally:
        mi.set_variant(before)


def test_misuse_is_refused(scene):
    with pytest.raises(ParameterError, match="spp"):
        albedo_normal(scene, spp=0)
