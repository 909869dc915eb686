"""Sequences of low discrepancy: numbers that fill their range more evenly than by chance.

The paths of a pixel draw what they do first from one, moved by random numbers of the pixel's own (a Kronecker sequence,
Cranley-Patterson rotated). It pays most where little else is random, as with precomputed transport; of walks, it is
which colour channel leads them that is worth its dimension.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

# what paths do first: two dimensions, one, one, one, two
POSITION, INTERFACE, LEADER, FREE_PATH, TURN = 0, 2, 3, 4, 5
STEP = (FREE_PATH, TURN, TURN + 1)
_DIMENSIONS = 7


def steps(dimensions: int) -> list[float]:
    """Return by how much each dimension of the R sequence grows from point to point, modulo 1 (Roberts 2018)."""
    root = 1.0
    for _ in range(64):  # to x^(d + 1) = x + 1; the error is at least halved each time
        root = (1.0 + root) ** (1.0 / (dimensions + 1))
    return [root**-k for k in range(1, dimensions + 1)]


class OfPixels:
    """A sequence for the paths of each `pixel`, which lanes share: each has every `turns`-th, beginning with `turn`."""

    def __init__(self, pixel: Any, turn: Any, turns: Any, seed: int) -> None:
        """Draw the numbers that move it."""
        own: Any = dr.opaque(mi.UInt32, seed) * _DIMENSIONS
        self.turn, self.turns = turn, turns
        self._moved = [mi.sample_tea_32(pixel, own + i)[0] for i in range(_DIMENSIONS)]
        self._steps = [round(2**32 * step) for step in steps(_DIMENSIONS)]
        dr.eval(self._moved)

    def __call__(self, dimension: int, path: Any, otherwise: Any, first: Any = True) -> Any:
        """Return a number for each lane's `path` where it is the `first` of that `dimension`, and `otherwise` else."""
        index = self.turn + self.turns * path
        bits = self._moved[dimension] + index * self._steps[dimension]  # modulo 2^32
        return dr.select(first, mi.Float(bits >> 8) * 2.0**-24, otherwise)


def of_one(seed: int) -> OfPixels:
    """Return a sequence in which every path has its own place: that of a single pixel."""
    return OfPixels(mi.UInt32(0), 0, 1, seed)
