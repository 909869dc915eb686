"""Walks between nodes, and what they carry between cells of nodes: sparse matrices, counted from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

LEVELS = 6  # of distances; each is twice the one before


@dataclass
class Walks:
    """Walks between nodes.

    `start`, `end`: nodes; `length`: distance between the ends; `weight`, [channels, walks]: share of the light; `back`,
    `out`, [3, walks]: tangential directions outside at the start and at the end, times the memory of direction that is
    left.
    """

    start: NDArray
    end: NDArray
    length: NDArray
    weight: NDArray
    back: NDArray
    out: NDArray

    def chosen(self, which: NDArray) -> Walks:
        """Return some of them."""
        return Walks(*(values[..., which] for values in vars(self).values()))


@dataclass
class Cells:
    """A grid's cells: that of each node, and sums over the nodes of each.

    `shares`, [cells, 1 or channels]: of what kernels are relative to; `mass`: of what each cell takes of all nodes.
    """

    nearest: NDArray
    shares: NDArray
    mass: NDArray


def joined(parts: list[Walks]) -> Walks:
    """Return the walks of all parts."""
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return Walks(*(np.concatenate(column, axis=-1) for column in columns))


def levels(lengths: NDArray, free: float) -> NDArray:
    """Return the level of each length; `free`: the least mean free path."""
    level = np.ceil(np.log2(np.maximum(lengths, 1e-30) / (2.0 * free)))
    return np.clip(level, 0, LEVELS - 1).astype(int)


def kernels(
    walks: Walks, far: NDArray, cells: Cells, begun: NDArray, back: NDArray, out: NDArray
) -> list[Any]:  # fmt: skip
    """Return the kernels between cells, one a channel: per sum of `shares` here, and over the nodes there.

    Walks to places nearby are counted at their start; those that are `far` at both ends, as they are reciprocal. What
    goes between two nodes is then found by all that `begun` at either. `back`, `out`: directions at both ends,
    [components, walks].
    """
    mass = np.maximum(cells.mass, 1e-12)
    count, parts, returned = len(mass), 1 + len(back), np.flatnonzero(far)
    start, end = cells.nearest[walks.start], cells.nearest[walks.end]
    place = np.concatenate([start, end[returned]]) * count + np.concatenate([end, start[returned]])
    order = np.argsort(place)
    place = place[order]
    first = np.flatnonzero(np.diff(place, prepend=-1))
    row, column = np.divmod(place[first], count)
    scales = (1.0 / (np.maximum(cells.shares[row].T, 1e-12) * mass[column])).astype(np.float32)
    scales = np.broadcast_to(scales, (len(walks.weight), len(row)))
    found_by = begun[walks.start] + np.where(far, begun[walks.end], 0)
    weight = walks.weight / found_by.astype(np.float32)

    def sorted_(there: NDArray, here: NDArray) -> NDArray:
        return np.concatenate([there, here[returned]])[order]

    left = [sorted_(*both) for both in zip(back, out, strict=True)]
    right = [sorted_(*both) for both in zip(out, back, strict=True)]
    starts = np.searchsorted(row, np.arange(count + 1)).astype(np.int32)
    found = []
    for share, scale in zip(weight, scales, strict=True):
        values = np.zeros((len(first), parts, parts), np.float32)
        share = sorted_(share, share)
        for i in range(parts):
            seen = share * left[i - 1] if i else share
            for j in range(parts):
                if parts == 1 or i + j > 0:
                    brought = seen * right[j - 1] if j else seen
                    values[:, i, j] = np.add.reduceat(brought, first) * scale if len(first) else 0
        size = parts * count
        blocks = sparse.bsr_matrix((values, column.astype(np.int32), starts), shape=(size, size))
        found.append(blocks.tocsr())
    return found
