"""Plots: profiles against the truth, on logarithmic axes, with a panel of relative errors below."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.errors import ParameterError
from nephrite.image import write

__all__ = ["MOST_LINES", "SUFFIXES", "Line", "Panel", "profiles", "save"]

SUFFIXES = (".png", ".svg")
DPI = 160

_STYLES = (
    ("#0072B2", "-"),
    ("#D55E00", "-"),
    ("#009E73", "-"),
    ("#CC79A7", "-"),
    ("#E69F00", (0, (4, 1.5))),
    ("#56B4E9", (0, (4, 1.5))),
    ("#8C564B", (0, (1.5, 1))),
    ("#5D3A9B", (0, (1.5, 1))),
)
"""Colours that remain distinct for colour-blind eyes (Okabe and Ito 2008); dashes show lines that cover each other."""

MOST_LINES = len(_STYLES)
_EDGE, _COLUMN, _ALONE, _ROW = (
    0.75,
    4.35,
    6.4,
    0.19,
)  # inches: left margin, panels, a single one, row of the table
_LETTERS = 14  # of the subtitle, in an inch
_INK, _SOFT, _GRID = "#22242a", "#6d717a", "#e3e4e8"
_WIDEST_ERROR = 50.0  # percent: the end of the lower panels
_NOISIEST = 0.25  # relative standard error beyond which the truth says nothing about a ring
_FONTS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "nephrite",
}


@dataclass(frozen=True)
class Line:
    """A model's curve: `values` (K,) of R at the panel's radii, and two short texts, its errors, for the table."""

    label: str
    values: NDArray[np.float64]
    total: str
    profile: str


@dataclass(frozen=True)
class Panel:
    """One colour channel: a column of the figure.

    `radius`, `truth`, `error`: (K,), in mm and 1/mm^2, the latter a standard error. `mark`: a length to be shown, with
    its label; `span`: first and last radius worth showing. `note`: in small print beside the heading.
    """

    heading: str
    note: str
    radius: NDArray[np.float64]
    truth: NDArray[np.float64]
    error: NDArray[np.float64]
    lines: Sequence[Line]
    mark: tuple[float, str]
    span: tuple[float, float]


def profiles(panels: Sequence[Panel], title: str, subtitle: str) -> Any:
    """Draw one column for each panel; all have the same axes. Returns a matplotlib `Figure`.

    Raises `ParameterError` for no panel or more than `MOST_LINES` lines.
    """
    if not panels or max(len(panel.lines) for panel in panels) > MOST_LINES:
        raise ParameterError(f"a plot has at least one panel and at most {MOST_LINES} lines in each.")
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_FONTS):
        rows = 1 + max(len(panel.lines) for panel in panels)
        width = _EDGE + _COLUMN * len(panels) if len(panels) > 1 else _ALONE
        below = textwrap.wrap(subtitle, round(_LETTERS * (width - _EDGE)))
        head = 0.88 + 0.16 * len(below)
        height = 5.95 + head + _ROW * rows
        figure = Figure(figsize=(width, height), dpi=DPI)
        left = _EDGE / width
        grid = figure.add_gridspec(
            3, len(panels), height_ratios=(3.9, 1.55, _ROW * rows + 0.75), hspace=0.05, wspace=0.06,
            left=left, right=1.0 - 0.2 / width, bottom=0.15 / height, top=1.0 - head / height,
        )  # fmt: skip
        figure.text(left, 1.0 - 0.34 / height, title, size=14, weight="bold", color=_INK, va="center")
        figure.text(left, 1.0 - 0.54 / height, "\n".join(below), size=9, color=_SOFT, va="top")
        span = min(panel.span[0] for panel in panels), max(panel.span[1] for panel in panels)
        limits = _limits(panels, span)
        for i, panel in enumerate(panels):
            values, errors = figure.add_subplot(grid[0, i]), figure.add_subplot(grid[1, i])
            _draw_values(values, panel, limits)
            _draw_errors(errors, panel)
            for axes in (values, errors):
                axes.set_xscale("log")
                axes.set_xlim(*span)
                axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
                _tidy(axes, labelled=i == 0)
                _mark(axes, panel, labelled=axes is values)
            values.tick_params(labelbottom=False)
            errors.set_xlabel("distance r  [mm]")
            if i == 0:
                values.set_ylabel("radiant exitance R(r)  [1/mm²]")
                errors.set_ylabel("error  [%]")
                figure.align_ylabels([values, errors])
            _draw_table(figure.add_subplot(grid[2, i]), panel, rows)
    return figure


def save(path: str | Path, figure: Any, notes: Mapping[str, str]) -> Path:
    """Write a figure as PNG (with `notes`, see `write.save`) or SVG, by the suffix; returns the file's path."""
    import matplotlib

    with matplotlib.rc_context(_FONTS):
        if Path(path).suffix.lower() == ".svg":
            stream = io.BytesIO()
            figure.savefig(stream, format="svg", metadata={"Date": None, "Description": _listed(notes)})
            return write.save_bytes(path, stream.getvalue())
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return write.save(path, np.asarray(canvas.buffer_rgba())[..., :3].copy(), notes)


