"""The plots of growth: panels with logarithmic axes, a line for each method, a dotted line where a limit was asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks import curves
from nephrite.image import plot

_MARGIN = 1.15
_DECADES = 1000.0  # where an axis goes so far, it has room for powers of ten alone


@dataclass(frozen=True)
class Panel:
    """`lines`: by a method's name, what is measured at each place of the axis; `ticks`: these places, in words.

    `most`: the limit, None without one.
    """

    title: str
    axis: str
    lines: Mapping[str, Sequence[tuple[float, float]]]
    ticks: Mapping[float, str]
    most: float | None = None


def panels(path: Path, shown: Sequence[Panel], titles: Mapping[str, str]) -> Path:
    """Draw panels side by side as SVG, but for empty ones, with one legend of the methods' `titles` below."""
    from matplotlib.figure import Figure

    shown = [panel for panel in shown if any(y > 0.0 for line in panel.lines.values() for _, y in line)]
    sheet = Figure(figsize=(4.6 * len(shown) + 0.4, 4.0))
    legend: dict[str, Any] = {}
    for spot, panel in zip(sheet.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
        curves.logarithmic(spot, panel.title, panel.axis)
        spot.set_xlim(min(panel.ticks) / _MARGIN, max(panel.ticks) * _MARGIN)
        for name, line in panel.lines.items():
            points = [(x, y) for x, y in line if y > 0.0]
            if points:
                legend[titles[name]] = spot.plot(
                    *zip(*points, strict=True), color=curves.COLOURS[name], marker="o", markersize=4, linewidth=1.5,
                )[0]  # fmt: skip
        if panel.most is not None:
            curves.limit(spot, panel.most)
        _number(spot, panel)
    sheet.legend(
        legend.values(), legend.keys(), loc="lower center", ncols=len(legend) or 1, fontsize=8, frameon=False
    )
    sheet.tight_layout(rect=(0.0, 0.08, 1.0, 1.0))
    return plot.save(path, sheet, {"shows": "; ".join(panel.title for panel in shown)})


def _number(spot: Any, panel: Panel) -> None:
    """Write plain numbers, not powers of ten: the places that were measured at, and on the other axis what has room."""
    from matplotlib.ticker import LogLocator

    low, high = spot.get_ylim()
    spot.set_ylim(low / 1.1, high * 1.1)
    spot.yaxis.set_major_locator(LogLocator(subs=(1.0,) if high > _DECADES * low else (1.0, 2.0, 5.0)))
    spot.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    spot.set_xticks(list(panel.ticks), list(panel.ticks.values()))
    spot.xaxis.minorticks_off()
