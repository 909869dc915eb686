"""Tangential vectors on a surface, by two components each, and how they turn where the surface does.

Each point has a frame of two tangents. A vector goes from one point to another by the least rotation that takes the
one normal to the other, so that means over a curved surface lose none of its length.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse


def frames(normals: NDArray) -> NDArray:
    """Return two unit tangents for each of `normals`, [n, 2, 3] (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return np.stack([first, np.stack([b, sign + y * y * a, -y], axis=1)], axis=1)


def turned(normals: NDArray, to: NDArray) -> NDArray:
    """Return the frames at `normals`, turned to where the normals are `to`, [n, 2, 3].

    Their products with a vector there are its components when it is turned here.
    """
    own = frames(normals)
    along = (
        np.einsum("nkj,nj->nk", own, to) / np.maximum(1.0 + np.einsum("nj,nj->n", normals, to), 1e-3)[:, None]
    )
    return own - along[:, :, None] * (normals + to)[:, None]


def turning(up: Any, fine: NDArray, coarse: NDArray) -> Any:
    """Return the matrix [fine, coarse] that does with vectors what `up` does with values.

    Vectors are complex numbers here, of two components in the frames: then a turn is one factor, not four.
    `fine`, `coarse`: normals of the points that it leads to, and from.
    """
    row = np.repeat(np.arange(up.shape[0]), np.diff(up.indptr))
    there = turned(coarse[up.indices], fine[row])[:, 0]
    real, imaginary = np.einsum("nkj,nj->kn", frames(fine)[row], there)
    factors = (up.data * (real + 1j * imaginary)).astype(np.complex64)
    return sparse.csr_matrix((factors, up.indices, up.indptr), shape=up.shape)
