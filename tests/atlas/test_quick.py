"""The part of the atlas that continuous integration measures: no model is worse than recorded.

`tests/atlas/recorded.json` is what `nephrite atlas --quick` wrote. Record it anew, and say why, when a model is meant
to change. Seeds are fixed: where program and processor are the same, so are the numbers. The chance of a false alarm,
were the seeds drawn anew, is `watch.FALSE_ALARM`, 1 in 1000, over all rows together.
"""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path

import pytest

from nephrite.atlas import choice, measure, page, pictures, watch
from nephrite.atlas.plan import QUICK
from nephrite.atlas.store import Store
from nephrite.profiles.models import MODELS

RECORDED = json.loads((Path(__file__).parent / "recorded.json").read_text())


@pytest.fixture(scope="module")
def found():
    return measure.measured(QUICK, Store(None), tuple(MODELS))


@pytest.mark.slow
def test_no_model_has_become_worse(found):
    assert watch.worse(found, RECORDED) == []


@pytest.mark.slow
def test_the_recorded_figures_know_every_model(found):
    for part, key in (("half_spaces", "model"), ("slabs", "model"), ("pictures", "method")):
        assert {row[key] for row in RECORDED[part]} == {row[key] for row in found[part]}


@pytest.mark.slow
def test_the_page_says_what_was_found(found):
    made = page.Made("nephrite atlas --quick", "llvm_ad_rgb", 0.5, "data.json", "figures", QUICK.shown)
    assert "efficiency" not in page.text(found, QUICK, made), "a few small pictures say nothing about it"
    whole = {**found, "advice": choice.advice(found["pictures"]), "rules": []}
    text = page.text(whole, replace(QUICK, timed=True), made)
    for part in ("Which model should I use?", "Half-spaces", "Slabs", "Pictures"):
        assert f"\n## {part}\n" in text
    assert "Is `tabulated` nearer" in text
    for name in MODELS:
        assert f"`{name}`" in text
    assert found["date"] in text
    assert found["version"] in text
    assert "nan" not in text
    assert "inf" not in text


@pytest.mark.slow
def test_what_noise_leaves_open_gets_more_samples():
    plan = replace(QUICK, views=QUICK.views[:1], truth_spp=2, spp=2, finer=(2, 4))
    rows, (contest,) = pictures.pictures(plan, Store(None), ("walk", "tabulated", "photon_beam"))
    assert contest["finer"] == 4
    assert contest["rival"] == "photon_beam"
    errors = {row["method"]: row["error"] for row in rows}
    by_errors = errors["photon_beam"] ** 2 - errors["tabulated"] ** 2
    assert contest["lead"] == pytest.approx(by_errors, abs=3.0 * contest["lead_error"])


@pytest.mark.parametrize(
    ("part", "quantity", "change"),
    [
        ("half_spaces", "total", 0.01),
        ("half_spaces", "profile", 0.2),
        ("slabs", "reflected", 0.5),
        ("pictures", "error", 0.6),
        ("pictures", "bias", -0.5),
    ],
)
def test_a_worse_model_is_noticed(part, quantity, change):
    assert watch.worse(RECORDED, RECORDED) == []
    worse = copy.deepcopy(RECORDED)
    row = worse[part][0]
    row[quantity] += change if row[quantity] >= 0 else -change
    (message,) = watch.worse(worse, RECORDED)
    assert str(row.get("model", row.get("method"))) in message
    assert watch.worse(RECORDED, worse) == []


def test_a_row_that_is_gone_is_noticed_and_a_new_one_is_welcome():
    fewer = {**RECORDED, "slabs": RECORDED["slabs"][1:]}
    assert all("missing" in message for message in watch.worse(fewer, RECORDED))
    assert len(watch.worse(fewer, RECORDED)) == 2
    assert watch.worse(RECORDED, fewer) == []
