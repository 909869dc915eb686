"""S(0) reduced, S(1) single and Sd multiple, rendered alone, add up to all of them together.

Statistical, with fixed seeds: each test fails a right program with probability `measure.FALSE_ALARM`.
"""

import mitsuba as mi
import numpy as np
import pytest

from support import measure, scenes
from support.quick import slow

TERMS = ("reduced", "single", "multiple")


@pytest.mark.parametrize(
    "parameters",
    [
        {"model": "walk", "exit": "exact"},
        slow({"model": "walk", "exit": "lobe"}),
        slow({"model": "dipole"}),
        slow({"model": "brdf"}),
    ],
    ids=lambda p: "-".join(p.values()),
)
def test_terms_add_up(parameters):
    scene = mi.load_dict(scenes.trial(scenes.Trial("sphere", "skin"), resolution=12))
    parts = [
        measure.passes(scene, scenes.ours(terms=term, **parameters), 128, 12, 1000 * i)
        for i, term in enumerate(TERMS, 1)
    ]
    whole = measure.passes(scene, scenes.ours(**parameters), 128, 12, 9000)
    added = measure.Passes(sum(part.pictures for part in parts))
    measure.assert_same(added, whole, label=str(parameters))
    shares = [float(part.mean.sum() / whole.mean.sum()) for part in parts]
    print("shares", np.round(shares, 3))
    assert shares[0] > 0.05
    assert shares[2] > 0.05
    assert (shares[1] > 0.02) == (parameters["model"] != "brdf")


@pytest.mark.slow
def test_two_terms_are_the_sum_of_each():
    scene = mi.load_dict(scenes.trial(scenes.Trial("slab", "skin"), resolution=12))
    one, two = (
        measure.passes(scene, scenes.ours(terms=t), 128, 8, i) for i, t in ((100, "reduced"), (200, "single"))
    )
    both = measure.passes(scene, scenes.ours(terms="single + reduced"), 128, 8, 300)
    measure.assert_same(measure.Passes(one.pictures + two.pictures), both)


@pytest.mark.parametrize("text", ["singel", "all+single", "", "single,multiple"])
def test_unknown_terms_are_errors_that_name_the_known_ones(text):
    with pytest.raises(RuntimeError, match=r"ParameterError: unknown term.*multiple, reduced, single"):
        mi.load_dict(scenes.ours(terms=text))


def test_a_glass_ball_is_all_reduced():
    scene = scenes.camera(8)
    scene["object"] = scenes.placed("sphere") | scenes.translucent(0.1, 0.0)
    scene["environment"] = scenes.environment(1.0)
    scene = mi.load_dict(scene)
    for term in TERMS[1:]:
        # what misses the ball, like every path that scatters in no medium, is reduced
        assert not measure.picture(scene, scenes.ours(terms=term)).any()
