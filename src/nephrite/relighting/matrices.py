"""Sparse matrices that differ between channels in their values alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Entries = tuple[NDArray, NDArray, NDArray]
"""Rows, columns, and values, [n, channels]."""


def of_entries(parts: list[Entries], shape: tuple[int, int]) -> list[Any]:
    """Return one matrix a channel, of entries whose sums count; they share the places of their values."""
    if not parts:
        return [sparse.csr_matrix(shape, dtype=np.float32)] * 3
    row, column, values = (np.concatenate(part) for part in zip(*parts, strict=True))
    found = [sparse.csr_matrix((v.astype(np.float32), (row, column)), shape=shape) for v in values.T]
    for matrix in found[1:]:
        matrix.indices, matrix.indptr = found[0].indices, found[0].indptr
    return found


def beside(*matrices: Any) -> Any:
    """Return one matrix for several with the same rows: it takes what they take, one after the other."""
    return sparse.hstack(matrices, "csr", dtype=np.float32)


def thinned(matrices: list[Any], dropped: float) -> list[Any]:
    """Return matrices, whose entries are in the same places, without the least entries of each row.

    What is left out adds up to no more than a share `dropped` of the row in any of the matrices; the others grow by
    as much, so that the sum of each row stays. No entry is negative.
    """
    first = matrices[0]
    row = np.repeat(np.arange(first.shape[0]), np.diff(first.indptr))
    sums = [np.bincount(row, matrix.data, first.shape[0]) for matrix in matrices]
    shares = np.max([m.data / np.maximum(s, 1e-30)[row] for m, s in zip(matrices, sums, strict=True)], axis=0)
    order = np.lexsort((shares, row))
    before = np.concatenate([[0.0], np.cumsum(shares[order])])
    kept = np.sort(order[before[1:] - before[first.indptr[row]] > dropped])
    row = row[kept]
    found = []
    for matrix, total in zip(matrices, sums, strict=True):
        left = np.bincount(row, matrix.data[kept], first.shape[0])
        values = matrix.data[kept] * (total / np.maximum(left, 1e-30))[row]
        indptr = np.searchsorted(row, np.arange(first.shape[0] + 1)).astype(np.int32)
        found.append(
            sparse.csr_matrix((values.astype(np.float32), first.indices[kept], indptr), shape=first.shape)
        )
    return found
