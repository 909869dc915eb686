"""`nephrite render`: what is written, what is refused, and what survives an interruption."""

from __future__ import annotations

import re
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from nephrite import __version__
from nephrite.cli.app import app
from nephrite.image import write
from nephrite.rendering import progressive

TINY = ["--resolution", "24x18", "--spp", "2", "--variant", "llvm_ad_rgb"]
FOGGY_BALL = """<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="12"/>
    <integer name="height" value="10"/></film></sensor>
  <shape type="sphere"><transform name="to_world"><translate z="4"/></transform>
    {inside}</shape>
  <emitter type="constant"/>
</scene>"""
FOG = '<bsdf type="dielectric"/><medium name="interior" type="homogeneous"/>'


def nephrite(*words: str | Path):
    return CliRunner().invoke(app, [str(word) for word in words])


def said(result) -> str:
    """All that a command printed, with the line breaks of the terminal taken out."""
    return " ".join(result.output.replace("│", " ").split())


@pytest.fixture
def never_rendered(monkeypatch):
    def render(*args, **kwargs):
        pytest.fail("rendering started")

    monkeypatch.setattr(progressive, "render", render)


def test_png_and_exr_tell_how_they_were_made(tmp_path):
    png, exr = tmp_path / "ball.png", tmp_path / "ball.exr"
    result = nephrite(
        "render", "sphere", "-m", "Marble", "--size", "2cm", "--seed", "5", *TINY, "-o", png, "-o", exr
    )
    assert result.exit_code == 0, result.output
    for path in (png, exr):
        assert str(path) in result.output.replace("\n", "")
        notes = write.read_metadata(path)
        expected = {
            "source": "sphere", "material": "marble", "size": "20mm", "light": "studio", "model": "walk",
            "terms": "all", "exit": "lobe", "alpha": "0.0", "seed": "5", "spp": "2", "samples": "2",
            "resolution": "24x18", "variant": "llvm_ad_rgb", "version": __version__,
        }  # fmt: skip
        assert {name: notes.get(name) for name in expected} == expected
    assert write.read_metadata(png)["denoised"] == "yes"
    assert write.read_metadata(exr)["denoised"] == "no"


@pytest.mark.parametrize(("flag", "expected"), [("--denoise", "yes"), ("--no-denoise", "no")])
def test_denoising_can_be_asked_for_or_not(tmp_path, flag, expected):
    paths = tmp_path / "a.png", tmp_path / "a.exr"
    result = nephrite("render", "sphere", *TINY, flag, "-o", paths[0], "-o", paths[1])
    assert result.exit_code == 0, result.output
    assert [write.read_metadata(path)["denoised"] for path in paths] == [expected] * 2


def test_the_seed_decides_the_noise(tmp_path):
    import mitsuba as mi

    pictures = []
    for number, seed in enumerate(("1", "1", "2")):
        path = tmp_path / f"{number}.exr"
        assert nephrite("render", "cube", *TINY, "--seed", seed, "-o", path).exit_code == 0
        pictures.append(np.array(mi.Bitmap(str(path))))
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert np.any(pictures[0] != pictures[2])


def test_a_time_ends_a_render(tmp_path):
    path = tmp_path / "a.exr"
    result = nephrite("render", "sphere", *TINY[:2], "--time", "1s", "-o", path)
    assert result.exit_code == 0, result.output
    assert write.read_metadata(path)["stopped_by"] == "time"


def test_a_material_of_ones_own_is_used(tmp_path):
    table, path = tmp_path / "mine.toml", tmp_path / "a.png"
    table.write_text('[my-test-wax]\nunit = "1/mm"\nsigma_a = 0.01\nsigma_s = [1, 2, 3]\n')
    result = nephrite("render", "sphere", "--material-file", table, *TINY, "-o", path)
    assert result.exit_code == 0, result.output
    assert write.read_metadata(path)["material"] == "my-test-wax"


def test_auto_tells_what_it_chose_and_why(tmp_path):
    result = nephrite("render", "sphere", "--model", "auto", *TINY, "-o", tmp_path / "a.exr")
    assert result.exit_code == 0, result.output
    assert re.search(r"^jade: \w+, \w+", result.output, re.MULTILINE)


def test_a_scene_file_is_rendered_by_our_integrator_in_its_own_light(tmp_path):
    scene, path = tmp_path / "fog.xml", tmp_path / "a.exr"
    scene.write_text(FOGGY_BALL.format(inside=FOG))
    result = nephrite("render", scene, "--spp", "2", "--terms", "single", "--exit", "exact", "-o", path)
    assert result.exit_code == 0, result.output
    notes = write.read_metadata(path)
    assert (notes["model"], notes["terms"], notes["exit"]) == ("walk", "single", "exact")
    assert "material" not in notes
    assert "light" not in notes


def test_a_scene_without_anything_translucent_is_refused(tmp_path, never_rendered):
    scene = tmp_path / "solid.xml"
    scene.write_text(FOGGY_BALL.format(inside='<bsdf type="diffuse"/>'))
    result = nephrite("render", scene, "-o", tmp_path / "a.png")
    assert result.exit_code == 1
    assert "no translucent object" in said(result)


