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
from nephrite.transport.grids import GRIDS, Grids

MEANS = ((0, 1, 2), (3,), (4,), (5,))
"""Levels of distance whose walks are counted between the cells of each grid: see `grids`."""

MOMENTS = ((), (), (0, 1, 2), (3, 4, 5))
"""The same for what is remembered of directions; one grid finer on objects of fewer than `FEW` nodes."""

FEW = 10_000

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
        self._frames = np.ascontiguousarray(np.einsum("nkj,k->jn", frames(facing[0]), [1, 1j]), np.complex64)
        self._turns = [turning(up, *both) for up, both in zip(ups, pairwise(facing), strict=True)]
        self._back_turns = [turn.conj().T.tocsr() for turn in self._turns]
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
        cls, grids: Grids, free: float, walks: Walks, begun: NDArray, second: NDArray | None = None
    ) -> Pyramid:  # fmt: skip
        """Count `walks`, of which so many have `begun` at each node.

        `free`: the least mean free path. With `second`, the share of light that scatters twice, [nodes, channels], T is
        relative to it: what is seen for all of the light that does.
        """
        level, normals = levels(walks.length, free), grids.facing[0]
        shares = np.ones((len(normals), 1)) if second is None else _without_noise(second, grids.smooth)
        cells = [Cells(grids.nearest[0], shares, np.ones(len(normals)))]
        for up, nearest in zip(grids.ups, grids.nearest[1:], strict=True):
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
                turns = turned(grids.facing[grid][grids.nearest[grid]], normals).astype(np.float32)
                ends = [
                    np.einsum("nkj,jn->kn", turns[node], direction)
                    for node, direction in ((own.start, own.back), (own.end, own.out))
                ]
            return kernels(own, far, cells[grid], begun, *ends)

        remembered = (*MOMENTS[1:], ()) if len(normals) < FEW else MOMENTS
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            means = [pool.submit(counted, grid, MEANS[grid], False) for grid in range(GRIDS)]
            moments = [pool.submit(counted, grid, remembered[grid], True) for grid in range(GRIDS)]
        return cls(
            grids.ups,
            grids.facing,
            [one.result() for one in means],
            [one.result() for one in moments],
            grids.smooth,
        )

    def apply(self, arriving: NDArray) -> NDArray:
        """Return what is seen at the nodes, [nodes, 4, channels], of what arrives there.

        Both are a mean over directions, and one for each axis, of what is in proportion to the direction.
        """
        return np.stack([self.channel(arriving[:, :, c], c) for c in range(arriving.shape[2])], axis=2)

    def channel(self, arriving: NDArray, channel: int) -> NDArray:
        """Return the same for one channel: [nodes, 4] of [nodes, 4]."""
        mean, vectors = self.carried(arriving[:, 0], self.tangential(arriving[:, 1:].T), channel)
        return np.stack([mean, *np.real(np.conj(self._frames) * vectors)], axis=1)

    def tangential(self, vectors: NDArray) -> NDArray:
        """Return what is tangential at the nodes of vectors, [3, nodes], as complex numbers (see `frames.turning`)."""
        found = np.zeros(self._frames.shape[1], np.complex64)
        for axis, values in zip(self._frames, vectors, strict=True):
            found += axis * np.asarray(values, np.float32)
        return found

    def carried(self, mean: NDArray, vectors: NDArray, channel: int) -> tuple[NDArray, NDArray]:
        """Return what is seen at the nodes in one channel, of what arrives: a mean, and tangential vectors."""
        given, turned_to = [np.ascontiguousarray(mean, np.float32)], [vectors]
        for down, back in zip(self._downs, self._back_turns, strict=True):
            given.append(down @ given[-1])
            turned_to.append(back @ turned_to[-1])
        found, directed = np.zeros(0, np.float32), np.zeros(0, np.complex64)
        for grid in reversed(range(GRIDS)):  # what the coarser ones bring is handed on to the finer
            coarser = grid < COARSE
            found = self.ups[grid] @ found if coarser else np.zeros_like(given[grid])
            directed = self._turns[grid] @ directed if coarser else np.zeros_like(turned_to[grid])
            if self.means[grid]:
                found += self.means[grid][channel] @ given[grid]
            if self.moments[grid]:
                both = np.empty((len(found), 3), np.float32)
                both[:, 0], both[:, 1:] = given[grid], _components(turned_to[grid])
                sums = (self.moments[grid][channel] @ both.ravel()).reshape(-1, 3)
                found += sums[:, 0]
                _components(directed)[:] += sums[:, 1:]
            if grid < EVENED:
                around = given[grid + AROUND] / self._mass[grid + AROUND]
                found -= self._excess[grid][channel] * self._finer(around, grid + AROUND, grid)
        return self.smooth @ found, directed

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


def _without_noise(shares: NDArray, smooth: Any) -> NDArray:
    least = np.maximum(_LEAST_SHARE * np.mean(shares, axis=0), 1e-12)  # a channel may not scatter at all
    for _ in range(_SMOOTHINGS):
        shares = smooth @ shares
    return np.maximum(shares, least)


def _components(vectors: NDArray) -> NDArray:
    """Return the two components of complex numbers, [n, 2], in the same memory."""
    return vectors.view(np.float32).reshape(-1, 2)


def averaging(up: Any) -> Any:
    """Return the matrix that averages nodes over cells, for one that interpolates between the cells."""
    return sparse.diags(1.0 / np.maximum(np.asarray(up.sum(axis=0)).ravel(), 1e-12)) @ up.T
