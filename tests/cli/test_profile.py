"""`nephrite profile`: plots and tables of models against the simulation."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nephrite.cli.app import app
from nephrite.cli.profile import percent
from nephrite.image import write

FEW = ["--photons", "4000", "--models", "dipole,photon_beam"]


def nephrite(*words: str | Path):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_plot_and_a_table(tmp_path):
    plot, table = tmp_path / "milk.png", tmp_path / "milk.csv"
    result = nephrite("profile", "skim milk", *FEW, "-o", plot, "--csv", table)
    assert result.exit_code == 0, result.output
    for text in ("red: ", "green: ", "blue: ", "dipole ", "photon_beam ", f"wrote {plot}", f"wrote {table}"):
        assert text in result.output
    notes = write.read_metadata(plot)
    assert (notes["material"], notes["models"], notes["photons"]) == (
        "skim-milk",
        "dipole,photon_beam",
        "4000",
    )
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert {row["channel"] for row in rows} == {"red", "green", "blue"}
    for row in rows:
        assert 0 <= float(row["r_from_mm"]) < float(row["r_to_mm"])
        assert 0 <= float(row["standard_error"]) <= float(row["simulation_per_mm2"])
        assert float(row["dipole"]) >= 0
        assert float(row["photon_beam"]) >= 0


@pytest.mark.slow
def test_svg_and_the_default_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert nephrite("profile", "skim milk", *FEW, "-o", "a.svg").exit_code == 0
    assert nephrite("profile", "skim milk", *FEW).exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.svg", "skim-milk-profile.png"]


def test_a_measured_profile_is_a_line(tmp_path):
    """One column for all channels, or one for each, even where the medium is the same in all."""
    file, own, table = tmp_path / "m.csv", tmp_path / "own.toml", tmp_path / "t.csv"
    own.write_text('[grey]\nunit = "1/mm"\nsigma_a = 0.1\nsigma_s = 1\n')
    words = [
        "profile",
        "grey",
        *FEW,
        "--material-file",
        own,
        "-o",
        tmp_path / "a.png",
        "--csv",
        table,
        "--profile",
        file,
    ]
    for columns, label in ((".1 .1 .1", "red: "), (".1", "all channels: ")):
        file.write_text("\n".join(f"{r} {columns}" for r in (0, 1)))
        result = nephrite(*words)
        assert result.exit_code == 0, result.output
        assert label in result.output
        assert "measured " in result.output
        first = next(csv.DictReader(table.read_text().splitlines()))
        assert float(first["measured"]) == pytest.approx(0.1, rel=1e-3)


def test_equal_channels_are_shown_once_and_empty_ones_named(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(
        '[grey]\nunit = "1/mm"\nsigma_a = 0.1\nsigma_s = 1\n'
        '[tea]\nunit = "1/mm"\nsigma_a = 0.1\nsigma_s = [0.5, 0, 0.5]\n'
        '[cola]\nunit = "1/mm"\nsigma_a = 0.1\nsigma_s = 0\n'
    )
    own = ["--material-file", file, "-o", tmp_path / "a.png"]
    assert "all channels: " in nephrite("profile", "grey", *FEW, *own).output
    tea = nephrite("profile", "tea", *FEW, *own)
    assert "red and blue: " in tea.output
    assert "green: does not scatter" in tea.output
    cola = nephrite("profile", "cola", *FEW, *own)
    assert cola.exit_code == 1
    assert "nothing to plot" in cola.output


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["skim milj"], "skim-milk"),
        (["jade", "--models", "dipol"], "'dipole'"),
        (["jade", "--models", ","], "--models"),
        (["jade", "-o", "a.jpg"], ".png or .svg"),
        (["jade", "-o", "no/such/folder/a.png"], "folder"),
        (["jade", "--csv", "a.txt"], ".csv"),
        (["jade", "--photons", "10"], "--photons"),
        (["jade", "--profile", "none.csv"], "cannot read the profile none.csv"),
    ],
)
def test_mistakes_are_told_before_anything_is_simulated(tmp_path, monkeypatch, words, says):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("nephrite.profiles.accuracy.simulate", lambda *_: pytest.fail("simulated"))
    result = nephrite("profile", *words)
    assert result.exit_code in (1, 2)
    assert says in " ".join(result.output.split())
    assert "Traceback" not in result.output
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_same_seed_gives_the_same_numbers(tmp_path):
    outputs = []
    for seed in (1, 1, 2):
        words = ["profile", "ketchup", *FEW, "--seed", seed, "-o", tmp_path / "a.png"]
        outputs.append(nephrite(*words).output.split("wrote")[0])
    assert outputs[0] == outputs[1] != outputs[2]


@pytest.mark.parametrize(
    ("fraction", "text"), [(0.0123, "+1.2 %"), (-0.0004, "+0.0 %"), (-0.15, "−15.0 %"), (1.234, "+123 %")]
)
def test_errors_have_the_digits_that_matter(fraction, text):
    assert percent(fraction) == text


def test_help_loads_nothing_slow():
    code = (
        "import sys; from nephrite.cli.app import app; from typer.testing import CliRunner\n"
        "assert CliRunner().invoke(app, ['profile', '--help']).exit_code == 0\n"
        "loaded = {'matplotlib', 'scipy', 'PIL'} & set(sys.modules); assert not loaded, loaded"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
