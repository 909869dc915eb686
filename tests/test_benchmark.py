"""The benchmark's arithmetic, on times and errors that are known beforehand; its scenes, processes and page."""

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nephrite.atlas.compared import Estimate
from nephrite.physics import Medium
from nephrite.physics.color import from_color_and_radius

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks import analysis, asked, bench, methods, page, runner, scenes  # noqa: E402
from benchmarks.peers import measure, sky  # noqa: E402
from benchmarks.store import Store  # noqa: E402

SHAPE = (64, 64, 3)


def truth(error: float = 0.0) -> analysis.Truth:
    mask = np.ones(SHAPE[:2], bool)
    return analysis.Truth(Estimate(np.full(SHAPE, 0.5), np.full(SHAPE, error)), mask)


def noisy(deviation: float, seed: int, bias: float = 0.0) -> np.ndarray:
    return 0.5 * (1 + bias) + np.random.default_rng(seed).normal(0.0, deviation, SHAPE)


# --- Error over time ---


def curve(seconds: list[float], bias: float, variance: float) -> list[dict[str, float]]:
    return [
        {"spp": t, "seconds": t, "relmse": bias + variance / t, "noise": variance / t, "floor": bias}
        for t in seconds
    ]


def test_time_is_read_off_the_curve() -> None:
    reached = analysis.time_to_goal(curve([1, 2, 4, 8], 0.0, 0.03), 0.01)
    assert reached.how == "="
    assert reached.seconds == pytest.approx(3.0, rel=1e-9)


def test_time_beyond_the_curve_follows_noise_and_bias() -> None:
    reached = analysis.time_to_goal(curve([1, 2, 4], 0.002, 0.08), 0.01)
    assert reached.how == "~"
    assert reached.seconds == pytest.approx(10.0)


def test_bias_above_the_goal_never_gets_there() -> None:
    assert math.isinf(analysis.time_to_goal(curve([1, 2, 4], 0.02, 0.01), 0.01).seconds)


def test_a_first_point_below_the_goal_is_a_limit() -> None:
    assert analysis.time_to_goal(curve([1, 2], 0.0, 0.005), 0.01) == analysis.TimeToGoal(1, "<")


def test_what_is_precomputed_is_paid_before_the_first_sample() -> None:
    """5 s, and .1 s a sample, of which 30 are enough: 8 s, whichever side of the levels that is on."""
    for samples in ([8, 16], [16, 64], [64, 256]):
        dear = [
            {"spp": n, "seconds": 5 + 0.1 * n, "relmse": 0.3 / n, "noise": 0.3 / n, "floor": 0.0}
            for n in samples
        ]
        assert analysis.time_of_noise(dear, 0.01) == pytest.approx(8.0)
        if samples[0] < 30:
            assert analysis.time_to_goal(dear, 0.01).seconds == pytest.approx(8.0)
    alone = dear[1:]  # 256 samples: nobody knows what fewer would take
    assert analysis.time_of_noise(alone, 0.01) == pytest.approx(30.6)


def test_noise_of_the_truth_is_no_bias() -> None:
    """A truth with 50 % of noise, and a picture without any: within five standard errors, .004 and no floor are left.

    A pixel is one in 25 of those around. Divided by its own square, .7 would be left: what is dark counts more then.
    """
    rough = analysis.Truth(Estimate(noisy(0.25, 5), np.full(SHAPE, 0.25)), np.ones(SHAPE[:2], bool))
    found = analysis.level(noisy(0.01, 1), noisy(0.01, 2), 1, 1.0, rough)
    assert found["relmse"] == pytest.approx(0.0, abs=5 * 0.25**2 / 0.26 * math.sqrt(2 / 12288) + 0.004)
    assert found["floor"] == 0.0


def test_relmse_leaves_the_noise_of_the_truth_out() -> None:
    """Of 12,288 values: a mean square has a relative standard error of 1.3 %; five of them are one in a million."""
    clean = truth()
    blurred = analysis.Truth(Estimate(noisy(0.05, 3), np.full(SHAPE, 0.05)), clean.mask)
    a, b = noisy(0.1, 1), noisy(0.1, 2)
    expected = 0.1**2 / (0.5**2 + 0.01)
    for reference in (clean, blurred):
        found = analysis.level(a, b, 1, 2.0, reference)
        assert found["relmse"] == pytest.approx(expected, rel=0.07)
        assert found["noise"] == pytest.approx(expected, rel=0.07)
        assert found["floor"] == 0.0
    assert found["efficiency"] == pytest.approx(0.5**2 / (0.1**2 * 2.0), rel=0.07)