def _listed(notes: Mapping[str, str]) -> str:
    return "; ".join(f"{key}: {value}" for key, value in notes.items())


def _limits(panels: Sequence[Panel], span: tuple[float, float]) -> tuple[float, float]:
    """Return the least and the greatest R to be shown: a little more than the truth's."""
    values = np.concatenate([p.truth[_shown(p) & (p.radius >= span[0])] for p in panels])
    return float(values.min()) / 2.0, float(values.max()) * 4.0


def _shown(panel: Panel) -> NDArray[np.bool_]:
    """Return the rings about which the truth says something, up to the end of the panel's own span."""
    return (panel.error < _NOISIEST * panel.truth) & (panel.radius <= panel.span[1])


def _draw_values(axes: Any, panel: Panel, limits: tuple[float, float]) -> None:
    """Draw R(r): lines for models, dots with error bars for the truth."""
    axes.set_yscale("log")
    axes.set_ylim(*limits)
    axes.set_title(panel.heading, loc="left", size=11, weight="bold", color=_INK, pad=6)
    axes.set_title(panel.note, loc="right", size=8, color=_SOFT, pad=6)
    for line, (color, dashes) in zip(panel.lines, _STYLES, strict=False):
        drawn = (line.values > 0.0) & (panel.radius <= panel.span[1])
        axes.plot(panel.radius[drawn], line.values[drawn], color=color, ls=dashes, lw=1.6, zorder=3)
    at = _shown(panel)
    axes.errorbar(
        panel.radius[at], panel.truth[at], panel.error[at],
        fmt="o", ms=2.6, color=_INK, elinewidth=0.8, zorder=4,
    )  # fmt: skip


def _draw_errors(axes: Any, panel: Panel) -> None:
    """Draw relative errors in percent, and the truth's standard error as a band around 0."""
    axes.set_ylim(-_WIDEST_ERROR, _WIDEST_ERROR)
    axes.set_yticks([-50, -25, 0, 25, 50], ["−50", "−25", "0", "+25", "+50"])
    at = _shown(panel)
    radius, truth = panel.radius[at], panel.truth[at]
    band = 100.0 * panel.error[at] / truth
    axes.fill_between(radius, -band, band, color="#c9cbd1", lw=0, zorder=1)
    axes.axhline(0.0, color=_INK, lw=0.8, zorder=2)
    for line, (color, dashes) in zip(panel.lines, _STYLES, strict=False):
        axes.plot(radius, 100.0 * (line.values[at] / truth - 1.0), color=color, ls=dashes, lw=1.6, zorder=3)


def _draw_table(axes: Any, panel: Panel, rows: int) -> None:
    """Write the legend: a row for each model, with its errors."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-(_ROW * rows), 0.75)  # in inches, below the label of the axis above
    total, profile = 0.62, 0.86
    axes.text(0.09, 0.0, "error of", size=8, color=_SOFT, va="center")
    axes.text(total, 0.0, "the total", size=8, color=_SOFT, va="center", ha="right")
    axes.text(profile, 0.0, "the profile", size=8, color=_SOFT, va="center", ha="right")
    for i, (line, (color, dashes)) in enumerate(zip(panel.lines, _STYLES, strict=False)):
        y = -_ROW * (i + 1)
        axes.plot([0.0, 0.065], [y, y], color=color, ls=dashes, lw=2.0, clip_on=False)
        axes.text(0.09, y, line.label, size=8.5, color=_INK, va="center")
        axes.text(total, y, line.total, size=8.5, color=_INK, va="center", ha="right")
        axes.text(profile, y, line.profile, size=8.5, color=_INK, va="center", ha="right")


def _mark(axes: Any, panel: Panel, labelled: bool) -> None:
    """Show a length by a thin vertical line, with its label."""
    length, label = panel.mark
    axes.axvline(length, color=_SOFT, lw=0.8, ls=(0, (2, 2)), zorder=1)
    low, high = axes.get_xlim()
    place = np.log(length / low) / np.log(high / low)
    if labelled and 0.0 < place < 1.0:
        side, offset = ("right", -0.012) if place > 0.7 else ("left", 0.012)
        axes.text(
            place + offset, 0.975, label, transform=axes.transAxes, size=8, color=_SOFT, ha=side, va="top"
        )


def _tidy(axes: Any, labelled: bool) -> None:
    """Leave two thin axes, ticks that do not shout, and a light grid."""
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(_SOFT)
    axes.tick_params(which="both", color=_SOFT, labelcolor=_INK, labelsize=8.5)
    axes.tick_params(axis="y", labelleft=labelled)
    axes.grid(True, color=_GRID, lw=0.7, zorder=0)
    axes.set_axisbelow(True)
