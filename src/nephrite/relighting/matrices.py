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