def test_bias_is_told_from_noise() -> None:
    """The product's standard error is 0.01^2 / 0.26 / sqrt(12288) = 3.5e-6, and that of 2 x 0.05 x 0.01 alike."""
    found = analysis.level(noisy(0.01, 1, 0.1), noisy(0.01, 2, 0.1), 1, 1.0, truth())
    assert found["floor"] == pytest.approx(0.05**2 / 0.26, rel=0.02)


def test_bias_is_found_within_its_error() -> None:
    estimate = analysis.mean_of([(noisy(0.1, 2 * i, 0.03), noisy(0.1, 2 * i + 1, 0.03)) for i in range(3)])
    found = analysis.against_truth(estimate, truth())
    assert found.bias == pytest.approx(0.03, abs=5 * found.bias_error)
    assert found.bias_error == pytest.approx(0.1 / 0.5 / math.sqrt(6 * 64 * 64 * 3), rel=0.05)
    assert abs(found.worst - 0.03) < 5 * found.worst_error


def test_blocks_tell_who_never_gets_there() -> None:
    """A bias of 12 % is 1.44 % in relMSE; one of 8 % is 0.64 %. Noise of 50 % a pixel hides neither."""
    for bias, expected in ((0.12, True), (0.08, False)):
        pairs = [(noisy(0.25, 2 * i, bias), noisy(0.25, 2 * i + 1, bias)) for i in range(3)]
        assert analysis.never(analysis.against_truth(analysis.mean_of(pairs), truth())) is expected


def test_ratios_are_taken_round_by_round() -> None:
    slow_machine = [2.0, 8.0]  # both sides take four times as long in the second round
    assert analysis.ratio([20.0, 80.0], slow_machine) == analysis.Spread(pytest.approx(10.0), 10.0, 10.0)
    assert analysis.ratio([1.0], [math.inf]) is None


def test_a_curve_is_the_mean_at_equal_samples() -> None:
    """Rounds may end at other numbers: a mean of 32 and 64 samples would say nothing of either."""
    rounds = [
        {
            "curve": [
                point | {"seconds": slow * point["seconds"], "efficiency": 1.0}
                for point in curve(samples, 0.0, 1.0)
            ],
            "samples": 1,
            "peak": 1,
            "version": "1",
        }
        for slow, samples in ((1, [8, 32]), (3, [8, 16, 32, 64]))
    ]
    assert [point["seconds"] for point in analysis.summary(rounds)["curve"]] == [16, 48, 64, 192]


# --- What a peer's process does ---


class Clock:
    """Time that only rendering takes: `setup` a call, and one second a sample, or `sample` of them."""

    def __init__(self, setup: float, sample: float = 1.0) -> None:
        self.now, self.setup, self.sample, self.asked = 0.0, setup, sample, []

    def render(self, spp: int, seed: int) -> np.ndarray:
        self.asked.append((spp, seed))
        self.now += self.setup + spp * self.sample
        return np.zeros((2, 2, 3))


@pytest.mark.parametrize("setup", [0.0, 5.0])
def test_setup_is_taken_off_where_it_is_paid_again(setup: float) -> None:
    clock = Clock(setup)
    renderer = measure.Renderer(clock.render, "clock", startup=True)
    levels, _ = measure.climb(renderer, 7, 100.0, lambda: clock.now)
    assert [level["seconds"] for level in levels] == pytest.approx([level["spp"] for level in levels])


def test_climbing_ends_in_time_and_repeats_no_seed() -> None:
    clock = Clock(0.0)
    renderer = measure.Renderer(clock.render, "clock")
    levels, pictures = measure.climb(renderer, 100, 62.0, lambda: clock.now)
    assert [level["spp"] for level in levels] == [1, 2, 4, 8, 16]
    assert set(pictures) == {f"{side}{i}" for side in "ab" for i in range(5)}
    seeds = [seed for _, seed in clock.asked]
    assert len(seeds) == len(set(seeds))


