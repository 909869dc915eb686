"""From pictures and times to the numbers of the page: error over time, time to 1 %, efficiency, bias."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from nephrite.atlas.compared import Difference, Estimate, difference
from nephrite.image import errors

GOAL = 0.01
"""The relMSE that methods race to."""

_EPSILON = 1e-2
_AROUND = 5  # pixels
_SURE = 3.0  # standard errors: fireflies make them uncertain


@dataclass(frozen=True)
class Truth:
    """A scene's reference, and the object's pixels."""

    estimate: Estimate
    mask: NDArray[np.bool_]

    @cached_property
    def scale(self) -> NDArray:
        """What relMSE divides by at each of the object's pixels: the square of the mean over those around, + epsilon.

        The pixel's own square would be small where noise makes it dark, and the more so the noisier the reference is.
        """
        inside = self.mask[..., None].astype(np.float64)
        size = (_AROUND, _AROUND, 1)
        near, count = (uniform_filter(x, size) for x in (self.estimate.mean * inside, inside))
        return ((near / np.maximum(count, 1e-12)) ** 2 + _EPSILON)[self.mask]

    @property
    def noise(self) -> float:
        """What the reference's own noise adds to every relMSE."""
        return float(np.mean(self.estimate.error[self.mask] ** 2 / self.scale))


def level(a: NDArray, b: NDArray, spp: int, seconds: float, truth: Truth) -> dict[str, float]:
    """Return what a pair of pictures of `spp` samples and `seconds` each says.

    `relmse`: against the truth, whose own noise is taken out; `noise`: the part of it that is variance, from the
    difference of the two. `floor`: the part that is bias, from the product of their errors, which are independent but
    for it; 0 below three of its standard errors, and where these are too large to say. `efficiency`: see
    `errors.efficiency`.
    """
    reference = truth.estimate.mean[truth.mask]
    scale = truth.scale
    first, second = (np.asarray(picture, np.float64)[truth.mask] - reference for picture in (a, b))
    # both hold the reference's error: its square is taken out
    common = (first * second - truth.estimate.error[truth.mask] ** 2) / scale
    floor, uncertain = float(common.mean()), float(common.std()) / math.sqrt(common.size)
    both = [float(np.mean(error**2 / scale)) for error in (first, second)]
    return {
        "spp": spp,
        "seconds": seconds,
        "relmse": max(sum(both) / 2 - truth.noise, 1e-9),
        "noise": float(np.mean((first - second) ** 2 / (2 * scale))),
        "floor": floor if floor > _SURE * uncertain and uncertain < GOAL else 0.0,
        "efficiency": errors.efficiency(a, b, seconds, truth.mask),
    }


@dataclass(frozen=True)
class TimeToGoal:
    """`seconds` until relMSE is `GOAL`: infinite if bias alone is above it.

    `how`: "=" where the curve crosses it, "~" beyond the curve's end, where noise is taken to fall as 1 / samples, "<"
    where its first point is already below.
    """

    seconds: float
    how: str


def before_samples(curve: Sequence[dict[str, float]]) -> float:
    """Return the seconds that a picture takes before its first sample, by how its time grows with the samples."""
    first, last = curve[0], curve[-1]
    if len(curve) == 1:
        return 0.0
    sample = (last["seconds"] - first["seconds"]) / (last["spp"] - first["spp"])
    return max(first["seconds"] - sample * first["spp"], 0.0)


def time_to_goal(curve: Sequence[dict[str, float]], goal: float = GOAL) -> TimeToGoal:
    """Return the time at which a curve of levels, each slower than the one before, reaches `goal`."""
    first, last = curve[0], curve[-1]
    if first["relmse"] <= goal:
        return TimeToGoal(first["seconds"], "<")
    for before, after in pairwise(curve):
        if after["relmse"] <= goal:  # between the two, 1 / relmse grows with the samples
            a, b, at = (1.0 / relmse for relmse in (before["relmse"], after["relmse"], goal))
            share = (at - a) / (b - a)
            return TimeToGoal(before["seconds"] + share * (after["seconds"] - before["seconds"]), "=")
    if last["floor"] >= goal:
        return TimeToGoal(math.inf, "~")
    return TimeToGoal(_of_noise(curve, goal - last["floor"]), "~")


def time_of_noise(curve: Sequence[dict[str, float]], goal: float = GOAL) -> float:
    """Return the time at which noise alone is at `goal`; of a single level that is below, its own time."""
    return curve[0]["seconds"] if len(curve) == 1 and curve[0]["noise"] <= goal else _of_noise(curve, goal)


def _of_noise(curve: Sequence[dict[str, float]], goal: float) -> float:
    fixed, last = before_samples(curve), curve[-1]
    return fixed + (last["seconds"] - fixed) * last["noise"] / goal


def mean_of(rounds: Sequence[tuple[NDArray, NDArray]]) -> Estimate:
    """Return the mean of all pairs of pictures, with its standard error from how the two of a pair differ."""
    pairs = [(np.asarray(a, np.float64), np.asarray(b, np.float64)) for a, b in rounds]
    total = sum((a + b for a, b in pairs), np.zeros(pairs[0][0].shape))
    variance = sum(((a - b) ** 2 for a, b in pairs), np.zeros(pairs[0][0].shape))
    return Estimate(total / (2 * len(pairs)), np.sqrt(variance) / (2 * len(pairs)))


def against_truth(estimate: Estimate, truth: Truth) -> Difference:
    """Return how far a picture is from the truth over the object's pixels, with its standard errors."""
    return difference(estimate, truth.estimate, truth.mask)


def never(error: Difference, goal: float = GOAL) -> bool:
    """Return whether bias alone, as blocks of pixels show it, is above `goal` for sure."""
    return error.error - 2.0 * error.error_error > math.sqrt(goal)


@dataclass(frozen=True)
class Spread:
    """The mean of a ratio over the rounds (geometric), and its least and largest value."""

    mean: float
    least: float
    largest: float


def ratio(above: Sequence[float], below: Sequence[float]) -> Spread | None:
    """Return the ratio of two quantities measured round by round; None if there is none that is finite."""
    ratios = [a / b for a, b in zip(above, below, strict=False) if 0.0 < a < math.inf and 0.0 < b < math.inf]
    if not ratios:
        return None
    mean = math.exp(sum(math.log(r) for r in ratios) / len(ratios))
    return Spread(mean, min(ratios), max(ratios))


def summary(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the numbers of a method's rounds, as lists over them, and the curve of the means.

    `goal`: seconds to `GOAL`; `quiet`: the same if it had no bias. The curve has a point for each number of samples,
    the mean of the rounds that have it.
    """
    curves = [run["curve"] for run in runs]
    levels: dict[int, list[dict[str, float]]] = {}
    for point in (point for curve in curves for point in curve):
        levels.setdefault(int(point["spp"]), []).append(point)
    mean_curve = [
        {key: float(np.mean([point[key] for point in level])) for key in ("seconds", "relmse", "noise")}
        for _, level in sorted(levels.items())
    ]
    goals = [time_to_goal(curve) for curve in curves]
    return {
        "curve": mean_curve,
        "efficiency": [curve[-1]["efficiency"] for curve in curves],
        "goal": [goal.seconds for goal in goals],
        "quiet": [time_of_noise(curve) for curve in curves],
        "how": goals[0].how if len({goal.how for goal in goals}) == 1 else "~",
        "rate": [run["samples"] / run["curve"][-1]["seconds"] for run in runs],
        "peak": max(run["peak"] for run in runs),
        "version": runs[0]["version"],
    }
