"""What was asked of speed on scene B1, and which ratios tell it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks import analysis

SCENE = "b1"
METHOD, MOST_BIAS, MOST_IN_BLOCK = "transport", 0.02, 0.05
"""The method whose bias was asked for, and its limits: in the mean, and in the worst block."""


@dataclass(frozen=True)
class Asked:
    """How many times better one method is to be than another: by efficiency, or by the time to `analysis.GOAL`."""

    method: str
    other: str
    by_efficiency: bool
    least: float

    def measured(self, numbers: Mapping[str, dict[str, Any]]) -> analysis.Spread | None:
        """Return the ratio, of summaries by the methods' names; None where one is missing, or never gets there.

        The other's bias is not counted against it: its time is that in which its noise falls to the goal.
        """
        if self.method not in numbers or self.other not in numbers:
            return None
        own, other = numbers[self.method], numbers[self.other]
        if self.by_efficiency:
            return analysis.ratio(own["efficiency"], other["efficiency"])
        return analysis.ratio(other["quiet"], own["goal"])


ASKED = (
    Asked("walk", "cycles", True, 2.0),
    Asked(METHOD, "cycles", True, 10.0),
    Asked(METHOD, "cycles", False, 10.0),
    Asked(METHOD, "volpathmis", True, 1000.0),
    Asked(METHOD, "volpathmis", False, 1000.0),
)
