"""`nephrite doctor`: what is there, what is missing, and what to do about it."""

from __future__ import annotations

import subprocess

import pytest
from typer.testing import CliRunner

from nephrite.cli import doctor, variant
from nephrite.cli.app import app
from nephrite.errors import MissingDependencyError, ParameterError
from nephrite.scene import cache

WELL = doctor.Finding("LLVM", "ok", "20.1.0")
ILL = doctor.Finding("LLVM", "broken", "no library", "install it")
NO_GPU = doctor.Finding("CUDA", "missing", "no driver", "buy one")


def test_this_machine_can_render() -> None:
    result = CliRunner().invoke(app, ["doctor"])
    assert result.exit_code == 0, result.output
    for word in ("Python", "Mitsuba", "Dr.Jit", "LLVM", "CUDA", "OIDN", "npm", "Meshes", "Ready to render"):
        assert word in result.output


def test_a_machine_that_cannot_render_is_told_what_to_do(monkeypatch) -> None:
    monkeypatch.setattr(doctor, "probe_backends", lambda: {"llvm": ILL, "cuda": NO_GPU})
    result = CliRunner().invoke(app, ["doctor"])
    assert result.exit_code == 1
    assert "install it" in result.output
    assert "Nothing here can render" in result.output


def test_an_llvm_that_aborts_is_reported(monkeypatch) -> None:
    done = subprocess.CompletedProcess([], -6, "", "LLVM ERROR: Cannot select: fminimum\nmore\n")
    monkeypatch.setattr(subprocess, "run", lambda *args, **kwargs: done)
    found = doctor.probe_backends()["llvm"]
    assert found.state == "broken"
    assert "LLVM ERROR: Cannot select" in found.detail
    assert "karellen-llvm-core" in found.remedy


def test_missing_npm_oidn_and_meshes_are_said(monkeypatch, tmp_path) -> None:
    from nephrite.image import denoise

    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    monkeypatch.setattr(denoise, "available", lambda: False)
    found = {finding.what: finding for finding in doctor.helpers()}
    assert found["npm"].state == found["OIDN"].state == "missing"
    assert "Node.js" in found["npm"].remedy
    assert "pyoidn" in found["OIDN"].remedy
    monkeypatch.setenv(cache.ENVIRONMENT_VARIABLE, str(tmp_path / "none"))
    assert next(iter(doctor.cached_meshes())).state == "missing"
    (tmp_path / "dragon.ply").write_bytes(b"x" * 1_500_000)
    monkeypatch.setenv(cache.ENVIRONMENT_VARIABLE, str(tmp_path))
    kept = next(iter(doctor.cached_meshes()))
    assert kept.state == "ok"
    assert "dragon.ply (1.5 MB)" in kept.detail


def test_the_fastest_variant_that_works_is_chosen(monkeypatch) -> None:
    assert variant.trouble("llvm_ad_rgb") is None
    for broken, expected in ((set(), "cuda_ad_rgb"), ({"cuda_ad_rgb"}, "llvm_ad_rgb")):
        monkeypatch.setattr(
            variant, "trouble", lambda name, broken=broken: "broken" if name in broken else None
        )
        assert variant.choose() == expected
    monkeypatch.setattr(variant, "trouble", lambda name: f"{name} is broken")
    with pytest.raises(MissingDependencyError, match="cuda_ad_rgb is broken; llvm_ad_rgb is broken"):
        variant.choose()
    with pytest.raises(MissingDependencyError, match="does not run on this machine: llvm_ad_mono is broken"):
        variant.choose("llvm_ad_mono")
    with pytest.raises(ParameterError, match="Known"):
        variant.choose("scalar_rgb")
