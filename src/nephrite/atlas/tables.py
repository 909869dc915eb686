"""Numbers of the atlas as Markdown: what is noise is not shown as a number."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence

__all__ = ["interval", "paragraph", "percent", "points", "table", "title"]

_SURE = 2.0


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def paragraph(*sentences: str) -> str:
    """Return sentences as one paragraph of lines that are not too long."""
    return textwrap.fill(" ".join(sentences), 120, break_long_words=False, break_on_hyphens=False)


def percent(value: float, error: float = 0.0, signed: bool = False) -> str:
    """Return a fraction in percent, with its standard error if that matters; below two of them, only a limit."""
    if not math.isfinite(value):
        return "-"
    size, width = 100.0 * value, 100.0 * error
    if abs(size) < _SURE * width:
        return f"< {_short(abs(size) + _SURE * width)}"
    shown = _short(size, "+" if signed else "")
    return f"{shown} ± {_short(width)}" if width >= 0.05 else shown


def points(value: float) -> str:
    """Return a fraction in percent with two decimals."""
    return f"{100.0 * value:.2f}" if math.isfinite(value) else "-"


def interval(low: float, high: float, most: float = math.inf) -> str:
    """Return a range in words; there is nothing above `most`."""
    if low <= 0.0:
        return f"below {high:g}"
    return f"{low:g} or more" if high >= most else f"{low:g} to {high:g}"


def title(name: str) -> str:
    """Return a method's name as code."""
    return f"`{name}`"


def _short(value: float, sign: str = "") -> str:
    if abs(value) >= 9.95:
        return f"{value:{sign}.0f}"
    return f"{value:{sign}.1f}" if abs(value) >= 0.095 else f"{value:{sign}.2f}"
