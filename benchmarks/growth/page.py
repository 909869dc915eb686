"""Writes the page of growth: what was asked beside what was measured, then a plot and a table for all that grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nephrite
from benchmarks.growth import words
from benchmarks.growth.asked import (
    METHODS,
    MOST_GIB,
    MOST_SIZE,
    MOST_TRIANGLES,
    Results,
    Value,
    asked,
    gib,
    times,
    values,
)
from benchmarks.growth.numbers import Numbers, Point, picture, range_of, samples_to_goal, to_goal
from benchmarks.growth.plots import Panel, panels
from benchmarks.page import MIB, short
from benchmarks.peers.measure import cores
from nephrite.atlas.tables import paragraph, percent, table
from nephrite.image import figure
from nephrite.image import write as images


def write(
    target: Path,
    results: Results,
    titles: Mapping[str, str],
    left_out: Mapping[str, str],
    plan: Mapping[str, Any],
    quick: bool,
) -> Path:
    """Write the page to `target` and its figures beside it, into figures/growth; returns `target`.

    `titles`: of the methods, by name; `plan`: see `run.FULL`.
    """
    width, height = plan["resolution"]
    given = {**plan, "resolution": f"{width}x{height}"}
    figures = target.parent / "figures/growth"
    figures.mkdir(parents=True, exist_ok=True)
    parts = [
        _head(results, quick),
        asked(results),
        _triangles(results.triangles, titles, figures, given),
        _size(results.size, titles, figures, given),
        _resolution(results.resolution, titles, figures, given),
        _g(results.g, titles, figures, given),
        _first(results.first, figures, given),
        _left_out(left_out),
        words.AGAIN.strip(),
    ]
    target.write_text("\n\n".join(part for part in parts if part) + "\n", encoding="utf-8")
    return target


def _head(results: Results, quick: bool) -> str:
    told = [words.HEAD.strip()]
    measured = results.numbers()
    if measured:
        dates = sorted(numbers["date"][:16] for numbers in measured)
        versions = sorted({numbers["version"] for numbers in measured if "version" in numbers})
        told.append(
            f"Version {nephrite.__version__}{' with ' if versions else ''}{'; '.join(versions)}. Measured from "
            f"{dates[0]} to {dates[-1]} UTC on {cores()} processor cores."
        )
    note = "<!-- Made by `make growth`: change the code in benchmarks/, not this page. -->"
    warning = words.QUICK.strip() if quick else ""
    return "\n\n".join(part for part in ["# Growth", note, paragraph(*told), warning] if part)


def _triangles(
    points: Sequence[Point], titles: Mapping[str, str], figures: Path, given: Mapping[str, Any]
) -> str:
    rows = [
        [
            f"{point.at:,.0f}", titles[name], f"{n['spp']}", f"{picture(n):.2f}", _before(n), f"{n['loaded']:.1f}",
            f"{n['peak'] / MIB:.0f}", _relative(points, point, name, picture),
        ]
        for name in METHODS for point in points if name in point.of for n in [point.of[name]]
    ]  # fmt: skip
    ticks = {point.at: f"{point.at / 1e3:.0f} k" for point in points}
    head = (
        "triangles", "method", "samples", "seconds", "of it precomputed", "loading", "memory, MiB", "x",
    )  # fmt: skip
    shown = [
        Panel("seconds for a picture", "triangles", _lines(points, picture), ticks),
        Panel("relative to the fewest", "triangles", _relative_lines(points, picture), ticks, MOST_TRIANGLES),
    ]
    return _section(
        "Triangles", words.TRIANGLES.format(**given), figures / "triangles.svg", shown, titles, head, rows
    )


def _size(points: Sequence[Point], titles: Mapping[str, str], figures: Path, given: Mapping[str, Any]) -> str:
    rows = [
        [
            f"{point.at:g}", titles[name], short(to_goal(n)), _before(n), short(samples_to_goal(n)),
            _relative(points, point, name, to_goal), n["computed"],
        ]
        for name in METHODS for point in points if name in point.of for n in [point.of[name]]
    ]  # fmt: skip
    ticks = {point.at: f"{point.at:g}" for point in points}
    head = ("size, mm", "method", "seconds to 1 %", "of it precomputed", "samples", "x", "computed")
    worst = [
        f"{titles[name]} {times(range_of(values(points, name, to_goal)))}"
        for name in METHODS
        if values(points, name, to_goal)
    ]
    told = words.SIZE.format(**given) + f"\nFrom the best to the worst of all sizes: {', '.join(worst)}."
    shown = [
        Panel("seconds to 1 %", "size, mm", _lines(points, to_goal), ticks),
        Panel("relative to the smallest", "size, mm", _relative_lines(points, to_goal), ticks, MOST_SIZE),
    ]
    return _section("Optical thickness", told, figures / "size.svg", shown, titles, head, rows)


def _resolution(
    points: Sequence[Point], titles: Mapping[str, str], figures: Path, given: Mapping[str, Any]
) -> str:
    rows = [
        [
            f"{point.at:,.0f}", titles[name], n["notes"]["samples"], f"{n['seconds']:.1f}", f"{gib(n):.2f}",
            n["notes"]["denoised"],
        ]
        for name in METHODS for point in points if name in point.of for n in [point.of[name]]
    ]  # fmt: skip
    ticks = {point.at: f"{point.at / 1e6:.2g}" for point in points}
    head = ("pixels", "model", "samples", "seconds", "peak, GiB", "denoised")
    shown = [
        Panel("peak memory, GiB", "million pixels", _lines(points, gib), ticks, MOST_GIB),
        Panel(
            "seconds, denoising among them", "million pixels", _lines(points, lambda n: n["seconds"]), ticks
        ),
    ]
    return _section(
        "Resolution", words.RESOLUTION.format(**given), figures / "resolution.svg", shown, titles, head, rows
    )


def _g(points: Sequence[Point], titles: Mapping[str, str], figures: Path, given: Mapping[str, Any]) -> str:
    rows = []
    for name in METHODS:
        for point in points:
            if name in point.of:
                n = point.of[name]
                row = [
                    f"{point.at:g}",
                    titles[name],
                    short(to_goal(n)),
                    _before(n),
                    short(samples_to_goal(n)),
                ]
                off = n.get("similarity", {})
                row += [
                    percent(off[part], off[f"{part}_error"], signed=part != "error") if off else "-"
                    for part in ("bias", "error", "worst")
                ]
                rows.append(row)
    head = (
        "g", "method", "seconds to 1 %", "of it precomputed", "samples", "similarity: bias %", "error %",
        "worst block %",
    )  # fmt: skip
    ticks = {1.0 / (1.0 - point.at): f"{point.at:g}" for point in points}
    stretched = [Point(1.0 / (1.0 - point.at), point.of) for point in points]
    shown = [
        Panel("seconds to 1 %", "g", _lines(stretched, to_goal), ticks),
        Panel("error of similarity, %", "g", _lines(stretched, _similarity), ticks),
    ]
    return _section("Anisotropy", words.G.format(**given), figures / "g.svg", shown, titles, head, rows)


def _first(runs: Sequence[tuple[Numbers, NDArray[np.uint8]]], figures: Path, given: Mapping[str, Any]) -> str:
    if not runs:
        return ""
    shown: dict[str, NDArray[np.uint8]] = {}
    for n, pixels in runs:
        shown.setdefault(n["notes"]["model"], pixels)
    both = figure.side_by_side(list(shown.values()), list(shown))
    images.save(figures / "first.png", both, {"shows": "first pictures"})
    rows = [
        [
            n["notes"]["model"], "no" if n["cold"] else "yes", f"{n['seconds']:.1f}", n["notes"]["samples"],
            f"{100 * float(n['notes']['noise_reached']):.1f}", n["notes"]["denoised"],
        ]
        for n, _ in runs
    ]  # fmt: skip
    head = ("model", "kernels kept", "seconds", "samples", "noise before the denoiser, %", "denoised")
    told = _prose(words.FIRST.format(**given))
    picture_ = "![First pictures: B1 in skim milk](figures/growth/first.png)"
    return "\n\n".join(["## First picture", told, picture_, table(head, rows)])


def _section(
    title: str, told: str, plot: Path, shown: Sequence[Panel], titles: Mapping[str, str],
    head: Sequence[str], rows: Sequence[Sequence[str]],
) -> str:  # fmt: skip
    """Return a section, and draw its plot; empty where nothing was measured."""
    if not rows:
        return ""
    panels(plot, shown, titles)
    image = f"![{title}: {', '.join(panel.title for panel in shown)}](figures/growth/{plot.name})"
    return "\n\n".join([f"## {title}", _prose(told), image, table(head, rows)])


def _prose(told: str) -> str:
    """Return paragraphs filled; a block of code stays as it is."""
    parts = told.strip().split("\n\n")
    return "\n\n".join(part if part.startswith("```") else paragraph(part) for part in parts)


def _lines(points: Sequence[Point], value: Value) -> dict[str, list[tuple[float, float]]]:
    found = {name: [(p.at, value(p.of[name])) for p in points if name in p.of] for name in METHODS}
    return {name: line for name, line in found.items() if line}


def _relative_lines(points: Sequence[Point], value: Value) -> dict[str, list[tuple[float, float]]]:
    return {name: [(x, y / line[0][1]) for x, y in line] for name, line in _lines(points, value).items()}


def _relative(points: Sequence[Point], point: Point, name: str, value: Value) -> str:
    return f"{value(point.of[name]) / values(points, name, value)[0]:.2f}"


def _similarity(numbers: Numbers) -> float:
    return 100.0 * numbers.get("similarity", {}).get("error", 0.0)


def _before(numbers: Numbers) -> str:
    return f"{numbers['before']:.2f}" if numbers["before"] else "-"


def _left_out(left_out: Mapping[str, str]) -> str:
    if not left_out:
        return ""
    return "## Left out\n\n" + "\n".join(f"- {what}: {why}" for what, why in left_out.items())
