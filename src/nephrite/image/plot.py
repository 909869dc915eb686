"""Plots: profiles against the truth, on logarithmic axes, with a panel of relative errors below."""

from __future__ import annotations

import io
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
_INK, _SOFT, _GRID = "#22242a", "#6d717a", "#e3e4e8"
_WIDEST_ERROR = 50.0  # percent: the end of the lower panels
_NOISIEST = 0.25  # relative standard error beyond which the truth says nothing about a ring
_FONTS = {
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
        figure = Figure(figsize=(4.35 * len(panels) + 0.75 if len(panels) > 1 else 6.6, 6.9), dpi=DPI)
        left, right = 0.72 / figure.get_figwidth(), 1.0 - 0.22 / figure.get_figwidth()
        grid = figure.add_gridspec(
            2, len(panels), height_ratios=(2.5, 1.0), hspace=0.06, wspace=0.06,
            left=left, right=right, bottom=0.082, top=0.845,
        )  # fmt: skip
        figure.text(left, 0.955, title, size=14, weight="bold", color=_INK, va="center")
        figure.text(left, 0.918, subtitle, size=9, color=_SOFT, va="center")
        span = min(panel.span[0] for panel in panels), max(panel.span[1] for panel in panels)
        limits = _limits(panels, span)
        first = None
        for i, panel in enumerate(panels):
            upper = figure.add_subplot(grid[0, i], sharey=first)
            lower = figure.add_subplot(grid[1, i], sharex=upper)
            first = first or upper
            _draw_values(upper, panel, span, limits)
            _draw_errors(lower, panel)
            for axes in (upper, lower):
                axes.tick_params(labelleft=i == 0)
            upper.tick_params(labelbottom=False)
            lower.set_xlabel("distance r  [mm]")
            if i == 0:
                upper.set_ylabel("radiant exitance R(r)  [1/mm²]")
                lower.set_ylabel("error  [%]")
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
    """Return the least and the greatest R to be shown: the truth's, with room for the table below."""
    values = np.concatenate([p.truth[_shown(p) & (p.radius >= span[0])] for p in panels])
    return float(values.min()) / 4.0, float(values.max()) * 4.0


def _shown(panel: Panel) -> NDArray[np.bool_]:
    """Return the rings about which the truth says something, up to the end of the panel's own span."""
    return (panel.error < _NOISIEST * panel.truth) & (panel.radius <= panel.span[1])


def _draw_values(axes: Any, panel: Panel, span: tuple[float, float], limits: tuple[float, float]) -> None:
    """Draw R(r): lines for models, dots with error bars for the truth, and the table of errors."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(*span)
    axes.set_ylim(*limits)
    _tidy(axes)
    axes.set_title(panel.heading, loc="left", size=11, weight="bold", color=_INK, pad=6)
    axes.set_title(panel.note, loc="right", size=8, color=_SOFT, pad=6)
    _mark(axes, panel)
    for line, (color, dashes) in zip(panel.lines, _STYLES, strict=False):
        drawn = (line.values > 0.0) & (panel.radius <= panel.span[1])
        axes.plot(panel.radius[drawn], line.values[drawn], color=color, ls=dashes, lw=1.6, zorder=3)
    at = _shown(panel)
    axes.errorbar(
        panel.radius[at], panel.truth[at], panel.error[at],
        fmt="o", ms=2.6, color=_INK, elinewidth=0.8, zorder=4,
    )  # fmt: skip
    _table(axes, panel)


def _mark(axes: Any, panel: Panel) -> None:
    """Show a length by a thin vertical line, above the table, with its label."""
    length, label = panel.mark
    axes.axvline(length, ymin=0.5, color=_SOFT, lw=0.8, ls=(0, (2, 2)), zorder=1)
    low, high = axes.get_xlim()
    place = np.log(length / low) / np.log(high / low)
    if not 0.0 < place < 1.0:
        return
    side, offset = ("right", -0.012) if place > 0.7 else ("left", 0.012)
    axes.text(
        place + offset, 0.975, label, transform=axes.transAxes, size=7.5, color=_SOFT, ha=side, va="top"
    )


def _table(axes: Any, panel: Panel) -> None:
    """Put the legend into the empty corner: one row for each model, with its errors."""
    step, left = 0.052, 0.035
    rows = len(panel.lines) + 1
    style: dict[str, Any] = {"transform": axes.transAxes, "va": "center", "size": 8}
    top = 0.045 + step * rows
    axes.text(left + 0.44, top, "total", ha="right", color=_SOFT, **style)
    axes.text(left + 0.585, top, "profile", ha="right", color=_SOFT, **style)
    axes.text(left + 0.07, top, "error of", color=_SOFT, **style)
    for i, (line, (color, dashes)) in enumerate(zip(panel.lines, _STYLES, strict=False)):
        y = top - step * (i + 1)
        axes.plot([left, left + 0.05], [y, y], color=color, ls=dashes, lw=2.0, transform=axes.transAxes)
        axes.text(left + 0.07, y, line.label, color=_INK, **style)
        axes.text(left + 0.44, y, line.total, ha="right", color=_INK, **style)
        axes.text(left + 0.585, y, line.profile, ha="right", color=_INK, **style)


def _draw_errors(axes: Any, panel: Panel) -> None:
    """Draw relative errors in percent, and the truth's standard error as a band around 0."""
    axes.set_ylim(-_WIDEST_ERROR, _WIDEST_ERROR)
    axes.set_yticks([-50, -25, 0, 25, 50], ["−50", "−25", "0", "+25", "+50"])
    _tidy(axes)
    at = _shown(panel)
    radius, truth = panel.radius[at], panel.truth[at]
    band = 100.0 * panel.error[at] / truth
    axes.fill_between(radius, -band, band, color="#c9cbd1", lw=0, zorder=1)
    axes.axhline(0.0, color=_INK, lw=0.8, zorder=2)
    axes.axvline(panel.mark[0], color=_SOFT, lw=0.7, ls=(0, (2, 2)), zorder=1)
    for line, (color, dashes) in zip(panel.lines, _STYLES, strict=False):
        axes.plot(radius, 100.0 * (line.values[at] / truth - 1.0), color=color, ls=dashes, lw=1.6, zorder=3)


def _tidy(axes: Any) -> None:
    """Leave two thin axes, ticks that do not shout, and a light grid."""
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(_SOFT)
    axes.tick_params(which="both", color=_SOFT, labelcolor=_INK, labelsize=8.5)
    axes.grid(True, color=_GRID, lw=0.7, zorder=0)
    axes.set_axisbelow(True)
    if axes.get_xscale() == "log":
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
