"""`nephrite atlas`: the page, its figures and data; going on where it stopped."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from nephrite.atlas import plan
from nephrite.cli.app import app

TINY = replace(
    plan.QUICK, albedos=(0.9,), photons=2**12, slab_photons=2**12, slab_albedos=(0.9,), thicknesses=(2.0,),
    views=plan.QUICK.views[:1], resolution=(32, 32), truth_spp=4, spp=4,
)  # fmt: skip


def nephrite(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(plan, "QUICK", TINY)
    return ("atlas", "--quick", "--models", "dipole")


@pytest.mark.slow
def test_a_page_is_written_and_a_second_run_measures_nothing(tmp_path, few, monkeypatch):
    page, work = tmp_path / "a.md", tmp_path / "work"
    result = nephrite(*few, "-o", page, "--work", work)
    assert result.exit_code == 0, result.output
    assert "wrote" in result.output
    text = page.read_text()
    assert "nephrite atlas --quick" in text
    folder = tmp_path / "figures" / "a"
    (figure,) = folder.glob("*.png")
    assert f"(figures/a/{figure.name})" in text
    data = json.loads((folder / "atlas.json").read_text())
    assert data["methods"] == ["walk", "dipole", "brdf"]
    assert len(data["pictures"]) == 3

    monkeypatch.setattr("nephrite.atlas.pictures._render", None)
    monkeypatch.setattr("nephrite.physics.searchlight.simulate", None)
    again = nephrite(*few, "-o", page, "--work", work)
    assert again.exit_code == 0, again.output


def test_what_there_is_no_time_for_is_told(tmp_path, few):
    result = nephrite(*few, "-o", tmp_path / "a.md", "--work", tmp_path / "work", "--time", "0.001s")
    assert result.exit_code == 0, result.output
    assert "1 of 1 views are missing: run the same command again" in result.output


def test_ctrl_c_says_what_is_kept(tmp_path, few, monkeypatch):
    def stop(*given, **named):
        raise KeyboardInterrupt

    monkeypatch.setattr("nephrite.physics.searchlight.simulate", stop)
    result = nephrite(*few, "-o", tmp_path / "a.md", "--work", tmp_path / "work")
    assert result.exit_code == 130
    assert "the same command goes on" in " ".join(result.output.split())
    assert not (tmp_path / "a.md").exists()


def test_a_wrong_model_or_file_is_refused_at_once(tmp_path, few):
    assert "photon_beam" in nephrite("atlas", "--models", "photonbeam", "-o", tmp_path / "a.md").output
    assert nephrite(*few, "-o", tmp_path / "a.pdf").exit_code == 1