@pytest.mark.parametrize(
    ("setup", "expected"), [(5.0, [8, 64, 512]), (100.0, [256, 1024]), (0.5, [1, 2, 4, 8, 16, 32, 64])]
)
def test_a_dear_precomputation_is_paid_for_once_a_picture_and_counted(
    setup: float, expected: list[int]
) -> None:
    """A quarter of 5 s, and what is left of a minute, for samples of .125 s: 10 and 440, and one between.

    100 s are more than that, and as much is left for samples; .5 s are not dear.
    """
    clock = Clock(setup, 0.125)
    levels, pictures = measure.climb(measure.Renderer(clock.render, "clock"), 100, 60.0, lambda: clock.now)
    assert [level["spp"] for level in levels] == expected
    assert [level["seconds"] for level in levels] == [setup + spp * 0.125 for spp in expected]
    seeds = [seed for _, seed in clock.asked]
    assert len(seeds) == len(set(seeds))
    assert len(pictures) == 2 * len(expected)


@pytest.mark.parametrize("noise", [(0.0, 1.0, 0.2), (0.0, 0.0, 1.6)])
def test_noise_in_a_dear_precomputation_is_not_taken_for_that_of_samples(noise: tuple[float, ...]) -> None:
    """Of 60 s, less 5 of precomputation, 55 s at .02 s a sample: 2750; calls differ by 1.6 s at most."""
    clock = Clock(5.0, 0.02)

    def render(spp: int, seed: int) -> np.ndarray:
        clock.now += noise[len(clock.asked) % 3]
        return clock.render(spp, seed)

    levels, _ = measure.climb(measure.Renderer(render, "clock"), 100, 60.0, lambda: clock.now)
    assert [level["spp"] for level in levels] == [64, 256, 2048]


@pytest.mark.parametrize("sample", [4.0, 40.0])
def test_dear_samples_are_no_precomputation(sample: float) -> None:
    clock = Clock(0.1, sample)
    levels, _ = measure.climb(measure.Renderer(clock.render, "clock"), 100, 60.0, lambda: clock.now)
    assert levels[0]["spp"] == 1


def test_memory_is_this_process_own() -> None:
    assert 2**24 < measure.peak_memory() < 2**40


# --- Scenes and methods ---


def test_scenes_hold_matched_materials(tmp_path: Path) -> None:
    """Colour and mean free path, as artists' renderers get them, are the medium of the coefficients."""
    scene = next(scene for scene in scenes.SCENES if scene.object == "slab")
    found = json.loads(json.dumps(scenes.described(scene, (8, 6), tmp_path)))
    assert Path(found["mesh"]).is_file()
    given = Medium(found["sigma_a"], found["sigma_s"], found["g"], found["eta"])
    again = from_color_and_radius(found["color"], found["radius"], found["g"], found["eta"])
    np.testing.assert_allclose(again.sigma_s, given.sigma_s, rtol=2e-3)
    np.testing.assert_allclose(again.sigma_a, given.sigma_a, rtol=2e-2)


def test_names_are_distinct_and_the_base_is_among_them() -> None:
    names = [method.name for method in methods.all_methods(gpu=True)]
    assert len(names) == len(set(names))
    assert methods.BASE in names


def test_transport_takes_part_when_there_is_such_a_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(methods, "MODELS", ("walk", "transport"))
    assert [m.name for m in methods.nephrite()] == ["walk-exact", "walk", "transport"]


def test_the_sky_is_its_ambient_away_from_its_lobes() -> None:
    given = {
        "ambient": [1, 2, 3],
        "lobes": [{"direction": [0, 2, 0], "sharpness": 50, "radiance": [4, 5, 6]}],
    }
    up, down = sky.radiance(given, np.array([[0.0, 1, 0], [0, -1, 0]]))
    np.testing.assert_allclose(up, [5, 7, 9])
    np.testing.assert_allclose(down, [1, 2, 3])


# --- Running, keeping, writing ---


