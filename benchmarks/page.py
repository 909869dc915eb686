"""Writes the benchmark's page: what was compared, how, and what came out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import nephrite
from benchmarks import analysis, asked, curves, words
from benchmarks.methods import BASE, Method
from benchmarks.peers.measure import cores
from benchmarks.scenes import Scene
from nephrite.atlas.compared import Difference, Estimate
from nephrite.atlas.tables import paragraph, percent, table

MIB = 2**20


@dataclass(frozen=True)
class SceneResult:
    """A scene, as it was given to the peers, its truth, and of each method (numbers, pictures) for every round."""

    scene: Scene
    described: dict[str, Any]
    truth: analysis.Truth
    runs: Mapping[str, Sequence[tuple[dict[str, Any], dict[str, Any]]]]

    def numbers(self, name: str) -> list[dict[str, Any]]:
        """Return the numbers of a method's rounds."""
        return [numbers for numbers, _ in self.runs[name]]

    def estimate(self, name: str) -> Estimate:
        """Return the mean of all the pictures of a method."""
        return analysis.mean_of([(p["a"], p["b"]) for _, p in self.runs[name]])

    def error(self, name: str) -> Difference:
        """Return how far that mean is from the truth."""
        return analysis.against_truth(self.estimate(name), self.truth)

    def around(self, name: str) -> Difference:
        """Return the same of the pixels around the object: whether light, floor and sky are those of the others."""
        return analysis.against_truth(self.estimate(name), replace(self.truth, mask=~self.truth.mask))


def write(
    target: Path, results: Sequence[SceneResult], methods: Sequence[Method],
    left_out: Mapping[str, str], given: Mapping[str, Any],
) -> Path:  # fmt: skip
    """Write the page to `target` and its figures beside it, into figures/benchmark; returns `target`."""
    figures = target.parent / "figures/benchmark"
    figures.mkdir(parents=True, exist_ok=True)
    parts = [_head(results, given), _rules(given)]
    if results:
        parts.append(_asked(results, methods))
        panels = {
            r.scene.title: {name: analysis.summary(r.numbers(name))["curve"] for name in r.runs}
            for r in results
        }
        curves.over_time(figures / "curves.png", panels, methods)
        parts += ["## Error over time", "![relMSE over time](figures/benchmark/curves.png)"]
        parts.append(_first_table(results, methods))
    for result in results:
        parts.append(_scene(result, methods, figures))
    parts += [_materials(results), _comparable(), _left_out(left_out), words.AGAIN]
    target.write_text("\n\n".join(part for part in parts if part) + "\n", encoding="utf-8")
    return target


def _head(results: Sequence[SceneResult], given: Mapping[str, Any]) -> str:
    note = "<!-- Made by `make bench`: change the code in benchmarks/, not this page. -->"
    told = [
        "Nephrite beside the renderers that pip installs: the same scenes, on the same processor, in one run."
    ]
    runs = [numbers for r in results for name in r.runs for numbers in r.numbers(name)]
    if not runs:
        told.append(
            "Nothing has been measured yet for this version: `make bench` does, and writes its tables here."
        )
    else:
        dates = sorted(numbers["date"] for numbers in runs)
        versions = sorted({numbers["version"] for numbers in runs})
        told.append(
            f"Version {nephrite.__version__} with {'; '.join(versions)}. Measured from {dates[0][:16]} to "
            f"{dates[-1][:16]} UTC on {cores()} processor cores, {given['resolution']} pixels."
        )
    warning = (
        "**A quick run: whether everything works, too short for its numbers to mean anything.**"
        if given["quick"]
        else ""
    )
    return "\n\n".join(part for part in ["# The benchmark", note, paragraph(*told), warning] if part)


def _rules(given: Mapping[str, Any]) -> str:
    told = (words.RULES.format(**given), words.MEASURES.format(base=BASE))
    return "\n\n".join(["## How it is measured", *(paragraph(part.strip()) for part in told)])


def _asked(results: Sequence[SceneResult], methods: Sequence[Method]) -> str:
    """Return the table of what was asked beside what was measured; empty without its scene."""
    result = next((r for r in results if r.scene.name == asked.SCENE), None)
    if result is None:
        return ""
    numbers = {name: analysis.summary(result.numbers(name)) for name in result.runs}
    titles = {method.name: method.title for method in methods}
    rows = []
    for one in asked.ASKED:
        found = one.measured(numbers)
        if found is not None:
            how = "efficiency" if one.by_efficiency else f"time to {100 * analysis.GOAL:g} %"
            what = f"{titles[one.method]}, {how}, over {titles[one.other]}"
            rows.append([what, f"at least {one.least:g}", _spread(found), _kept(found.mean >= one.least)])
    if asked.METHOD in result.runs:
        error = result.error(asked.METHOD)
        for what, value, sure, most in (
            ("bias", error.bias, error.bias_error, asked.MOST_BIAS),
            ("bias of its worst block", error.worst, error.worst_error, asked.MOST_IN_BLOCK),
        ):
            shown = f"{percent(value, sure, signed=True)} %"
            limit = f"at most {100 * most:g} %"
            rows.append([f"{titles[asked.METHOD]}, {what}", limit, shown, _kept(abs(value) <= most)])
    told = paragraph(words.ASKED.strip())
    return f"## Asked of {result.scene.title}\n\n{told}\n\n" + table(
        ["what", "asked", "measured", "kept"], rows
    )


