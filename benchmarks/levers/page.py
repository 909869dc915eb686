"""Writes the page of the levers: what each is worth, and where the time goes."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import nephrite
from benchmarks.levers import words
from benchmarks.levers.patches import LEVERS, TRANSPORT, WALK
from benchmarks.levers.where import RAYS
from benchmarks.peers.measure import cores
from nephrite.atlas.tables import paragraph, table

Told = Mapping[str, Sequence[Mapping[str, Any]]]
"""What processes have told, a list of rounds for each lever's name; "" for all levers."""


def write(target: Path, found: Mapping[str, Told], settings: Mapping[str, Any]) -> Path:
    """Write the page to `target`; returns it. `found`: of each model."""
    dates = sorted(told["date"] for runs in found.values() for rounds in runs.values() for told in rounds)
    given = {
        "version": nephrite.__version__, "cores": cores(), "first": dates[0], "last": dates[-1],
        "resolution": settings["resolution"], "rounds": settings["rounds"],
        "walk": settings["spp"][WALK], "transport": settings["spp"][TRANSPORT],
    }  # fmt: skip
    parts = [
        "# Levers",
        words.MADE,
        *(paragraph(part) for part in words.HEAD.format(**given).strip().split("\n\n")),
    ]
    for model, runs in found.items():
        parts += [f"## {words.TITLES[model]}", table(("lever", "without it", "worth"), _rows(model, runs))]
    parts += ["## Where the time goes", *(paragraph(part) for part in words.WHERE.strip().split("\n\n"))]
    parts += [table(*_times(found))]
    parts += [
        "## Where the noise comes from",
        *(paragraph(part) for part in words.NOISE.strip().split("\n\n")),
    ]
    parts += [table(*_noise(found)), words.DROPPED.strip(), words.AGAIN.strip()]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    return target


def worth(runs: Told, lever: str) -> tuple[float, float, float]:
    """Return how many times the efficiency is with a lever: geometric mean, least and largest of the rounds."""
    ratios = [
        with_["efficiency"] / without["efficiency"]
        for with_, without in zip(runs[""], runs[lever], strict=True)
    ]
    return statistics.geometric_mean(ratios), min(ratios), max(ratios)


def _rows(model: str, runs: Told) -> list[list[str]]:
    rows = []
    for lever in LEVERS[model]:
        mean, least, largest = worth(runs, lever.name)
        spread = f" ({least:.2f} to {largest:.2f})" if len(runs[lever.name]) > 1 else ""
        rows.append([lever.title, lever.instead, f"x {mean:.2f}{spread}"])
    return rows


def _noise(found: Mapping[str, Told]) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of the table of noise, a column for each model."""
    of = {model: [told["noise"] for told in runs[""]] for model, runs in found.items()}
    rows = [
        [term, *(f"{statistics.fmean(noise[term] for noise in each):.5f}" for each in of.values())]
        for term in next(iter(of.values()))[0]
    ]
    return ["", *(f"`{model}`" for model in found)], rows


def _times(found: Mapping[str, Told]) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of the table of times, a column for each model."""
    first = {model: runs[""][0]["where"] for model, runs in found.items()}
    parts = [
        name
        for name in next(iter(first.values()))["parts"]
        if any(one["parts"][name] for one in first.values())
    ]

    def row(title: str, value: Any, digits: int = 2) -> list[str]:
        return [title, *(f"{value(one):.{digits}f}" for one in first.values())]

    rows = [
        row("a picture, seconds", lambda one: one["all"]),
        row("of it kernels, rays among them", lambda one: one["kernels"]),
        row(
            "of it Python, NumPy and SciPy, while no kernel runs",
            lambda one: max(one["all"] - one["kernels"], 0.0),
        ),
        *(row(f"of it precomputed: {name}", lambda one, name=name: one["parts"][name]) for name in parts),
        row("compiling, before the first picture of all", lambda one: one["compiling"]),
        *(row(f"rays a sample: {name}", lambda one, name=name: one["rays"][name]) for name in RAYS),
    ]
    return ["", *(f"`{model}`" for model in first)], rows
