"""The operator that walks make, stored as sparse matrices: it takes what arrives at nodes to what is seen there.

Light that comes from afar is smooth (see `nephrite.transport.carried`). So walks are sorted by the distance between
their ends, and those of each level are counted between cells whose width is a share of that distance: a few hundred
thousand numbers instead of millions of walks. What walks remember of their directions is a correction of some per
cent, and is counted between wider cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from nephrite.transport.nodes import REACH, interpolation, smoothing, spread

MEANS = ((0, 1, 2), (3,), (4,), (5,))
"""Levels of distance whose walks are counted between the cells of each grid: the nodes, cells of 2, 4, 8 spacings."""

MOMENTS = ((), (), (0, 1, 2), (3, 4, 5))
"""The same for what is remembered of directions."""

GRIDS = len(MEANS)
AROUND = 2  # grids coarser: how far off neighbours are that should get as much in even light
EVENED = GRIDS - AROUND
COARSE = GRIDS - 1  # grid for light that has been scattered by several surfaces


@dataclass
class Ends:
    """Walks as plain arrays: see `nephrite.transport.carried.Walks`; `level`: of their length."""

    start: NDArray
    end: NDArray
    weight: NDArray
    out: NDArray
    back: NDArray
    level: NDArray

    def both_ways(self, levels: Sequence[int], each: int) -> tuple[NDArray, ...]:
        """Return (here, there, share, back, out): walks of some levels, reciprocally, as shares of `each` a node.

        Walks to places nearby are counted at their start; all others at both ends.
        """
        chosen = np.isin(self.level, levels) & (self.weight.max(axis=1) > 0)
        far = chosen & (self.level > 0)
        share = np.where(self.level > 0, 0.5, 1.0)[:, None] / each * self.weight
        return tuple(
            np.concatenate([first[chosen], second[far]])
            for first, second in (
                (self.start, self.end), (self.end, self.start), (share, share), (self.back, self.out),
                (self.out, self.back),
            )
        )  # fmt: skip


class Pyramid:
    """The operator T of one surface.

    `ups`: from each grid's cells to those of the grid before; `means`, `moments`: for each grid, None or the kernels
    between its cells, one a channel. Kernels of means are [cells, cells]; those of moments, [4 cells, 4 cells], take a
    mean and three moments to such, but no mean to a mean. The kernels of a grid have their entries in the same places.
    """

    def __init__(self, ups: list[Any], means: list[Any], moments: list[Any], smooth: Any) -> None:
        """Hold the matrices; `smooth` takes the noise of single nodes out of their means."""
        self.ups, self.means, self.moments, self.smooth = ups, means, moments, smooth
        self._downs = [up.T.tocsr() for up in ups]
        self._mass = [np.ones(smooth.shape[0], np.float32)]
        for down in self._downs:
            self._mass.append(np.maximum(down @ self._mass[-1], 1e-12))
        self._excess = [self._noise(grid) for grid in range(EVENED)]

    def _noise(self, grid: int) -> list[NDArray]:
        """Return how much more, or less, walks bring to each cell in even light than they do around, a channel each."""
        found = []
        for kernel in self.means[grid]:
            sums = kernel @ self._mass[grid]
            around = sums * self._mass[grid]
            for down in self._downs[grid : grid + AROUND]:
                around = down @ around
            found.append(sums - self._finer(around / self._mass[grid + AROUND], grid + AROUND, grid))
        return found

    def _finer(self, values: NDArray, grid: int, to: int) -> NDArray:
        for up in self.ups[to:grid][::-1]:
            values = up @ values
        return values

    @classmethod
    def of(cls, points: NDArray, normals: NDArray, spacing: float, walks: Ends, each: int) -> Pyramid:
        """Count `walks` between nodes, at `points` with `normals`, which keep the distance `spacing`."""
        ups, means, moments = [], [], []
        p, n, cell = points, normals, np.arange(len(points))
        for grid in range(GRIDS):
            if grid:
                width = 2**grid * spacing
                centres = spread(p, n, width)
                up = interpolation(p, n, p[centres], n[centres], REACH * width)
                p, n, cell = p[centres], n[centres], np.asarray(up.argmax(axis=1)).ravel()[cell]
                ups.append(up)
            for kernels, levels, parts in ((means, MEANS, 1), (moments, MOMENTS, 4)):
                counted = walks.both_ways(levels[grid], each) if levels[grid] else None
                kernels.append(_kernels(ups, cell, len(p), counted, parts) if counted else None)
        return cls(ups, means, moments, smoothing(points, normals, spacing))

    def apply(self, arriving: NDArray) -> NDArray:
        """Return what is seen at the nodes, [nodes, 4, channels], of what arrives there.

        Both are a mean over directions, and one for each axis, of what is in proportion to the direction.
        """
        return np.stack([self.channel(arriving[:, :, c], c) for c in range(arriving.shape[2])], axis=2)

    def channel(self, arriving: NDArray, channel: int) -> NDArray:
        """Return the same for one channel: [nodes, 4] of [nodes, 4]."""
        given = [np.ascontiguousarray(arriving, np.float32)]
        for down in self._downs:
            given.append(down @ given[-1])
        found = [np.zeros_like(values) for values in given]
        for grid, values in enumerate(given):
            if self.means[grid]:
                found[grid][:, 0] = self.means[grid][channel] @ np.ascontiguousarray(values[:, 0])
            if self.moments[grid]:
                found[grid] += (self.moments[grid][channel] @ values.ravel()).reshape(-1, 4)
        for grid, excess in enumerate(self._excess):
            local = given[grid + AROUND][:, 0] / self._mass[grid + AROUND]
            found[grid][:, 0] -= excess[channel] * self._finer(local, grid + AROUND, grid)
        for grid in range(GRIDS - 1, 0, -1):
            found[grid - 1] += self.ups[grid - 1] @ found[grid]
        found[0][:, 0] = self.smooth @ np.ascontiguousarray(found[0][:, 0])
        return found[0]

    def averaged(self, values: NDArray) -> NDArray:
        """Return means over the cells of the grid `COARSE`, of values at the nodes."""
        for down in self._downs:
            values = down @ values
        return values / self._mass[COARSE]

    def interpolated(self, values: NDArray) -> NDArray:
        """Return values at the nodes, of such at the cells of the grid `COARSE`."""
        return self._finer(values, COARSE, 0)

    def up(self, grid: int) -> Any:
        """Return the matrix from a grid's cells to the nodes."""
        return reduce(lambda a, b: a @ b, self.ups[:grid])

    def coarse(self) -> list[NDArray]:
        """Return dense matrices, one a channel, of the means alone, between the cells of the grid `COARSE`.

        What arrives is taken to be interpolated between them; what is seen is averaged.
        """
        up = self.up(COARSE)
        down = averaging(up)
        found = []
        for channel in range(len(self.means[0])):
            total = down @ self.means[0][channel] @ up
            for grid in range(1, GRIDS):
                fine = self.up(grid)
                total = total + (down @ fine) @ self.means[grid][channel] @ (fine.T @ up)
            found.append(total.toarray())
        return found


