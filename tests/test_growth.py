"""Growth's arithmetic on times that are known beforehand; what its processes do; its page."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks import methods  # noqa: E402
from benchmarks.growth import as_user, asked, page, renders, run  # noqa: E402
from benchmarks.growth import numbers as growth_numbers  # noqa: E402
from benchmarks.growth.asked import Results  # noqa: E402
from benchmarks.growth.numbers import Point  # noqa: E402
from benchmarks.peers import measure  # noqa: E402
from support.quick import slow  # noqa: E402

BLACK = np.zeros((6, 8, 3), np.uint8)
TITLES = {method.name: method.title for method in methods.all_methods(gpu=False)}


def numbers(sampling: float, before: float = 0.0, variance: float = 0.02) -> dict:
    return {
        "spp": 8, "sampling": sampling, "before": before, "variance": variance, "loaded": 1.0, "peak": 3 * 2**30,
        "version": "Mitsuba 3", "computed": "transport", "date": "2026-01-02T03:04+00:00",
    }  # fmt: skip


def command(seconds: float, **more: bool) -> dict:
    notes = {"model": "walk", "samples": "2", "noise_reached": "0.123", "denoised": "yes"}
    given = {"seconds": seconds, "peak": 2 * 2**30, "notes": notes, "date": "2026-01-02T03:05+00:00"}
    return {**given, **more}


# --- Numbers ---


class Clock:
    """Time that calls take: a second a sample, `setup` after each renewal, `start` for every call."""

    def __init__(self, setup: float, start: float) -> None:
        self.now, self.setup, self.start, self.fresh = 0.0, setup, start, True
        self.seeds: list[int] = []

    def renew(self) -> None:
        self.fresh = True

    def render(self, spp: int, seed: int) -> np.ndarray:
        self.seeds.append(seed)
        self.now += spp + self.start + (self.setup if self.fresh else 0.0)
        self.fresh = False
        return np.full((2, 2, 3), float(seed))


@pytest.mark.parametrize(("setup", "start"), [(30.0, 0.0), (0.0, 5.0), (0.0, 0.0)])
def test_what_is_paid_once_is_told_from_samples(setup: float, start: float) -> None:
    clock = Clock(setup, start)
    renderer = measure.Renderer(clock.render, "clock", startup=start > 0)
    told, pictures = renders.timed(renderer, clock.renew, 7, 8, lambda: clock.now)
    assert growth_numbers.cost(told) == {"sampling": pytest.approx(8.0), "before": pytest.approx(setup)}
    assert len(set(clock.seeds)) == len(clock.seeds)
    assert not np.array_equal(pictures["a"], pictures["b"])


def test_what_first_calls_differ_by_is_no_precomputation() -> None:
    told = {"spp": 8, "first": 8.5, "again": [8.0, 8.0], "once": 0.0}
    assert growth_numbers.cost(told)["before"] == 0.0


def test_time_to_equal_noise_pays_for_precomputation_once() -> None:
    """Twice the variance that is wanted needs twice the samples."""
    own = numbers(sampling=3.0, before=10.0, variance=0.02)
    assert growth_numbers.picture(own) == pytest.approx(13.0)
    assert growth_numbers.samples_to_goal(own) == pytest.approx(6.0)
    assert growth_numbers.to_goal(own) == pytest.approx(16.0)


def test_variance_is_relative_to_the_squared_mean() -> None:
    """Of 12,288 values: a mean square has a relative standard error of 1.3 %; five of them are one in a million."""
    a, b = (0.5 + np.random.default_rng(seed).normal(0.0, 0.1, (64, 64, 3)) for seed in (1, 2))
    found = growth_numbers.variance(a, b, np.ones((64, 64), bool))
    assert found == pytest.approx(0.1**2 / 0.5**2, rel=0.07)


def test_ratios_are_of_ends_and_of_extremes() -> None:
    assert growth_numbers.ratio([2.0, 8.0, 1.0]) == 0.5
    assert growth_numbers.range_of([2.0, 8.0, 1.0]) == 8.0
    assert math.isnan(growth_numbers.ratio([2.0]))
    assert [growth_numbers.within(x, 2.0) for x in (2.0, 2.1, math.nan)] == ["yes", "**no**", "-"]


def test_g_keeps_the_reduced_scattering() -> None:
    scene = {"g": 0.2, "sigma_s": [1.0, 2.0], "sigma_a": [0.1, 0.1]}
    found = run.anisotropic(scene, 0.9)
    np.testing.assert_allclose(np.array(found["sigma_s"]) * (1 - 0.9), np.array(scene["sigma_s"]) * (1 - 0.2))
    assert found["sigma_a"] == scene["sigma_a"]
    assert run.anisotropic(scene, 0.2) == scene


# --- Processes ---


@pytest.mark.parametrize("command_line", [as_user.from_outside, slow(as_user.with_memory)])
def test_the_command_line_is_measured(command_line) -> None:
    arguments = [
        "render",
        "sphere",
        "--resolution",
        "8x6",
        "--spp",
        "1",
        "--model",
        "brdf",
        "-o",
        "picture.png",
    ]
    found, _ = command_line({"arguments": arguments, "cold": False})
    assert found["seconds"] > 0
    assert found["notes"]["samples"] == "1"
    assert found["notes"]["denoised"] in ("yes", "no")


def test_a_command_that_fails_says_why() -> None:
    with pytest.raises(as_user.runner.FailedError, match="exit status 2"):
        as_user.with_memory({"arguments": ["render", "--glow"]})


# --- The page ---


def results() -> Results:
    similarity = {"bias": -0.02, "bias_error": 0.001, "error": 0.05, "error_error": 0.002, "worst": -0.1}
    return Results(
        triangles=[Point(11_000, {"walk": numbers(1.0)}), Point(871_000, {"walk": numbers(1.5)})],
        size=[
            Point(10, {"transport": numbers(1.0, 5.0)}),
            Point(100, {"transport": numbers(2.0, 5.0)}),
            Point(1000, {"transport": numbers(10.0, 5.0) | {"computed": "walk"}}),
        ],
        resolution=[Point(120_000, {"walk": command(5.0)}), Point(8_294_400, {"walk": command(60.0)})],
        g=[
            Point(0.0, {"walk": numbers(1.0)}),
            Point(0.9, {"walk": numbers(3.0) | {"similarity": similarity | {"worst_error": 0.01}}}),
        ],
        first=[(command(13.0, cold=True), BLACK), (command(9.0, cold=False), BLACK)],
    )  # fmt: skip


def rows(text: str) -> dict[str, list[str]]:
    """Return the first table's cells by its first column."""
    lines = text.partition("## Asked and measured")[2].partition("\n## ")[0].splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return {row[0]: row[1:] for row in cells}


