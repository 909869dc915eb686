"""Points of low discrepancy that stay the same from frame to frame: pictures differ only by what has changed."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.plugins import sequence

STEPS = np.array(sequence.steps(2))

TILE = 4  # pixels: each of a tile's has another point of the sequence
_ORDER = np.array(
    [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]]
)  # of a tile's pixels (Bayer)


class Sequence:
    """One point of the sequence for each lane, and further ones for the turns to come."""

    def __init__(self, index: NDArray, period: int) -> None:
        """Lane i has point `index[i]`, and `period` more each turn."""
        first = (0.5 + index[:, None] * STEPS) % 1.0
        self._first = mi.Point2f(first.T.astype(np.float32))
        self._period = period
        dr.eval(self._first)

    def __call__(self, turn: int) -> Any:
        """Return the points of a turn."""
        x, y = (turn * self._period * STEPS) % 1.0
        # opaque: the same kernel serves all turns
        u = self._first + mi.Point2f(dr.opaque(mi.Float, float(x)), dr.opaque(mi.Float, float(y)))
        return u - dr.floor(u)


def along(count: int) -> Sequence:
    """Return a sequence for lanes that are neighbours in their order."""
    return Sequence(np.arange(count), count)


def over_pixels(x: NDArray, y: NDArray) -> Sequence:
    """Return a sequence for pixels: any square of `TILE` x `TILE` neighbours has its first points."""
    return Sequence(_ORDER[y % TILE, x % TILE], TILE * TILE)