@pytest.mark.slow
def test_a_measured_profile_and_a_thickness_are_used_and_told(tmp_path):
    file, path = tmp_path / "skin.csv", tmp_path / "a.exr"
    file.write_text("0 .1\n1 .03\n4 0\n")
    result = nephrite("render", "slab", "--model", "measured", "--profile", file, *TINY, "-o", path)
    assert result.exit_code == 0, result.output
    assert (write.read_metadata(path)["model"], write.read_metadata(path)["profile"]) == (
        "measured",
        str(file),
    )
    result = nephrite("render", "slab", "--model", "multipole", "--thickness", "5mm", *TINY, "-o", path)
    assert result.exit_code == 0, result.output
    assert (write.read_metadata(path)["model"], write.read_metadata(path)["thickness"]) == (
        "multipole",
        "5mm",
    )


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["sphere", "--model", "measured"], 1, "needs a profile"),
        (["sphere", "--model", "measured", "--profile", "none.csv"], 1, "cannot read the profile none.csv"),
        (["sphere", "--profile", "a.csv"], 1, "belongs to the model measured"),
        (["sphere", "--thickness", "5mm"], 1, "belongs to the model multipole"),
        (["sphere", "--model", "multipole", "--thickness", "5"], 2, "'5' has no unit"),
        (["sphere", "--size", "100"], 2, "'100' has no unit"),
        (["sphere", "--time", "30"], 2, "'30' has no unit"),
        (["sphere", "--noise", "1"], 2, "no percent sign"),
        (["sphere", "--resolution", "big"], 2, "like 800x600"),
        (["sphere", "--spp", "0"], 2, "--spp"),
        (["sphere", "--alpha", "2"], 2, "--alpha"),
        (["sphere", "--model", "wlak"], 2, "Did you mean 'walk'"),
        (["sphere", "--terms", "singel"], 2, "Did you mean 'single'"),
        (["sphere", "--exit", "exakt"], 2, "Did you mean 'exact'"),
        (["sphere", "--light", "studoi"], 2, "Did you mean 'studio'"),
        (["sphere", "--sise", "1mm"], 2, "--sise"),
        (["sphere", "--material", "jad"], 1, "Did you mean 'jade'"),
        (["sphere", "--variant", "llvm_rgb"], 1, "Did you mean 'llvm_ad_rgb'"),
        (["sphere", "--material-file", "missing.toml"], 1, "no such file"),
        (["shpere"], 1, "Did you mean 'sphere'"),
        (["missing.ply"], 1, "no mesh missing.ply"),
        (["missing.xml"], 1, "no scene file"),
        (["missing.xml", "--material", "jade"], 1, "can't be combined"),
        (["sphere", "-o", "picture.jpg"], 1, "must end in"),
        (["sphere", "-o", "no/such/folder/a.png"], 1, "not a folder"),
    ],
)
def test_bad_input_is_refused_before_rendering(tmp_path, monkeypatch, never_rendered, words, code, says):
    monkeypatch.chdir(tmp_path)
    result = nephrite("render", *words)
    assert result.exit_code == code
    assert says in said(result)
    assert "Traceback" not in result.output
    assert not list(tmp_path.glob("*.png"))


def test_a_failure_leaves_the_picture_of_before(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"before")

    def render(*args, **kwargs):
        raise RuntimeError("the device fell off")

    monkeypatch.setattr(progressive, "render", render)
    result = nephrite("render", "sphere", *TINY, "-o", path)
    assert result.exit_code == 1
    assert "the device fell off" in said(result)
    assert "--debug" in said(result)
    assert path.read_bytes() == b"before"


def test_ctrl_c_keeps_the_picture_so_far(tmp_path, monkeypatch):
    real = progressive.render

    def render(*args, on_progress, **kwargs):
        def interrupt(progress):
            signal.raise_signal(signal.SIGINT)

        return real(*args, on_progress=interrupt, **kwargs)

    monkeypatch.setattr(progressive, "render", render)
    path = tmp_path / "a.exr"
    result = nephrite("render", "sphere", *TINY[:2], "--spp", "4096", "-o", path)
    assert result.exit_code == 130
    assert "the picture so far" in said(result)
    notes = write.read_metadata(path)
    assert notes["stopped_by"] == "interrupted"
    assert 0 < int(notes["samples"]) < 4096


def test_ctrl_c_before_there_is_a_picture_writes_nothing(tmp_path, monkeypatch):
    def render(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(progressive, "render", render)
    path = tmp_path / "a.png"
    result = nephrite("render", "sphere", *TINY, "-o", path)
    assert result.exit_code == 130
    assert "nothing was written" in said(result)
    assert not path.exists()


def test_notes_of_the_renderer_are_passed_on(tmp_path, monkeypatch):
    real = progressive.render
    monkeypatch.setattr(
        progressive,
        "render",
        lambda *args, **kwargs: replace(real(*args, **kwargs), notes=("3 values were NaN",)),
    )
    result = nephrite("render", "sphere", *TINY, "-o", tmp_path / "a.exr")
    assert "3 values were NaN" in said(result)