def averaging(up: Any) -> Any:
    """Return the matrix that averages nodes over cells, for one that interpolates between the cells."""
    return sparse.diags(1.0 / np.maximum(np.asarray(up.sum(axis=0)).ravel(), 1e-12)) @ up.T


def _kernels(ups: list[Any], cell: NDArray, count: int, walks: tuple[NDArray, ...], parts: int) -> list[Any]:
    """Return the kernels between `count` cells: per node here, and per sum over the nodes there."""
    here, there, share, back, out = walks
    nodes = np.maximum(np.bincount(cell, minlength=count), 1)
    mass = np.ones(len(cell))
    for up in ups:
        mass = up.T @ mass
    pairs, index = np.unique(cell[here].astype(np.int64) * count + cell[there], return_inverse=True)
    row, column = pairs // count, pairs % count
    scale = 1.0 / (nodes[row] * np.maximum(mass, 1e-12)[column])
    left, right = (np.concatenate([np.ones((len(v), 1)), v], axis=1) for v in (back, out))
    blocks = [(i, j) for i in range(parts) for j in range(parts) if parts == 1 or i + j > 0]
    rows = np.concatenate([parts * row + i for i, _ in blocks])
    columns = np.concatenate([parts * column + j for _, j in blocks])
    order = np.lexsort((columns, rows))
    starts = np.searchsorted(rows[order], np.arange(parts * count + 1)).astype(np.int32)
    columns = columns[order].astype(np.int32)
    kernels = []
    for channel in range(share.shape[1]):
        sums = [
            scale * np.bincount(index, share[:, channel] * left[:, i] * right[:, j], len(pairs))
            for i, j in blocks
        ]
        values = np.concatenate(sums)[order].astype(np.float32)
        kernels.append(sparse.csr_matrix((values, columns, starts), shape=(parts * count,) * 2))
    return kernels
