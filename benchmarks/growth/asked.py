"""What was asked of growth beside what was measured: limits, and the table that says which are kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.growth.numbers import (
    Numbers,
    Point,
    picture,
    range_of,
    ratio,
    samples_to_goal,
    to_goal,
    within,
)
from benchmarks.page import MIB
from nephrite.atlas.tables import percent, table

METHODS = ("walk", "transport", "dipole", "cycles", "volpathmis")
MOST_TRIANGLES, MOST_SIZE, MOST_GIB, MOST_SECONDS = 2.0, 3.0, 6.0, 12.0

Value = Callable[[Numbers], float]


@dataclass(frozen=True)
class Results:
    """What has been measured: points along each axis; of first pictures the numbers, and the pictures themselves."""

    triangles: Sequence[Point] = ()
    size: Sequence[Point] = ()
    resolution: Sequence[Point] = ()
    g: Sequence[Point] = ()
    first: Sequence[tuple[Numbers, NDArray[np.uint8]]] = field(default_factory=list)

    def numbers(self) -> list[Numbers]:
        """Return the numbers of everything."""
        axes = (self.triangles, self.size, self.resolution, self.g)
        return [n for axis in axes for point in axis for n in point.of.values()] + [n for n, _ in self.first]


def values(points: Sequence[Point], name: str, value: Value) -> list[float]:
    """Return a value of a method at all points that it was measured at."""
    return [value(point.of[name]) for point in points if name in point.of]


def whole(points: Sequence[Point], name: str, value: Value) -> list[float]:
    """Return the same, nothing where the method lacks a point: what it grew by is not known then."""
    found = values(points, name, value)
    return found if len(found) == len(points) else []


def asked(results: Results) -> str:
    """Return the table of what was asked beside what was measured."""
    rows = []
    for name in METHODS:
        grown = ratio(whole(results.triangles, name, picture))
        what = f"triangles {_ends(results.triangles)}: `{name}`"
        rows.append([what, "time x 2", times(grown), within(grown, MOST_TRIANGLES)])
    for how, value in (("with its precomputation", to_goal), ("its samples alone", samples_to_goal)):
        found = whole(results.size, "transport", value)
        for what, grown in (("last to first", ratio(found)), ("worst to best", range_of(found))):
            told = f"size {_ends(results.size)} mm: `transport`, {how}, {what}"
            shown = times(grown) + _left_to_others(results.size)
            rows.append([told, "time to equal noise x 3", shown, within(grown, MOST_SIZE)])
    for name in ("walk", "transport"):
        peaks = whole(results.resolution, name, gib)
        shown = f"{max(peaks):.2f} GiB" if peaks else "-"
        what = f"{_ends(results.resolution)} pixels: `{name}`"
        rows.append([what, "memory 6 GiB", shown, within(max(peaks, default=math.nan), MOST_GIB)])
    for name in ("walk", "transport"):
        off = [point.of[name]["similarity"] for point in results.g if "similarity" in point.of.get(name, {})]
        used = "once directions are forgotten" if name == "transport" else "not used"
        whole_error = percent(off[-1]["error"], off[-1]["error_error"]) if off else "-"
        shown = f"{used}; from the first event on its error would be {whole_error} %" if off else "-"
        rows.append([f"g {_ends(results.g)}: `{name}`", "similarity where it is safe", shown, "-"])
    for name, cold in product(("walk", "transport"), (False, True)):
        runs = [n for n, _ in results.first if n["notes"]["model"] == name and n["cold"] == cold]
        seconds = max((n["seconds"] for n in runs), default=math.nan)
        what = f"first picture, the slowest: `{name}`, {'no kernels' if cold else 'kernels'} kept"
        shown = "-" if math.isnan(seconds) else f"{seconds:.1f} s"
        rows.append([what, "12 s", shown, within(seconds, MOST_SECONDS)])
    return "## Asked and measured\n\n" + table(["what grows", "asked: at most", "measured", "kept"], rows)


def gib(numbers: Numbers) -> float:
    return numbers["peak"] / (1024 * MIB)


def times(value: float) -> str:
    return "-" if math.isnan(value) else f"x {value:.2f}"


def _left_to_others(points: Sequence[Point]) -> str:
    """Return in words where something else was computed than `transport`, as asked for."""
    computed = {p.at: p.of["transport"]["computed"] for p in points if "transport" in p.of}
    places = [f"`{model}` at {at:,g}" for at, model in computed.items() if model != "transport"]
    return f" ({', '.join(places)} mm)" if places else ""


def _ends(points: Sequence[Point]) -> str:
    """Return the axis' first and last place."""
    return " -> ".join(f"{p.at:,.0f}" if p.at >= 1 else f"{p.at:g}" for p in (*points[:1], *points[-1:]))
