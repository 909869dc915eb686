"""`walk` with exact exits has the expectation of Mitsuba's `volpathmis`, on standard scenes and on our BSDF.

Statistical: each test fails a right program with probability `measure.FALSE_ALARM`; seeds are fixed.
"""

import mitsuba as mi
import pytest

from support import measure, scenes

EXACT = scenes.ours(model="walk", exit="exact")
COUNT = 16
BOTH = [scenes.TRIALS[i].name for i in (0, 4, 5)]


@pytest.mark.slow
@pytest.mark.parametrize("trial", scenes.TRIALS, ids=lambda trial: trial.name)
def test_exact_walk_equals_volpathmis(trial):
    scene = mi.load_dict(scenes.trial(trial))
    truth = measure.passes(scene, scenes.TRUTH, 128, COUNT, 1000)
    walk = measure.passes(scene, EXACT, 256, COUNT, 5000)
    measure.assert_same(walk, truth, label=trial.name)
    if trial.name in BOTH:
        own = measure.passes(scenes.trial(trial, "translucent"), EXACT, 256, COUNT, 9000)
        measure.assert_same(own, truth, label=f"{trial.name} translucent")
