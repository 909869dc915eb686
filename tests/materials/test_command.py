import io

import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

from nephrite import materials
from nephrite.cli.materials import _list, materials_command
from nephrite.errors import ParameterError

app = typer.Typer()
app.command("materials")(materials_command)


def run(*arguments):
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False)


def test_the_list_has_every_material_under_its_kind_and_source():
    result = run()
    assert result.exit_code == 0
    heading, found = ["", ""], {}
    for line in result.output.splitlines():
        if line.split()[:1] in (["artistic:"], ["measured:"]):
            heading = [line.split()[0], ""]
        elif not heading[1]:
            heading[1] = line.split("  ")[0].strip()
        elif line.strip():
            found[line.split()[0]] = (" ".join(heading), line)
    for material in materials.all_materials():
        assert found[material.name][0] == f"{material.kind}: {material.source}"
    assert "0.81" in found["skim-milk"][1]
    assert "10.4" in found["skim-milk"][1]


def test_the_list_fits_a_narrow_terminal():
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(_list(list(materials.all_materials()), console.width))
    lines = console.export_text().splitlines()
    assert not any("…" in line for line in lines)
    assert [line for line in lines if line.startswith("pacific-ocean-surface-water") and "19.1" in line]


def test_only_one_kind():
    output = run("--kind", "artistic").output
    assert "jade" in output
    assert "ketchup" not in output


def test_one_in_full():
    output = run("skim milk").output
    expected = ("skim-milk", "measured", "Jensen et al. 2001", "1/mm", "0.0142", "0.682", "through 5 mm", "#")
    assert [text for text in expected if text not in output] == []
    assert "chosen for Nephrite" in run("jade").output


def test_every_sheet_can_be_shown():
    for name in materials.names():
        assert run(name).exit_code == 0


def test_swatches_are_coloured(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLORTERM", "truecolor")
    monkeypatch.setenv("TERM", "xterm-256color")
    output = run("skim-milk").output
    # the diffuse reflectance .815 .813 .682, encoded for the screen
    assert "\x1b[48;2;233;233;215m" in output


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / f"{'-'.join(['teas'] * 20)}.toml"
    path.write_text('[green-tea]\nunit = "1/cm"\nsigma_a = 1\nsigma_s = 20\nemission = 3\n')
    assert "green-tea" in run("--file", str(path)).output
    assert "jade" not in run("--file", str(path)).output
    output = run("--file", str(path), "Green Tea").output
    unfolded = "".join(line.strip("│ ") for line in output.splitlines())
    assert str(path) in unfolded  # however long
    assert "emission" in output
    with pytest.raises(ParameterError, match="green-tea"):
        run("--file", str(path), "green-tee")
    with pytest.raises(ParameterError, match="leave out --kind"):
        run("--file", str(path), "--kind", "measured")


def test_an_unknown_name_is_an_error():
    with pytest.raises(ParameterError, match="Did you mean 'marble'"):
        run("marbel")
