"""Which model to use, read off the measurements: a table for people, and a rule for `auto`.

Nothing here is typed by hand: another measurement makes another table.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from itertools import pairwise
from statistics import fmean, median
from typing import Any

from nephrite.atlas.pictures import TRUTH

__all__ = ["FINAL", "PREVIEW", "Advice", "Rule", "advice", "rule"]

FINAL, PREVIEW = 0.05, 0.15
"""Errors that are good enough for a final picture and for a preview."""

THICKNESSES = (0.0, 3.0, 10.0, 30.0, 100.0, math.inf)
ALBEDOS = (0.0, 0.9, 0.99, 1.0)
"""Limits of the table's cells: mean chord in reduced mean free paths, reduced albedo."""

_NOISY = 0.1  # a channel whose standard error is above this says nothing
_FEWEST = 4  # pictures that a rule must rest on
_SURE = 2.0  # standard errors by which an error must be above a limit to be held against a model
_WALKS = ("walk", TRUTH)

Row = dict[str, Any]
Score = tuple[str, float, float, float]


@dataclass(frozen=True)
class Advice:
    """What to use for a range of thickness and albedo: each a method, its error there, the error's standard error,
    and its efficiency relative to the walk.

    `exact`: least error; `final`, `preview`: the most efficient within `FINAL` or `PREVIEW`, the walk if none is;
    `diffusion`: least error of the methods that do not walk. `count`: channels of pictures that it rests on.
    """

    thickness: tuple[float, float]
    albedo: tuple[float, float]
    count: int
    exact: Score
    final: Score
    preview: Score
    diffusion: Score


@dataclass(frozen=True)
class Rule:
    """Use `model` for objects at least so thick and light, in the least channel: it is then within `limit`.

    `views`: pictures that it rests on. `worst`: largest error in them; `efficiency`: median, relative to the walk.
    """

    model: str
    thickness: float
    albedo: float
    limit: float
    views: int
    worst: float
    efficiency: float


def advice(rows: list[Row]) -> list[dict[str, Any]]:
    """Return an `Advice` for each cell that the rows of `pictures.pictures` say something of, as dictionaries."""
    found = []
    for low, high in pairwise(THICKNESSES):
        for dark, light in pairwise(ALBEDOS):
            best, count = _scores(rows, (low, high), (dark, light))
            if not best:
                continue
            local = [one for one in best.values() if one[0] not in _WALKS]
            one = Advice(
                (low, high), (dark, light), count,
                exact=min(best.values(), key=lambda score: score[1]),
                final=_fastest(best, FINAL),
                preview=_fastest(best, PREVIEW),
                diffusion=min(local, key=lambda score: score[1]),
            )  # fmt: skip
            found.append(asdict(one))
    return found


def _scores(
    rows: list[Row], thickness: tuple[float, float], albedo: tuple[float, float]
) -> tuple[dict[str, Score], int]:
    """Root mean square error, with its noise, and median efficiency of each method over the channels of a cell.

    Returns the number of channels too; nothing if there is none for some method.
    """
    errors: dict[str, list[tuple[float, float]]] = {}
    speeds: dict[str, list[float]] = {}
    for row in rows:
        channels = zip(row["thickness"], row["albedo"], row["channels"], row["channels_error"], strict=True)
        for depth, lightness, error, noise in channels:
            if thickness[0] <= depth < thickness[1] and albedo[0] <= lightness < albedo[1] and noise < _NOISY:
                errors.setdefault(row["method"], []).append((error, noise))
                speeds.setdefault(row["method"], []).append(row["efficiency"])
    if not errors or set(errors) != {row["method"] for row in rows}:
        return {}, 0
    scores = {}
    for name, values in errors.items():
        mean = math.sqrt(fmean(error**2 for error, _ in values))
        noise = math.sqrt(fmean(width**2 for _, width in values) / len(values))
        scores[name] = (name, mean, noise, median(speeds[name]))
    return scores, max(len(values) for values in errors.values())


def _fastest(best: dict[str, Score], limit: float) -> Score:
    within = [one for one in best.values() if one[1] <= limit]
    return max(within, key=lambda one: one[3]) if within else best["walk"]


def rule(rows: list[Row], limit: float = FINAL) -> dict[str, Any] | None:
    """Return the `Rule` that saves most time, as a dictionary; None if nothing but the walk is within the limit.

    A rule is a model and two thresholds such that none of at least `_FEWEST` pictures beyond both is further off than
    `limit`, by more than noise explains. The time saved is the sum of the logarithms of the efficiencies.
    """
    found: tuple[float, Rule] | None = None
    for name in dict.fromkeys(row["method"] for row in rows):
        if name in _WALKS:
            continue
        own = [row for row in rows if row["method"] == name]
        depths = sorted({min(row["thickness"]) for row in own})
        for depth in depths:
            for lightness in sorted({min(row["albedo"]) for row in own}):
                beyond = [
                    row for row in own if min(row["thickness"]) >= depth and min(row["albedo"]) >= lightness
                ]
                if len(beyond) < _FEWEST or any(
                    row["error"] - _SURE * row["error_error"] > limit for row in beyond
                ):
                    continue
                saved = sum(math.log(max(row["efficiency"], 1e-9)) for row in beyond)
                if saved > 0.0 and (found is None or saved > found[0]):
                    worst = max(row["error"] for row in beyond)
                    speed = median(row["efficiency"] for row in beyond)
                    thinnest, darkest = (
                        min(min(row[key]) for row in beyond) for key in ("thickness", "albedo")
                    )
                    found = (saved, Rule(name, thinnest, darkest, limit, len(beyond), worst, speed))
    return asdict(found[1]) if found else None
