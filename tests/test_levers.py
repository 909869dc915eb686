"""What levers are taken away by, their arithmetic, and their page."""

import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest

from support import measure
from support.scenes import Trial, ours, trial

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks import dipole  # noqa: E402
from benchmarks.levers import noise, page, patches  # noqa: E402
from benchmarks.levers.patches import LEVERS, TRANSPORT, WALK, Lever  # noqa: E402

BOTH = [(model, lever) for model, levers in LEVERS.items() for lever in levers]


def state() -> dict[Any, dict[str, Any]]:
    """Return what the modules and classes hold that levers are taken away from."""
    modules = [one for one in vars(patches).values() if inspect.ismodule(one)]
    return {one: dict(vars(one)) for one in [*modules, patches.sequence.OfPixels]}


@pytest.fixture
def restored() -> Iterator[None]:
    """Put back what a lever was taken away from."""
    before = state()
    yield
    for owner, values in before.items():
        for name, value in values.items():
            if vars(owner).get(name) is not value:
                setattr(owner, name, value)


@pytest.mark.parametrize(("model", "lever"), BOTH, ids=[f"{m}-{lever.name}" for m, lever in BOTH])
@pytest.mark.usefixtures("restored")
def test_something_is_taken_away(model: str, lever: Lever) -> None:
    before = state()
    lever.take_away()
    changed = [
        name for owner, values in state().items() for name in values if before[owner].get(name) is not values[name]
    ]  # fmt: skip
    assert changed or lever.settings
    assert not set(changed) - set().union(*before.values())  # nothing but what has been there


@pytest.mark.slow
@pytest.mark.parametrize("lever", [one for one in LEVERS[WALK] if not one.settings], ids=lambda one: one.name)
@pytest.mark.usefixtures("restored")
def test_the_picture_stays_what_it_is(lever: Lever) -> None:
    scene = mi.load_dict(trial(Trial("sphere", "skim milk")))
    with_ = measure.passes(scene, ours(), 64, 8, 1)
    lever.take_away()
    measure.assert_same(measure.passes(scene, ours(), 64, 8, 101), with_, label=lever.name)


def told(efficiency: float) -> dict[str, Any]:
    noise = {"reduced": 0.1, "single": 0.3, "multiple": 0.5}
    parts = {"nodes": 1.0, "light": 0.0}
    rays = {"steps and segments": 16.0, "shadow rays": 1.0, "to lamps and surfaces": 0.5}
    where = {"compiling": 3.0, "kernels": 7.0, "parts": parts, "all": 8.0, "rays": rays}
    return {"efficiency": efficiency, "where": where, "noise": noise, "date": "2026-01-02T03:04+00:00"}


def test_worth_is_a_ratio_of_efficiencies_round_by_round() -> None:
    runs = {"": [told(4.0), told(4.0)], "lanes": [told(1.0), told(4.0)]}
    assert page.worth(runs, "lanes") == pytest.approx((2.0, 1.0, 4.0))


def test_the_page_has_all_levers_and_times(tmp_path: Path) -> None:
    found = {
        model: {name: [told(4.0)] for name in ("", *(lever.name for lever in LEVERS[model]))}
        for model in LEVERS
    }
    settings = {"resolution": "8x6", "rounds": 1, "spp": {WALK: 1, TRANSPORT: 2}}
    text = page.write(tmp_path / "docs/levers.md", found, settings).read_text(encoding="utf-8")
    assert all(lever.title in text for levers in LEVERS.values() for lever in levers)
    assert "| rays a sample: steps and segments | 16.00 | 16.00 |" in text
    assert "| of it Python, NumPy and SciPy, while no kernel runs | 1.00 | 1.00 |" in text
    assert "| single | 0.30000 | 0.30000 |" in text


def test_the_noise_of_a_term_is_relative_to_the_light_of_all() -> None:
    """Means of 1, 2, 5, which are 8 together, and deviations of .1, .2, .5: within 10 %, 7 standard errors."""
    means = dict(zip(noise.TERMS, (1.0, 2.0, 5.0), strict=True))

    def picture(seed: int, term: str) -> np.ndarray:
        rng = np.random.default_rng([seed, *map(ord, term)])
        return means[term] * (1 + 0.1 * rng.standard_normal((100, 100, 1)))

    found = noise.of_terms(picture, np.ones((100, 100), bool))
    for term, mean in means.items():
        assert found[term] == pytest.approx((0.1 * mean / 8) ** 2, rel=0.1)


@pytest.mark.parametrize(("distance", "least", "most"), [(100.0, 0.0, 1e-4), (1.2, 0.1, 10.0)])
def test_places_on_a_lamp_differ_where_it_is_near(distance: float, least: float, most: float) -> None:
    turn = mi.ScalarTransform4f()
    scene = mi.load_dict({
        "type": "scene",
        "sensor": {
            "type": "perspective", "to_world": turn.look_at(origin=[0, 0, 0.5], target=[0, 0, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 8, "height": 8},
        },
        "floor": {"type": "rectangle"},
        "lamp": {
            "type": "rectangle", "emitter": {"type": "area"},
            "to_world": turn.translate([0, 0, distance]).rotate([1, 0, 0], 180).scale(3),
        },
    })  # fmt: skip
    assert least <= noise.of_lamps(scene) < most


def test_parts_of_a_dipole_are_left_out_and_put_back() -> None:
    def found() -> dict[tuple[Any, str], Any]:
        return {
            (owner, name): getattr(owner, name) for owner, name, _ in (dipole.PARTS | dipole.FEWER).values()
        }

    before = found()
    for _, parts in dipole.cases().values():
        with dipole.changed(parts):
            now = found()
            changed = {where for where in before if before[where] is not now[where]}
        assert changed == {(dipole.PARTS | dipole.FEWER)[name][:2] for name in parts}
        assert found() == before
