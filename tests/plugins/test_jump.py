"""Jumps of several chords: what they bring is what one chord brings, and no path outweighs the others."""

import mitsuba as mi
import numpy as np
import pytest
import trimesh

from nephrite.image.errors import z_limit
from nephrite.plugins import jump
from nephrite.scene.files import mesh_plugin
from nephrite.scene.meshes import from_arrays
from support import measure, scenes


def _comb():
    """Six thin plates side by side: light that leaves one enters the next, and a chord meets many of them."""
    plates = [trimesh.creation.box((1, 10, 10)).apply_translation((2 * i - 5, 0, 0)) for i in range(6)]
    comb = trimesh.util.concatenate(plates)
    scene = scenes.camera()
    scene["object"] = mesh_plugin(from_arrays(np.array(comb.vertices), np.array(comb.faces), "comb"))
    scene["object"] |= scenes.translucent(0.001, 1.5)
    scene["environment"] = scenes.environment()
    aside = mi.ScalarTransform4f().look_at(origin=[25, 30, 40], target=[0, 0, 0], up=[0, 1, 0])
    return scene | {"sensor": scene["sensor"] | {"to_world": aside}}


def _of_paths(scene):
    """Radiance of single paths that meet the object, mean of the channels."""
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(5, 1 << 18)
    ray, _ = scene.sensors()[0].sample_ray(0.0, 0.0, sampler.next_2d(), mi.Point2f(0.5))
    found = mi.load_dict(scenes.ours(model="dipole")).sample(scene, sampler, ray)[0]
    return np.array(found).mean(0)[np.array(scene.ray_test(ray))]


@pytest.mark.slow
def test_the_number_of_chords_changes_no_mean(monkeypatch):
    scene = mi.load_dict(scenes.trial(scenes.Trial("cube", "marble"), "translucent"))
    integrator = mi.load_dict(scenes.ours(model="dipole"))
    begin = jump.begin

    def rendered(chords, seed):
        monkeypatch.setattr(jump, "begin", lambda worth, active: begin(chords + 0.0 * worth, active))
        pictures = [mi.render(scene, integrator=integrator, spp=256, seed=seed + i) for i in range(16)]
        return measure.Passes(np.array(pictures, dtype=np.float64))

    mi.render(scene, integrator=integrator, spp=1)  # the balance that both go by
    one, three = rendered(1, 0), rendered(3, 100)
    measure.assert_same(three, one, label="three chords and one")


def test_no_path_outweighs_the_others(monkeypatch):
    """Between the plates of a comb: single chords let paths become worth a thousand others."""
    scene = mi.load_dict(_comb())
    many = _of_paths(scene)
    monkeypatch.setattr(jump, "MAX_CHORDS", 1)
    one = _of_paths(scene)
    assert many.max() < 300 < one.max()
    assert many.std() < 0.6 * one.std()
    error = np.sqrt((many.var() + one.var()) / many.size)
    assert abs(many.mean() - one.mean()) < z_limit(1, measure.FALSE_ALARM) * error
