"""What a volume carries between nodes of its surface: sparse matrices, counted from walks.

Light that comes from afar is smooth: it varies over distances in proportion to the way that it has come. So walks are
sorted by the distance between their ends, and those of each level are counted between cells whose width is a share of
that distance: a few hundred thousand numbers instead of millions of walks, and less noise, while shadows in the light
from nearby keep their edges. How much scatters twice differs from node to node more than what comes of it does: so it
is divided by over the same cells. What walks remember of their directions is a correction of some per cent, and is
counted between wider cells.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import reduce
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from nephrite.transport.counted import Cells, Walks, kernels, levels
from nephrite.transport.frames import frames, turned, turning
from nephrite.transport.nodes import REACH, interpolation, smoothing, spread

MEANS = ((0, 1, 2), (3,), (4,), (5,))
"""Levels of distance whose walks are counted between the cells of each grid: the nodes, cells of 2, 4, 8 spacings."""

MOMENTS = ((), (), (0, 1, 2), (3, 4, 5))
"""The same for what is remembered of directions; one grid finer on objects of fewer than `FEW` nodes."""

FEW = 10_000

GRIDS = len(MEANS)
AROUND = 2  # grids coarser: how far off neighbours are that should get as much in even light
EVENED = GRIDS - AROUND
COARSE = GRIDS - 1  # grid for light that has been scattered by several surfaces
_LEAST_SHARE = 0.1  # of the mean of all nodes: below, noise would be divided by it
_SMOOTHINGS = 3  # of shares: all that is looked up is divided by them
_AT_ONCE = 2  # matrices that are counted side by side: each needs copies of its walks


class Pyramid:
    """The operator T of one surface.

    `ups`: from each grid's cells to those of the grid before; `facing`: normals of the nodes, and of each grid's cells;
    `means`, `moments`: for each grid, None or the kernels between its cells, one a channel. Kernels of means are
    [cells, cells]; those of moments, [3 cells, 3 cells], take a mean and a tangential vector (see `frames`) to such,
    but no mean to a mean. The kernels of a grid have their entries in the same places.
    """

    def __init__(
        self, ups: list[Any], facing: list[NDArray], means: list[Any], moments: list[Any], smooth: Any
    ) -> None:
        """Hold the matrices; `smooth` takes the noise of single nodes out of their means."""
        self.ups, self.facing, self.means, self.moments, self.smooth = ups, facing, means, moments, smooth
        self._frames = frames(facing[0]).astype(np.float32)
        self._turns = [turning(up, *both) for up, both in zip(ups, pairwise(facing), strict=True)]
        self._back_turns = [turn.T.tocsr() for turn in self._turns]
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
    def of(
        cls,
        points: NDArray,
        normals: NDArray,
        spacing: float,
        free: float,
        walks: Walks,
        begun: NDArray,
        second: NDArray | None = None,
    ) -> Pyramid:
        """Count `walks`, of which so many have `begun` at each node.

        Nodes are at `points`, with `normals`, and keep the distance `spacing`; `free`: the least mean free path. With
        `second`, the share of light that scatters twice, [nodes, channels], T is relative to it: what is seen for all
        of the light that does.
        """
        level = levels(walks.length, free)
        with ThreadPoolExecutor(1) as beside:
            smoothed = beside.submit(smoothing, points, normals, spacing)
            ups, facing = _grids(points, normals, spacing)
            smooth = smoothed.result()
        shares = np.ones((len(points), 1)) if second is None else _without_noise(second, smooth)
        cells = [Cells(np.arange(len(points)), shares, np.ones(len(points)))]
        for up in ups:
            nearest = np.asarray(up.argmax(axis=1)).ravel()[cells[-1].nearest]
            sums = [np.bincount(nearest, channel, up.shape[1]) for channel in shares.T]
            cells.append(Cells(nearest, np.stack(sums, axis=1), up.T @ cells[-1].mass))

        def counted(grid: int, chosen_levels: tuple[int, ...], directed: bool) -> list[Any] | None:
            if not chosen_levels:
                return None
            chosen = np.flatnonzero(np.isin(level, chosen_levels))
            known = walks if directed else replace(walks, back=walks.back[:0], out=walks.out[:0])
            own, far = known.chosen(chosen), level[chosen] > 0
            ends = [own.back, own.out]
            if directed:
                turns = turned(facing[grid][cells[grid].nearest], normals).astype(np.float32)
                ends = [
                    np.einsum("nkj,jn->kn", turns[node], direction)
                    for node, direction in ((own.start, own.back), (own.end, own.out))
                ]
            return kernels(own, far, cells[grid], begun, *ends)

        remembered = (*MOMENTS[1:], ()) if len(points) < FEW else MOMENTS
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            means = [pool.submit(counted, grid, MEANS[grid], False) for grid in range(GRIDS)]
            moments = [pool.submit(counted, grid, remembered[grid], True) for grid in range(GRIDS)]
        return cls(ups, facing, [one.result() for one in means], [one.result() for one in moments], smooth)

    def apply(self, arriving: NDArray) -> NDArray:
        """Return what is seen at the nodes, [nodes, 4, channels], of what arrives there.

        Both are a mean over directions, and one for each axis, of what is in proportion to the direction.
        """
        return np.stack([self.channel(arriving[:, :, c], c) for c in range(arriving.shape[2])], axis=2)

    def channel(self, arriving: NDArray, channel: int) -> NDArray:
        """Return the same for one channel: [nodes, 4] of [nodes, 4]."""
        given = [np.ascontiguousarray(arriving[:, 0], np.float32)]
        vectors = [np.einsum("nkj,nj->nk", self._frames, arriving[:, 1:]).astype(np.float32)]
        for down, back in zip(self._downs, self._back_turns, strict=True):
            given.append(down @ given[-1])
            vectors.append((back @ vectors[-1].ravel()).reshape(-1, 2))
        found = [np.zeros((len(values), 3), np.float32) for values in given]
        for grid, values in enumerate(given):
            if self.means[grid]:
                found[grid][:, 0] = self.means[grid][channel] @ values
            if self.moments[grid]:
                both = np.column_stack([values, vectors[grid]]).ravel()
                found[grid] += (self.moments[grid][channel] @ both).reshape(-1, 3)
        for grid, excess in enumerate(self._excess):
            around = given[grid + AROUND] / self._mass[grid + AROUND]
            found[grid][:, 0] -= excess[channel] * self._finer(around, grid + AROUND, grid)
        for grid in range(GRIDS - 1, 0, -1):
            up, turn = self.ups[grid - 1], self._turns[grid - 1]
            found[grid - 1][:, 0] += up @ np.ascontiguousarray(found[grid][:, 0])
            found[grid - 1][:, 1:] += (turn @ found[grid][:, 1:].ravel()).reshape(-1, 2)
        mean = self.smooth @ np.ascontiguousarray(found[0][:, 0])
        return np.column_stack([mean, np.einsum("nkj,nk->nj", self._frames, found[0][:, 1:])])

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


def _grids(points: NDArray, normals: NDArray, spacing: float) -> tuple[list[Any], list[NDArray]]:
    """Return `ups` and `facing` of a `Pyramid`."""
    ups, facing = [], [normals]
    for grid in range(1, GRIDS):
        width = 2**grid * spacing
        centres = spread(points, facing[-1], width)
        ups.append(interpolation(points, facing[-1], points[centres], facing[-1][centres], REACH * width))
        points = points[centres]
        facing.append(facing[-1][centres])
    return ups, facing


def _without_noise(shares: NDArray, smooth: Any) -> NDArray:
    least = np.maximum(_LEAST_SHARE * np.mean(shares, axis=0), 1e-12)  # a channel may not scatter at all
    for _ in range(_SMOOTHINGS):
        shares = smooth @ shares
    return np.maximum(shares, least)


def averaging(up: Any) -> Any:
    """Return the matrix that averages nodes over cells, for one that interpolates between the cells."""
    return sparse.diags(1.0 / np.maximum(np.asarray(up.sum(axis=0)).ravel(), 1e-12)) @ up.T
