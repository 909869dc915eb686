"""From the times and pictures of growth to its numbers: cost of a picture, time to equal noise, ratios."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.analysis import GOAL
from nephrite.image import errors

Numbers = dict[str, Any]

_UNSURE = 0.1  # of a picture's time, and seconds: what first calls differ by without any precomputation


@dataclass(frozen=True)
class Point:
    """Where on an axis something was measured (triangles, mm, pixels, g), and each method's numbers by its name."""

    at: float
    of: dict[str, Numbers] = field(default_factory=dict)


def cost(told: Numbers) -> Numbers:
    """Return seconds of a picture's samples, `sampling`, and of what goes `before` and is paid once.

    `told`: see `renders.timed`. Where each call starts up anew, a call with one sample is taken off, as the benchmark
    does.
    """
    spp, again = told["spp"], float(np.mean(told["again"]))
    if told["once"] > 0.0:
        return {"sampling": max(again - told["once"], 1e-3) * spp / max(spp - 1, 1), "before": 0.0}
    before = told["first"] - again
    return {"sampling": again, "before": before if before > _UNSURE * (1.0 + again) else 0.0}


def variance(a: NDArray, b: NDArray, mask: NDArray[np.bool_]) -> float:
    """Return the variance of two pictures of the same, relative to the squared mean, over the object's pixels."""
    return 1.0 / errors.efficiency(a, b, 1.0, mask)


def picture(numbers: Numbers) -> float:
    """Return seconds of a first picture: what is precomputed for it, and its samples."""
    return numbers["before"] + numbers["sampling"]


def samples_to_goal(numbers: Numbers) -> float:
    """Return seconds of samples until the relative variance is `GOAL`; it falls with their number."""
    return numbers["sampling"] * numbers["variance"] / GOAL


def to_goal(numbers: Numbers) -> float:
    """Return the same with what goes before the samples, once."""
    return numbers["before"] + samples_to_goal(numbers)


def ratio(values: Sequence[float]) -> float:
    """Return the last value over the first; NaN if there are not two."""
    return values[-1] / values[0] if len(values) > 1 else math.nan


def range_of(values: Sequence[float]) -> float:
    """Return the largest value over the least; NaN if there are not two."""
    return max(values) / min(values) if len(values) > 1 else math.nan


def within(value: float, most: float) -> str:
    """Return whether a value keeps within what was asked, in a word; a dash where nothing was measured."""
    if math.isnan(value):
        return "-"
    return "yes" if value <= most else "**no**"
