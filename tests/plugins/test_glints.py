"""Lamps that a smooth surface mirrors: seen by every sample, once, and only where nothing stands between."""

import mitsuba as mi
import numpy as np
import pytest

from nephrite.physics import fresnel
from support import measure, scenes

ANGLE = 30.0
RADIANCE = 20.0
MIRRORED = float(fresnel.reflectance(np.cos(np.radians(ANGLE)), 1.3)) * RADIANCE


def _scene(lamps=1, blocked=False):
    """Return a black slab, turned such that the camera sees a lamp in it in all pixels."""
    turned = np.radians(2 * ANGLE)
    toward = np.array([np.sin(turned), 0.0, np.cos(turned)])
    scene = scenes.camera(4, fov=0.1)
    to_world = mi.ScalarTransform4f().rotate([0, 1, 0], ANGLE).scale([12, 12, 1])
    scene["object"] = {"type": "cube", "to_world": to_world} | scenes.translucent(100.0, 1e-6)
    for i in range(lamps):
        scene[f"lamp{i}"] = scenes.light([*toward] if i == 0 else [0, 1, -i], radiance=RADIANCE)
    if blocked:
        black = {"type": "diffuse", "reflectance": scenes.rgb(0.0)}
        scene["blocker"] = {"type": "sphere", "center": list(20 * toward), "radius": 6, "bsdf": black}
    return scene


@pytest.mark.parametrize("model", ["walk", "dipole", "brdf", "transport"])
def test_every_sample_sees_the_lamp(model):
    integrator = scenes.ours(model=model, terms="reduced")
    np.testing.assert_allclose(measure.picture(_scene(), integrator, 64), MIRRORED, rtol=1e-3)


def test_what_is_hidden_is_not_seen():
    np.testing.assert_allclose(measure.picture(_scene(blocked=True), scenes.ours(), 1), 0, atol=1e-4)


def test_among_many_lamps_it_is_found_by_chance():
    many = measure.passes(_scene(lamps=5), scenes.ours(), 1024, 16, 100)
    found = many.pictures.mean(axis=(1, 2, 3))
    error = found.std(ddof=1) / np.sqrt(len(found))
    assert error > 0
    assert (
        abs(found.mean() - MIRRORED) < 5 * error
    )  # 5 standard errors of 15 degrees of freedom: .02 % false alarms


@pytest.mark.parametrize("terms", ["single", "multiple"])
def test_it_belongs_to_the_reduced_light(terms):
    np.testing.assert_allclose(measure.picture(_scene(), scenes.ours(terms=terms), 1), 0, atol=1e-4)
