"""`nephrite compare`: figures, and the numbers in them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from nephrite.cli import panels
from nephrite.cli.app import app
from nephrite.cli.compare import split
from nephrite.cli.job import Settings
from nephrite.image import write
from nephrite.rendering.result import Result
from support.quick import slow

TINY = ["--resolution", "32x24", "--spp", "2", "--variant", "llvm_ad_rgb"]


def nephrite(*words: str | Path):
    return CliRunner().invoke(app, [str(word) for word in words])


def panel(label: str, brightness: float, mask: np.ndarray | None = None) -> panels.Panel:
    pixels = np.full((6, 8, 3), brightness, np.float32)
    result = Result(pixels, pixels, 0.01, 4, 1.5, 2, False, "spp", 0, 0)
    return panels.Panel(label, result, pixels, np.ones((6, 8), bool) if mask is None else mask)


@pytest.mark.parametrize(
    ("ways", "labels"),
    [
        (["--materials", "jade, skim milk"], ["jade", "skim milk"]),
        slow(["--models", "brdf | walk"], ["brdf", "walk"]),
        (["--terms", "single,reduced+single,all"], ["single", "reduced+single", "all"]),
        slow(["--models", "brdf,walk", "--materials", "jade,ketchup"], ["brdf, jade", "walk, ketchup"]),
    ],
)
def test_every_way_is_a_panel(tmp_path, ways, labels):
    path = tmp_path / "figure.png"
    result = nephrite("compare", "sphere", *ways, *TINY, "-o", path)
    assert result.exit_code == 0, result.output
    for label in labels:
        assert re.search(rf"^{re.escape(label)}: ", result.output, re.MULTILINE)
    notes = write.read_metadata(path)
    assert set(labels) <= set(notes["compared"].split(" | "))
    assert notes["reference"] == labels[-1]


def test_the_reference_may_be_the_first(tmp_path):
    path = tmp_path / "figure.png"
    assert (
        nephrite(
            "compare", "cube", "--models", "walk,brdf", "--reference", "first", *TINY, "-o", path
        ).exit_code
        == 0
    )
    assert write.read_metadata(path)["reference"] == "walk"


@pytest.mark.slow
def test_a_thickness_goes_to_the_model_that_it_belongs_to(tmp_path):
    path = tmp_path / "figure.png"
    words = ["--models", "dipole,multipole,walk", "--thickness", "10mm"]
    result = nephrite("compare", "slab", *words, *TINY, "-o", path)
    assert result.exit_code == 0, result.output
    assert write.read_metadata(path)["thickness"] == "10mm"


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--models", "walk,brdf", "--thickness", "10mm"], 1, "belongs to the model multipole"),
        (["--models", "walk,measured"], 1, "needs a profile"),
        ([], 1, "nothing to compare"),
        (["--models", "walk"], 1, "nothing to compare"),
        (["--models", "walk,walk"], 1, "nothing to compare"),
        (["--models", "walk,dipol"], 1, "Did you mean 'dipole'"),
        (["--materials", "jade,jda"], 1, "unknown material"),
        (["--models", "walk,brdf", "-o", "a.exr"], 1, "PNG"),
        (["--models", "walk,brdf", "--reference", "middle"], 2, "unknown reference"),
    ],
)
def test_bad_input_is_refused(tmp_path, monkeypatch, words, code, says):
    monkeypatch.chdir(tmp_path)
    result = nephrite("compare", "sphere", *words)
    assert result.exit_code == code
    assert says in result.output.replace("│", " ").replace("\n", " ").replace("  ", " ")
    assert not list(tmp_path.iterdir())


def test_lists_are_separated_by_commas_or_bars() -> None:
    assert split(" a| b,c ,,a") == ["a", "b", "c"]


def test_variations_are_every_combination_in_order() -> None:
    made = panels.variations(Settings("sphere"), {"model": ["brdf", "walk"], "terms": ["single", "all"]})
    assert list(made) == ["brdf, single", "brdf, all", "walk, single", "walk, all"]
    assert (made["walk, single"].model, made["walk, single"].terms) == ("walk", "single")


def test_differences_are_those_of_the_objects_pixels() -> None:
    mask = np.zeros((6, 8), bool)
    mask[:3] = True
    bright, reference = panel("bright", 1.2), panel("reference", 1.0, mask)
    bright.result.pixels[3:] = 77.0
    found = panels.differences([bright, reference], reference)
    assert found[0].mean == pytest.approx(0.2, rel=1e-5)
    assert found[0].relmse == pytest.approx(0.04 / 1.01, rel=1e-4)
    assert (found[1].mean, found[1].relmse) == (0.0, 0.0)
    assert str(found[0]) == "mean +20.0%, relMSE 0.0396"


def test_a_figure_has_panels_above_and_differences_below() -> None:
    few = panels.laid_out([panel("a", 0.5), panel("b", 1.0)], panel("c", 0.2), "title", 0.0)
    many = panels.laid_out([panel("a", 0.5), panel("b", 1.0), panel("d", 0.1)], panel("c", 0.2), "title", 0.0)
    assert few.dtype == np.uint8
    assert many.shape[1] > few.shape[1]