def _kept(kept: bool) -> str:
    return "yes" if kept else "no"


def _first_table(results: Sequence[SceneResult], methods: Sequence[Method]) -> str:
    """Return how many times faster to 1 % than the base each method is in each scene."""
    rows = []
    for method in methods:
        if any(method.name in r.runs for r in results):
            rows.append([method.title, *(_faster(r, method.name) for r in results)])
    told = paragraph(words.FASTER.strip())
    return told + "\n\n" + table(["method", *(r.scene.title for r in results)], rows)


def _faster(result: SceneResult, name: str) -> str:
    if name not in result.runs or BASE not in result.runs:
        return ""
    own, base = (analysis.summary(result.numbers(n)) for n in (name, BASE))
    if analysis.never(result.error(name)) or all(math.isinf(seconds) for seconds in own["goal"]):
        return "-"
    return _spread(analysis.ratio(base["quiet"], own["goal"]))


def _scene(result: SceneResult, methods: Sequence[Method], figures: Path) -> str:
    shown = [method for method in methods if method.name in result.runs]
    errors = {method.name: result.error(method.name) for method in shown}
    sheet = figures / f"{result.scene.name}.png"
    means = {method.name: result.estimate(method.name) for method in shown}
    curves.pictures(sheet, result.scene.title, result.truth, means, errors, shown)
    rows = [_row(result, method, errors[method.name]) for method in shown]
    head = (
        "method", "seconds to 1 %", "noise alone", "times faster", "efficiency", "ratio", "bias %", "worst block %",
        "around %", "Msamples/s", "memory, MiB",
    )  # fmt: skip
    told = paragraph(
        f"{result.described['triangles']:,} triangles, {result.scene.size:g} mm. The reference's own relative "
        f"variance is {100 * result.truth.noise:.2g} %."
    )
    return "\n\n".join(
        [
            f"## {result.scene.title}",
            told,
            f"![{result.scene.title}](figures/benchmark/{sheet.name})",
            table(head, rows),
        ]
    )


def _row(result: SceneResult, method: Method, error: Difference) -> list[str]:
    own = analysis.summary(result.numbers(method.name))
    base = analysis.summary(result.numbers(BASE)) if BASE in result.runs else None
    around = result.around(method.name)
    finite = [s for s in own["goal"] if math.isfinite(s) and not analysis.never(error)]
    sign = "" if own["how"] == "=" else f"{own['how']} "
    return [
        method.title,
        f"{sign}{short(float(np.median(finite)))}" if finite else "-",
        short(float(np.median(own["quiet"]))),
        _faster(result, method.name),
        short(float(np.mean(own["efficiency"]))),
        _spread(analysis.ratio(own["efficiency"], base["efficiency"])) if base else "",
        percent(error.bias, error.bias_error, signed=True),
        percent(error.worst, error.worst_error, signed=True),
        percent(around.bias, around.bias_error, signed=True),
        f"{max(own['rate']) / 1e6:.2f}",
        f"{own['peak'] / MIB:.0f}",
    ]


def _spread(spread: analysis.Spread | None) -> str:
    if spread is None:
        return ""
    if spread.least == spread.largest:
        return short(spread.mean)
    return f"{short(spread.mean)} ({short(spread.least)} to {short(spread.largest)})"


def short(value: float) -> str:
    """Return two significant digits, and no exponent; beyond a million, and below its inverse, only that."""
    if not 1e-6 < value < 1e6:
        return "> 1,000,000" if value > 1.0 else "< 0.000001"
    digits = 1 - math.floor(math.log10(value))
    return f"{round(value, digits):,.{max(digits, 0)}f}"


def _materials(results: Sequence[SceneResult]) -> str:
    if not results:
        return ""

    def three(values: Sequence[float]) -> str:
        return " ".join(f"{value:.3g}" for value in values)

    rows = [
        [
            r.scene.material, three(r.described["sigma_a"]), three(r.described["sigma_s"]), f"{r.described['g']:g}",
            f"{r.described['eta']:g}", three(r.described["color"]), three(r.described["radius"]),
        ]
        for r in results
    ]  # fmt: skip
    told = paragraph(words.MATERIALS.strip())
    head = ("material", "sigma_a", "sigma_s", "g", "eta", "colour", "mean free path")
    return "\n\n".join(["## Materials", told, table(head, rows)])


def _comparable() -> str:
    points = (paragraph(f"- {text.strip()}").replace("\n", "\n  ") for text in words.COMPARABLE)
    return "## What is and is not comparable\n\n" + "\n".join(points)


def _left_out(left_out: Mapping[str, str]) -> str:
    if not left_out:
        return ""
    return "## Left out\n\n" + "\n".join(f"- {what}: {why}" for what, why in left_out.items())
