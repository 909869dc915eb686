"""What a volume carries between nodes of its surface: sums over walks, each as smooth as its walks are long.

Light that comes from afar is smooth: it varies over distances in proportion to the way that it has come. So walks are
sorted by the distance between their ends, and what they bring is averaged over neighbours that lie apart by no more
than a share of it. That takes out noise, and leaves the edges of shadows in the light from nearby.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.transport.nodes import smoothing
from nephrite.transport.pyramid import Ends

BLUR = 0.2  # width of the mean of what walks bring, per least distance between their ends
EVEN = 0.4  # width of the mean of how much walks bring in even light, per greatest distance
STEP = 1.0  # width of a single mean over neighbours, in spacings
MOST_STEPS = 40
LEVELS = 6  # of distances; each is twice the one before


@dataclass
class Walks:
    """Walks between nodes, as arrays of Dr.Jit.

    `start`, `end`: nodes; `length`: distance between the ends; `weight`: share of the light, per channel; `out`,
    `back`: tangential directions outside at the end and at the start, times the memory of direction that is left.
    """

    start: Any
    end: Any
    length: Any
    weight: Any
    out: Any
    back: Any


class Carried:
    """The operator T of one surface, which takes what arrives at the nodes to what is seen there."""

    def __init__(self, points: NDArray, normals: NDArray, spacing: float, free: float, each: int) -> None:
        """Begin without walks; `free`: the least mean free path; `each`: how many walks start at a node."""
        self.nodes, self.each = len(points), each
        self._nearest = 2.0 * free
        greatest = self._nearest * 2.0 ** np.arange(LEVELS)
        least = np.concatenate([[0.0], greatest[:-1]])
        self._blurs, self._evens = (
            np.diff(np.minimum(np.rint((width / (STEP * spacing)) ** 2), MOST_STEPS).astype(int), prepend=0)
            for width in (np.maximum(BLUR * least, STEP * spacing), EVEN * greatest)
        )
        self._smooth = smoothing(points, normals, STEP * spacing)
        self._walks: list[tuple[Walks, Any]] = []

    def add(self, walks: Walks) -> None:
        """Take more walks."""
        level = dr.ceil(dr.log2(dr.maximum(walks.length, 1e-30) / self._nearest))
        level = mi.UInt32(dr.clip(level, 0, LEVELS - 1))
        dr.eval(walks.start, walks.end, walks.weight, walks.out, walks.back, level)
        self._walks.append((walks, level))

    def ends(self) -> Ends:
        """Return all walks as plain arrays."""
        parts = [
            (walks.start, walks.end, walks.weight, walks.out, walks.back, level)
            for walks, level in self._walks
        ]
        return Ends(*(np.concatenate([np.array(x).T for x in part]) for part in zip(*parts, strict=True)))

    def finish(self) -> None:
        """Find how much more, or less, walks bring in even light than they do around."""
        self._excess = []
        for k in range(4):
            unit = [mi.Spectrum(float(i == k)) for i in range(4)]
            sums = self._sums([dr.zeros(mi.Spectrum, self.nodes) + one for one in unit])
            around = [self._smoothed(one, n) for one, n in zip(sums, np.cumsum(self._evens), strict=True)]
            self._excess.append(sums - np.stack(around))

    def apply(self, arriving: list[Any]) -> NDArray:
        """Return what is seen at the nodes, [nodes, 4, channels], of what arrives there: see `Walks`.

        Both are a mean over directions, and one for each axis, of what is in proportion to the direction.
        """
        local = np.stack([np.array(one).T for one in arriving], axis=1)
        sums = self._sums(arriving)
        for level, steps in enumerate(self._evens):
            local = self._smoothed(local, steps)
            for k in range(4):
                sums[level] -= self._excess[k][level] * local[:, None, k]
        found = np.zeros_like(sums[0])
        for values, steps in zip(sums[::-1], self._blurs[::-1], strict=True):
            found = self._smoothed(found + values, steps)
        return found

    def _sums(self, arriving: list[Any]) -> NDArray:
        """Return sums over walks, [levels, nodes, 4, channels].

        Walks to places nearby are counted at their start; all others at both ends, as they are reciprocal.
        """
        totals = [dr.zeros(mi.Spectrum, self.nodes * LEVELS) for _ in range(4)]
        for walks, level in self._walks:
            share = dr.select(level > 0, mi.Float(0.5), 1.0) / self.each * walks.weight
            used = dr.max(walks.weight) > 0
            for here, there, back, out, active in (
                (walks.start, walks.end, walks.back, walks.out, used),
                (walks.end, walks.start, walks.out, walks.back, used & (level > 0)),
            ):
                found = share * _seen(arriving, there, out)
                for total, factor in zip(totals, (mi.Float(1), *back), strict=True):
                    dr.scatter_add(total, found * factor, level * self.nodes + here, active)
        dr.eval(totals)
        return np.stack([np.array(total).T.reshape(LEVELS, self.nodes, -1) for total in totals], axis=2)

    def _smoothed(self, values: NDArray, steps: int) -> NDArray:
        flat = values.reshape(self.nodes, -1)
        for _ in range(steps):
            flat = self._smooth @ flat
        return flat.reshape(values.shape)


def _seen(arriving: list[Any], node: Any, direction: Any) -> Any:
    mean, *moments = arriving
    result = dr.gather(mi.Spectrum, mean, node)
    for moment, component in zip(moments, direction, strict=True):
        result += component * dr.gather(mi.Spectrum, moment, node)
    return result
