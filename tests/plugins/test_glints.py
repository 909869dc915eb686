"""Lamps that a smooth surface mirrors, or an object lets through: seen by each sample, once, and only if not hidden."""

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


ABSORBED = 0.5  # per unit of length, in a slab of 2
ENTERS = 1 - float(fresnel.reflectance(1.0, 1.3))
THROUGH = ENTERS * np.exp(-2 * ABSORBED) * RADIANCE  # for what has entered


def _before_a_lamp(alpha=0.0, sigma_s=1e-6, blocked=False):
    """Return a dark slab that the camera sees straight on, with a lamp behind."""
    scene = scenes.camera(32, fov=0.1)
    scene["object"] = scenes.placed("slab") | scenes.translucent(ABSORBED, sigma_s, alpha=alpha)
    scene["lamp"] = scenes.light([0, 0, -1], radiance=RADIANCE)
    if blocked:
        black = {"type": "diffuse", "reflectance": scenes.rgb(0.0)}
        scene["blocker"] = {"type": "sphere", "center": [0, 0, -20], "radius": 6, "bsdf": black}
    return scene


@pytest.mark.parametrize("model", ["walk", "dipole", "transport"])
@pytest.mark.parametrize("exit_", ["lobe", "exact"])
def test_every_path_that_enters_sees_the_lamp_behind(model, exit_):
    """2 in 100 are mirrored, and as many of the others inside."""
    seen = measure.picture(_before_a_lamp(), scenes.ours(model=model, exit=exit_), 1)
    assert np.mean(np.abs(seen / THROUGH - 1) < 0.01) > 0.9


def test_the_lamp_behind_is_as_bright_as_it_is():
    """Within 5 standard errors; with what gets there after two reflections inside: 1 in 40000."""
    seen = measure.passes(_before_a_lamp(sigma_s=0.1), scenes.ours(terms="reduced"), 64, 16, 100).total()
    expected = ENTERS * THROUGH * np.exp(-2 * 0.1)
    error = seen.std(0, ddof=1) / np.sqrt(len(seen))
    assert np.all(np.abs(seen.mean(0) - expected) < 5 * error + 1e-4 * expected)


def test_a_lamp_behind_may_be_hidden():
    np.testing.assert_allclose(measure.picture(_before_a_lamp(blocked=True), scenes.ours(), 4), 0, atol=1e-4)


def test_a_rough_object_blurs_the_lamp_behind():
    """By chance, as before: its light has no one direction to look in."""
    rough = measure.passes(_before_a_lamp(alpha=0.05), scenes.ours(), 256, 8, 100).total()
    assert rough.mean() == pytest.approx(ENTERS * THROUGH, rel=0.1)


@pytest.mark.parametrize("max_depth", [1, 2])
def test_depth_counts_the_object_as_one_bounce(max_depth):
    seen = measure.picture(_before_a_lamp(), scenes.ours(max_depth=max_depth), 4)
    assert seen.mean() == (0 if max_depth == 1 else pytest.approx(ENTERS * THROUGH, rel=0.05))
