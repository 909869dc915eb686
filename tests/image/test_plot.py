"""Plots: what is in them, that files are whole, and that bad input is refused."""

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.image import plot, write

RADIUS = np.geomspace(0.01, 10, 31)


def panel(lines=2, heading="red", note="leaves"):
    truth = np.exp(-RADIUS) / RADIUS
    models = [plot.Line(f"model {i}", truth * (1 + 0.1 * i), "+1.0 %", "2.0 %") for i in range(lines)]
    return plot.Panel(
        heading, note, RADIUS, truth, 0.02 * truth, models, (1.0, "mean free path"), (0.02, 8.0)
    )


def test_each_panel_is_a_column_with_values_above_errors():
    figure = plot.profiles([panel(), panel(heading="green")], "Jade", "simulated")
    assert len(figure.axes) == 6
    values, errors, table = figure.axes[:3]
    assert values.get_xscale() == values.get_yscale() == "log"
    assert values.get_title(loc="left") == "red"
    drawn = [line for line in errors.lines if len(line.get_xdata()) > 10]
    np.testing.assert_allclose(drawn[0].get_ydata(), 0, atol=1e-9)
    np.testing.assert_allclose(drawn[1].get_ydata(), 10)
    assert max(drawn[1].get_xdata()) <= 8.0  # the panel's span
    assert [text.get_text() for text in values.texts] == ["mean free path"]
    assert {"model 0", "model 1", "+1.0 %", "2.0 %"} <= {text.get_text() for text in table.texts}


def test_rings_that_are_mostly_noise_are_left_out():
    noisy = panel()
    noisy.error[:10] = noisy.truth[:10]
    errors = plot.profiles([noisy], "", "").axes[1]
    drawn = next(line for line in errors.lines if len(line.get_xdata()) > 10)
    assert drawn.get_xdata()[0] == RADIUS[10]


def test_all_panels_share_their_axes():
    other = panel()
    figure = plot.profiles([panel(), plot.Panel(**{**vars(other), "span": (0.1, 3.0)})], "", "")
    limits = {(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes[::3]}
    assert len(limits) == 1
    assert limits.pop()[0] == (0.02, 8.0)


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_files_are_whole_and_tell_how_they_were_made(tmp_path, suffix):
    path = tmp_path / f"plot{suffix}"
    for _ in range(2):
        assert plot.save(path, plot.profiles([panel()], "Jade", ""), {"material": "jade"}) == path
    if suffix == ".png":
        assert write.read_metadata(path)["material"] == "jade"
    else:
        text = path.read_text()
        assert text.rstrip().endswith("</svg>")
        assert "material: jade" in text
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_svg_files_are_the_same_each_time(tmp_path):
    contents = []
    for name in ("a.svg", "b.svg"):
        plot.save(tmp_path / name, plot.profiles([panel()], "Jade", ""), {})
        contents.append((tmp_path / name).read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.parametrize("panels", [[], [panel(lines=plot.MOST_LINES + 1)]])
def test_nothing_and_too_much_are_refused(panels):
    with pytest.raises(ParameterError, match="at least one panel"):
        plot.profiles(panels, "", "")


def test_the_drawing_library_is_loaded_only_for_drawing():
    import subprocess
    import sys

    code = "import nephrite.image.plot, sys; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