def test_results_answer_only_what_was_asked(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.save("b1/walk-0", {"seed": 1}, {"peak": 2}, {"a": np.ones(3)})
    numbers, pictures = store.load("b1/walk-0", {"seed": 1}) or ({}, {})
    assert numbers == {"peak": 2}
    np.testing.assert_array_equal(pictures["a"], np.ones(3))
    assert store.load("b1/walk-0", {"seed": 2}) is None


def test_b1_has_the_longest_reference_and_slow_peers_one_round(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs: list[tuple[str, dict[str, Any]]] = []

    def run(module: str, python: Path, job: dict[str, Any], *_: Any) -> Any:
        jobs.append((module, job))
        if module == "benchmarks.reference":
            return {"mean": np.ones((3, 4, 3)), "error": np.zeros((3, 4, 3)), "mask": np.ones((3, 4))}
        level = {"spp": 1, "seconds": 1.0}
        told = {"levels": [level], "peak": 1, "loaded": 0.0, "version": "1"}
        return told, {"a0": np.ones((3, 4, 3)), "b0": np.ones((3, 4, 3))}

    monkeypatch.setattr(bench, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "run", run)
    monkeypatch.setattr(runner, "missing", lambda *_: {})
    monkeypatch.setattr(scenes, "described", lambda scene, *_: {"name": scene.name})
    given = argparse.Namespace(
        quick=False, gpu=False, resolution="4x3", peers=tmp_path, seconds=60.0, reference=30.0, rounds=2,
        each=1.0, scenes=["b1", "skin"], methods=["walk", "luxcore"],
    )  # fmt: skip
    assert [len(result.runs) for result in bench.Bench(given).run()] == [2, 2]
    assert [job["seconds"] for module, job in jobs if module == "benchmarks.reference"] == [30.0, 10.0]
    rendered = [module.rpartition(".")[2] for module, _ in jobs[2:]]
    assert sorted(rendered) == ["luxcore"] * 2 + ["mitsuba"] * 4
    bench.Bench(given).run()  # all of it has been kept
    assert len(jobs) == 8


def test_a_peer_that_is_not_there_is_named_not_fatal(tmp_path: Path) -> None:
    assert set(runner.missing(["bpy"], tmp_path / "python")) == {"bpy"}
    told = runner.missing(["json", "no_such_renderer"], Path(sys.executable))
    assert list(told) == ["no_such_renderer"]
    assert "no_such_renderer" in told["no_such_renderer"]


def test_a_process_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(runner.FailedError, match=r"KeyError: 'scene'"):
        runner.run(
            "benchmarks.reference", Path(sys.executable), {"variant": "llvm_ad_rgb"}, 60.0, runner.truth
        )


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0123, "0.012"), (1.0, "1.0"), (99.6, "100"), (12345.0, "12,000"), (1e9, "> 1,000,000")],
)
def test_numbers_have_two_digits(value: float, shown: str) -> None:
    assert page.short(value) == shown


def test_what_was_asked_is_told_by_ratios_of_each_round() -> None:
    """Efficiency: higher is better; time: shorter, by noise alone for the other."""
    fast = {"efficiency": [8.0, 2.0], "goal": [5.0, 5.0], "quiet": [4.0, 4.0]}
    slow = {"efficiency": [2.0, 2.0], "goal": [math.inf, math.inf], "quiet": [20.0, 80.0]}
    numbers = {"transport": fast, "volpathmis": slow}
    by_efficiency, by_time = (
        asked.Asked("transport", "volpathmis", how, 2.0).measured(numbers) for how in (True, False)
    )
    assert by_efficiency == analysis.Spread(pytest.approx(2.0), 1.0, 4.0)
    assert by_time == analysis.Spread(pytest.approx(8.0), 4.0, 16.0)
    assert asked.Asked("walk", "volpathmis", True, 2.0).measured(numbers) is None


def test_the_page_without_results_says_how_to_get_them(tmp_path: Path) -> None:
    given = {"rounds": 3, "each": 20.0, "quick": False, "resolution": "400x300"}
    file = page.write(
        tmp_path / "benchmark.md", [], methods.all_methods(gpu=False), {"Cycles": "no wheel"}, given
    )
    text = file.read_text(encoding="utf-8")
    assert "make bench" in text
    assert "- Cycles: no wheel" in text
