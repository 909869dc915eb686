"""Nodes: points spread evenly over a surface, and which of them are neighbours on the same side of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

DENSITY = 0.7
"""Nodes per squared spacing that `spread` leaves, about."""

REACH = 1.75
"""How far points look for nodes, in spacings."""

_STEEP = 4.0
"""How much more distances count along the normals than across them. A lip and the chin below it face the same way, and
are near each other, but not to the light; and where a surface is curved, neighbours are fewer."""

_FIRST = 0.25  # of all points: those that `spread` compares with each other
_BALANCING = 30  # rounds of scaling; errors are below 1e-5 then
_MOST_NEAR = 24  # nodes that a point looks at: about as many as lie within reach on both sides of a thin part
_FAR_SIDE = 1e-6  # weight of nodes that face away
_NEAREST = 1e-12  # weight of the nearest node, where no other counts


def squared_distance(offset: NDArray, normal: NDArray, other: NDArray) -> NDArray:
    """Return how far apart points are, squared, for the offset between them, [..., 3], and their normals."""
    along = np.maximum(*(np.abs(np.einsum("...j,...j->...", offset, n)) for n in (normal, other)))
    return np.einsum("...j,...j->...", offset, offset) + np.square(_STEEP * along)


def spread(points: NDArray, normals: NDArray, spacing: float, seed: int = 0) -> NDArray[np.int64]:
    """Return indices of `points`, [n, 3], no two of which are closer than `spacing`; none more could be added.

    Distances are those of `squared_distance`. A maximal independent set: a point stays unless it has a neighbour that
    stays and comes before it in a random order. Points whose normals face away from each other, as on both sides of a
    leaf, are no neighbours. Most points have a neighbour among the first ones that stay, and need be compared with no
    others.
    """
    order = np.random.default_rng(seed).permutation(len(points))
    first, others = np.split(order, [int(_FIRST * len(order))])
    kept = first[_first_to_stay(points[first], normals[first], spacing)]
    trees = KDTree(points[kept]), KDTree(points[others])
    near = trees[0].sparse_distance_matrix(trees[1], spacing, output_type="ndarray")
    beaten = near["j"][_neighbours(points, normals, kept[near["i"]], others[near["j"]], spacing)]
    others = np.delete(others, beaten)
    return np.sort(np.concatenate([kept, others[_first_to_stay(points[others], normals[others], spacing)]]))


def _neighbours(points: NDArray, normals: NDArray, a: NDArray, b: NDArray, spacing: float) -> NDArray:
    """Return which pairs of points are nearer than `spacing`, and face the same way."""
    near = squared_distance(points[a] - points[b], normals[a], normals[b]) < spacing**2
    return near & (np.einsum("ij,ij->i", normals[a], normals[b]) > 0)


def _first_to_stay(points: NDArray, normals: NDArray, spacing: float) -> NDArray:
    """Return which points stay, in the order that they have: found in rounds for all at once (Luby 1986)."""
    kept = np.zeros(len(points), bool)
    undecided = ~kept
    pairs = np.sort(KDTree(points).query_pairs(spacing, output_type="ndarray"), axis=1)
    pairs = pairs[_neighbours(points, normals, *pairs.T, spacing)]
    while undecided.any():
        before, after = pairs.T
        beaten = np.zeros(len(points), bool)
        beaten[after] = True
        chosen = undecided & ~beaten
        kept |= chosen
        undecided &= ~chosen
        undecided[after[chosen[before]]] = False
        pairs = pairs[undecided[before] & undecided[after]]
    return kept


def smoothing(points: NDArray, normals: NDArray, width: float) -> Any:
    """Return the matrix that averages over neighbours by a Gaussian of standard deviation `width`.

    Rows and columns add up to 1 (symmetric Sinkhorn scaling): what is even stays even, and no light is made or lost.
    Neighbours count by the cosine between the normals, those that face away not at all.
    """
    pairs = KDTree(points).query_pairs(2.5 * width, output_type="ndarray")
    a, b = pairs.T
    apart = points[a] - points[b]
    weight = np.exp(-0.5 * np.einsum("ij,ij->i", apart, apart) / width**2)
    weight *= np.maximum(np.einsum("ij,ij->i", normals[a], normals[b]), 0.0)
    own = np.arange(len(points))
    entries = np.concatenate([weight, weight, np.ones(len(points))])
    index = np.concatenate([a, b, own]), np.concatenate([b, a, own])
    matrix = sparse.csr_matrix((entries.astype(np.float32), index), shape=(len(points),) * 2)
    scale = np.ones(len(points))
    for _ in range(_BALANCING):
        scale = np.sqrt(scale / (matrix @ scale))
    scaled = sparse.diags(scale) @ matrix @ sparse.diags(scale)
    return sparse.csr_matrix(scaled).astype(np.float32)


def interpolation(points: NDArray, normals: NDArray, nodes: NDArray, facing: NDArray, reach: float) -> Any:
    """Return the matrix, [points, nodes], whose rows are means over the nodes within `reach`, smooth in the point.

    `facing`: normals of the nodes; those that face away count only where there are no others, and where there are
    none at all, the nearest.
    """
    tree, count = KDTree(nodes), min(_MOST_NEAR, len(nodes))
    _, nearest = tree.query(points, workers=-1)
    distance, index = tree.query(points, k=count, distance_upper_bound=reach, workers=-1)
    inside = np.isfinite(distance.reshape(-1, count))
    row, column = np.nonzero(inside)[0], index.reshape(-1, count)[inside]
    squared = squared_distance(points[row] - nodes[column], normals[row], facing[column])
    weight = np.maximum(1.0 - squared / reach**2, 0.0) ** 3
    # the nearest counts a little in any case
    row, column = (np.concatenate([a, b]) for a, b in ((row, np.arange(len(points))), (column, nearest)))
    weight = np.concatenate([weight, np.full(len(points), _NEAREST)])
    weight *= np.maximum(np.einsum("ij,ij->i", normals[row], facing[column]), _FAR_SIDE)
    matrix = sparse.csr_matrix((weight, (row, column)), shape=(len(points), len(nodes)))
    matrix.eliminate_zeros()
    sums = np.asarray(matrix.sum(axis=1)).ravel()
    return sparse.csr_matrix(sparse.diags(1.0 / sums) @ matrix).astype(np.float32)