def test_what_was_asked_stands_beside_what_was_measured() -> None:
    found = rows(asked.asked(results()))
    assert found["triangles 11,000 -> 871,000: `walk`"] == ["time x 2", "x 1.50", "yes"]
    assert found["triangles 11,000 -> 871,000: `cycles`"][1:] == ["-", "-"]
    told = "size 10 -> 1,000 mm: `transport`, {}, last to first"
    assert found[told.format("with its precomputation")][1:] == ["x 3.57 (`walk` at 1,000 mm)", "**no**"]
    assert found[told.format("its samples alone")][1:] == ["x 10.00 (`walk` at 1,000 mm)", "**no**"]
    assert found["120,000 -> 8,294,400 pixels: `walk`"][1:] == ["2.00 GiB", "yes"]
    assert (
        found["g 0 -> 0.9: `walk`"][1] == "not used; from the first event on its error would be 5.0 ± 0.2 %"
    )
    assert found["first picture, the slowest: `walk`, kernels kept"][1:] == ["9.0 s", "yes"]
    assert found["first picture, the slowest: `walk`, no kernels kept"][1:] == ["13.0 s", "**no**"]
    assert found["first picture, the slowest: `transport`, kernels kept"][1:] == ["-", "-"]


def test_nothing_is_said_of_growth_that_was_not_measured_to_its_end() -> None:
    cut = Results(triangles=[Point(1, {"walk": numbers(1.0)}), Point(2, {"walk": numbers(1.0)}), Point(3)])
    assert rows(asked.asked(cut))["triangles 1 -> 3: `walk`"][1:] == ["-", "-"]


def test_the_page_has_its_plots_and_survives_what_is_missing(tmp_path: Path) -> None:
    for found in (results(), Results()):
        written = page.write(
            tmp_path / "growth.md", found, TITLES, {"bpy": "no wheel"}, run.FULL, quick=False
        )
        text = written.read_text(encoding="utf-8")
        assert "- bpy: no wheel" in text
        linked = [part.partition(")")[0] for part in text.split("](")[1:] if part.startswith("figures")]
        assert all((tmp_path / link).stat().st_size < 100_000 for link in linked)
        assert len(linked) == (5 if found.triangles else 0)
        assert "{" not in text
