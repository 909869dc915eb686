"""The page's figures: error over time for every method, and the pictures with maps of their errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.analysis import GOAL, Truth
from benchmarks.methods import Method
from nephrite.atlas.compared import Difference, Estimate, block_map
from nephrite.image import figure, plot, write

COLOURS = {
    "volpath": "#9a9ea6", "volpathmis": "#55585f", "luxcore": "#b07aa1", "cycles": "#d55e00", "cycles-plain": "#e69f00",
    "burley": "#c9a227", "walk-exact": "#08306b", "walk": "#0072b2", "transport": "#009e73", "tabulated": "#56b4e9",
    "dipole": "#7fcdbb", "brdf": "#bdbdbd",
}  # fmt: skip
_MOST = 1e3  # end of the axis of relMSE
_INK, _SOFT, _GRID = "#22242a", "#6d717a", "#e3e4e8"
_WIDTH = 192  # of a picture on a sheet
_COLUMNS = 6
_LIMIT = 0.5  # of the maps
_BRIGHT = 0.8  # where the 99th percentile of the truth is shown


def over_time(
    path: Path, panels: Mapping[str, Mapping[str, Sequence[Mapping[str, float]]]], methods: Sequence[Method]
) -> Path:
    """Plot relMSE over seconds, a panel for each scene; `panels` has curves by scene's title and method's name."""
    from matplotlib.figure import Figure

    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    sheet = Figure(figsize=(4.6 * columns + 0.4, 3.4 * rows + 1.0), dpi=plot.DPI)
    axes = sheet.subplots(rows, columns, squeeze=False, sharey=True)
    for spot in axes.flat[len(panels) :]:
        spot.remove()
    shown: dict[str, Any] = {}
    for spot, (title, curves) in zip(axes.flat, panels.items(), strict=False):
        for method in methods:
            curve = curves.get(method.name)
            if curve is None:
                continue
            line = spot.plot(
                [point["seconds"] for point in curve],
                [point["relmse"] for point in curve],
                color=COLOURS.get(method.name.removesuffix("-gpu"), _INK),
                linestyle="--" if method.name.endswith("-gpu") else "-",
                marker="o", markersize=2.5, linewidth=1.5,
            )  # fmt: skip
            shown[method.title] = line[0]
        limit(spot, GOAL)
        logarithmic(spot, title, "seconds for a picture")
    axes[0, 0].set_ylim(GOAL / 20, min(axes[0, 0].get_ylim()[1], _MOST))
    for row in axes:
        row[0].set_ylabel("relMSE")
    sheet.legend(
        shown.values(), shown.keys(), loc="lower center", ncols=2 * columns, fontsize=7.5, frameon=False
    )
    sheet.tight_layout(rect=(0.0, 1.3 / columns / (3.4 * rows + 1.0), 1.0, 1.0))
    return plot.save(path, sheet, {"shows": "relMSE over time"})


def logarithmic(spot: Any, title: str, xlabel: str) -> None:
    """Give a panel logarithmic axes, a title, and lines that do not shout."""
    spot.set(xscale="log", yscale="log", xlabel=xlabel)
    for axis in (spot.xaxis, spot.yaxis):
        axis.set_minor_formatter("")
    spot.set_title(title, fontsize=10, loc="left", color=_INK)
    spot.grid(True, color=_GRID, linewidth=0.7)
    spot.tick_params(which="both", color=_SOFT, labelsize=8)
    for side in ("top", "right"):
        spot.spines[side].set_visible(False)


def limit(spot: Any, value: float) -> None:
    """Draw a dotted line at a value that is to be reached or kept."""
    spot.axhline(value, color=_SOFT, linewidth=0.8, linestyle=(0, (2, 2)))


def pictures(
    path: Path, title: str, truth: Truth, means: Mapping[str, Estimate],
    errors: Mapping[str, Difference], methods: Sequence[Method],
) -> Path:  # fmt: skip
    """Lay out the reference and each method's mean picture, before maps of their errors in blocks of 4 x 4 pixels."""
    reference, mask = truth.estimate, truth.mask
    exposure = float(np.log2(_BRIGHT / max(float(np.percentile(reference.mean[mask], 99)), 1e-6)))
    shown = [method for method in methods if method.name in means]
    noisy = Estimate(reference.mean + reference.noise_of_blocks(4), reference.error)
    images: list[Any] = [reference.mean.astype(np.float32)]
    images += [means[method.name].mean.astype(np.float32) for method in shown]
    images.append(figure.heat_map(block_map(noisy, reference, mask), _LIMIT))
    images += [figure.heat_map(block_map(means[m.name], reference, mask), _LIMIT) for m in shown]
    titles = [method.title for method in shown]
    labels = ["reference", *titles, "noise of the reference", *titles]
    means_of = [f"mean {100 * errors[method.name].bias:+.1f} %" for method in shown]
    worst = [f"worst block {100 * errors[method.name].worst:+.0f} %" for method in shown]
    sheet = figure.side_by_side(
        images, labels, title, ["exact walk", *means_of, "standard error", *worst],
        columns=min(1 + len(shown), _COLUMNS), width=_WIDTH, exposure=exposure,
    )  # fmt: skip
    return write.save(path, sheet, {"shows": title})
