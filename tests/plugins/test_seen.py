"""More walks begin where the camera looks, and as many in all."""

import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins.layout import lay
from nephrite.plugins.lookup import Lookup
from nephrite.plugins.media import Media
from nephrite.plugins.seen import seen
from nephrite.plugins.transport import shared
from support import scenes


def _shown(**camera):
    """Return how much is seen of the nodes of a ball, and their heights toward the camera."""
    scene = scenes.camera(8, **camera)
    scene["ball"] = {"type": "sphere", "radius": 3.0} | scenes.translucent(0.0, 1.0)
    scene = mi.load_dict(scene)
    (entry,) = Media.of(scene).entries
    members = [(entry, shape) for shape in entry.shapes]
    lookup = Lookup(members, [lay(entry, shape, scene) for entry, shape in members])
    sensor = scene.sensors()[0]
    eye = np.array(sensor.world_transform().translation()).ravel()
    return seen(scene, sensor, lookup, 1), lookup.points @ (eye / np.linalg.norm(eye)) / 3.0


def test_only_what_faces_the_camera_is_seen():
    shown, height = _shown()
    assert shown[height > 0.5].min() > 0
    assert shown[height < -0.2].max() == 0


def test_most_walks_begin_where_it_is_seen_but_some_everywhere():
    shown, height = _shown()
    begun = shared(1_000_000, shown)
    assert begun.sum() == pytest.approx(1_000_000, rel=0.01)
    assert begun[height > 0.8].mean() > 3 * begun[height < -0.2].mean()
    assert begun.min() > 0.1 * begun.mean()


def test_what_nobody_looks_at_is_walked_evenly():
    begun = shared(100_000, np.zeros(1_000))
    assert np.all(begun == 100)


def test_few_walks_begin_at_every_node():
    assert shared(10, np.arange(100.0)).min() == 1
