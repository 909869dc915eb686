"""Has a model become worse? Measurements of now beside recorded ones, row by row."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from nephrite.image.errors import z_limit

__all__ = ["FALSE_ALARM", "worse"]

FALSE_ALARM = 1e-3
"""Probability that any row at all is reported although nothing but the random numbers has changed."""

_ROUNDED = 2e-4  # digits that files leave out, and other processors' arithmetic
_SPREAD = (
    0.4  # standard deviation of a profile error, by the error that noise alone makes: from some 25 rings
)

Row = Mapping[str, Any]
Measure = Callable[[Row], tuple[float, float]]

_KEYS = {
    "half_spaces": ("model", "incidence", "albedo", "eta", "g"),
    "slabs": ("model", "incidence", "albedo", "eta", "thickness"),
    "pictures": ("method", "object", "size", "material", "light"),
}
_MEASURES: dict[str, dict[str, Measure]] = {
    "half_spaces": {
        "total": lambda row: (abs(row["total"]), 0.0),
        "profile": lambda row: (row["profile"], _SPREAD * row["noise"]),
    },
    "slabs": {
        side: lambda row, side=side: (
            abs((row[side] or 0.0) - row[f"true_{side}"]) if _known(row[side]) else 0.0,
            row[f"{side}_error"],
        )
        for side in ("reflected", "transmitted")
    },
    "pictures": {
        "error": lambda row: (row["error"], row["error_error"]),
        "bias": lambda row: (abs(row["bias"]), row["bias_error"]),
    },
}
"""What is watched: the size of an error, and its standard error."""


def worse(now: Mapping[str, Any], recorded: Mapping[str, Any], false_alarm: float = FALSE_ALARM) -> list[str]:
    """Return a sentence for each recorded row whose error has grown by more than noise explains, or that is gone.

    Both are what `measure.measured` returns, or its file read by `json`. The limit is Šidák's, for the number of rows
    and two normal errors. Getting better is no offence, nor are rows that were not recorded.
    """
    pairs = list(_pairs(now, recorded))
    limit = z_limit(max(len(pairs), 1), 2.0 * false_alarm)  # one-sided
    found = []
    for label, one, other in pairs:
        if one is None:
            found.append(f"{label} is missing")
            continue
        spread = math.hypot(one[1], other[1])
        if one[0] - other[0] > limit * spread + _ROUNDED:
            found.append(f"{label} is {one[0]:.4g}, but was {other[0]:.4g} (noise {spread:.2g})")
    return found


def _pairs(
    now: Mapping[str, Any], recorded: Mapping[str, Any]
) -> Iterator[tuple[str, tuple[float, float] | None, tuple[float, float]]]:
    for part, measures in _MEASURES.items():
        keys = _KEYS[part]
        present = {tuple(row[key] for key in keys): row for row in now[part]}
        for old in recorded[part]:
            key = tuple(old[key] for key in keys)
            label = ", ".join(str(one) for one in key)
            for name, measure in measures.items():
                new = present.get(key)
                yield f"{label}: {name}", None if new is None else measure(new), measure(old)


def _known(value: float | None) -> bool:
    return value is not None and math.isfinite(value)
