"""Walks that go on by similarity once they have forgotten their direction: they end where all others do."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import walked
from nephrite.plugins.media import Media
from nephrite.plugins.shapes import start
from support import scenes

WALKS = 1 << 20
EDGES = (0.0, 4.0, 8.0, 12.0, 16.0, 30.0)  # distances between a walk's ends
CLOSE = 0.004  # of the light: what similarity may be off, for all and for each of these


def ends(trial: scenes.Trial) -> tuple[np.ndarray, np.ndarray]:
    """Return the light of walks from all over a shape, by how far they get, and its error: [distances, channels]."""
    scene = mi.load_dict(scenes.trial(trial))
    media = Media.of(scene)
    (entry,) = media.entries
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, WALKS)
    begun = start(scene, media.winding, entry.shapes[0], sampler)
    found = walked.walk(scene, 5, entry, begun.si, entry.shapes[0], dr.arange(mi.UInt32, WALKS))
    length = np.array(dr.norm(found.p - begun.si.p))
    weight = np.array(found.weight).T
    bins = np.digitize(length, EDGES) - 1
    each = [np.where((bins == i)[:, None], weight, 0.0) for i in range(len(EDGES) - 1)]
    return np.array([x.mean(0) for x in each]), np.array([x.std(0) for x in each]) / WALKS**0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "medium", "g"),
    [("sphere", "skim milk", 0.9), ("slab", "skim milk", 0.9), ("cube", "skin", 0.5)],
)
def test_walks_end_where_they_would(
    shape: str, medium: str, g: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial = scenes.Trial(shape, medium, g=g)
    similar, error = ends(trial)
    monkeypatch.setattr(walked, "_SIMILAR", 1e9)
    exact, own_error = ends(trial)
    # noise of 4 standard errors: of 15 values in three cases, one is beyond in 3 of 1000 draws of seeds
    noise = 4.0 * np.hypot(error, own_error)
    assert (abs(similar - exact) < CLOSE * exact.sum(0) + noise).all()
