"""Meshes of Mitsuba's own, wound as they may be."""

import dataclasses

import mitsuba as mi
import numpy as np
import pytest

from nephrite.geometry.winding import turned_over
from nephrite.plugins import auto, jumped, shapes
from nephrite.plugins.media import Media
from nephrite.scene import named
from nephrite.scene.place import placed
from nephrite.scene.ply import write_ply
from support import scenes

WINDINGS = {"outward": lambda i: i < 0, "inward": lambda i: i >= 0, "mixed": lambda i: i % 2 == 0}


def _scene(which, folder):
    """Return a scene with a ball of radius 5 around (0, 5, 0), and its shape."""
    ball = placed(named.find("sphere"), 10.0)
    faces = turned_over(ball.faces, WINDINGS[which](np.arange(len(ball.faces))))
    path = write_ply(dataclasses.replace(ball, faces=faces), folder / f"{which}.ply")
    mesh = {"type": "ply", "filename": str(path), "face_normals": True}
    scene = mi.load_dict({"type": "scene", "ball": mesh | scenes.translucent(0.01, 0.5)})
    return scene, scene.shapes()[0]


def _sampler(count):
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, count)
    return sampler


@pytest.mark.parametrize("which", WINDINGS)
def test_a_line_outward_leaves_for_good(which, tmp_path):
    scene, shape = _scene(which, tmp_path)
    media = Media.of(scene)
    auto.choose("dipole", media, scene)
    begun = shapes.start(scene, media.winding, shape, _sampler(4096))
    from_middle = np.array(begun.si.p) - np.array([[0.0], [5.0], [0.0]])
    assert ((np.array(begun.si.n) * from_middle).sum(0) > 0).all()
    assert begun.side == (-1.0 if which == "inward" else 1.0)


def _brought(which, folder, model):
    """Return what jumps bring, from many points, in the first channel."""
    scene, shape = _scene(which, folder)
    media = Media.of(scene)
    auto.choose(model, media, scene)
    sampler = _sampler(1 << 18)
    return np.array(
        jumped.jump_once(media, 1, scene, sampler, shapes.start(scene, media.winding, shape, sampler))[0]
    )


@pytest.mark.parametrize("model", ["directional", "tabulated"])
@pytest.mark.parametrize("which", ["inward", "mixed"])
def test_energy_is_kept_whatever_the_winding(which, model, tmp_path):
    """Two means of the same: a right program fails once in 15,000 seeds."""
    one, other = _brought("outward", tmp_path, model), _brought(which, tmp_path, model)
    error = np.sqrt(one.var() / one.size + other.var() / other.size)
    assert abs(one.mean() - other.mean()) < 4 * error
    assert error < 0.01 * one.mean()
