"""Quantities with units, as people type them: `100mm`, `30s`, `1%`, `800x600`."""

from __future__ import annotations

import math
import re

from nephrite.errors import ParameterError

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
SECONDS = {"s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}
LARGEST_SIDE = 16384  # pixels

_NUMBER = r"(?P<number>\d+\.?\d*|\.\d+)(?P<exponent>e[+-]?\d+)?"
_QUANTITY = re.compile(rf"{_NUMBER}\s*(?P<unit>[a-z]*)", re.IGNORECASE)


def length(text: str) -> float:
    """Return the length that `text` names, in millimetres: `100mm`, `2.5 cm`, `0.1m`, `4in`."""
    return _positive("length", text, MILLIMETRES, "100mm, 10cm, 0.1m or 4in")


def duration(text: str) -> float:
    """Return the time that `text` names, in seconds: `30s`, `2m`, `1m30s`, `0.5h`."""
    parts = re.findall(r"[\d.]+\s*[a-z]+", text, re.IGNORECASE)
    if len(parts) > 1 and "".join(parts).replace(" ", "") == text.replace(" ", ""):
        return sum(duration(part) for part in parts)
    return _positive("time", text, SECONDS, "30s, 2m or 1m30s")


def percentage(text: str) -> float:
    """Return the fraction that `text` names: `1%` is 0.01."""
    stripped = text.strip()
    try:
        value = float(stripped.removesuffix("%"))
    except ValueError:
        value = math.nan
    if not stripped.endswith("%") and not math.isnan(value):
        raise ParameterError(f"{text!r} has no percent sign: write {text}% (a tenth of the mean is 10%)")
    if not 0 < value < math.inf:
        raise ParameterError(f"{text!r} is no positive percentage: write it like 1% or 0.5%")
    return value / 100


def resolution(text: str) -> tuple[int, int]:
    """Return (width, height) in pixels from `800x600`."""
    match = re.fullmatch(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", text, re.IGNORECASE)
    if match is None:
        raise ParameterError(f"{text!r} is no resolution: write width x height in pixels, like 800x600")
    width, height = int(match[1]), int(match[2])
    if not (0 < width <= LARGEST_SIDE and 0 < height <= LARGEST_SIDE):
        raise ParameterError(f"{text!r}: each side must be between 1 and {LARGEST_SIDE} pixels")
    return width, height


def _positive(what: str, text: str, units: dict[str, float], examples: str) -> float:
    match = _QUANTITY.fullmatch(text.strip())
    if match is None:
        raise ParameterError(f"{text!r} is no {what}: write a number with its unit, like {examples}")
    unit = match["unit"].lower()
    if not unit:
        raise ParameterError(f"{text!r} has no unit: write {examples} (units: {', '.join(units)})")
    if unit not in units:
        raise ParameterError(f"{text!r} has an unknown unit {match['unit']!r}: write {examples}")
    value = float(match["number"] + (match["exponent"] or "")) * units[unit]
    if not 0 < value < math.inf:
        raise ParameterError(f"{text!r}: a {what} must be more than nothing and finite")
    return value
