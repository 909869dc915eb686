"""How the triangles of a mesh hang together: edges, pairs of faces, components.

Everything here works on plain arrays and never moves a vertex. A *half-edge* is one side of one triangle:
number `3 f + k` runs from corner `k` of face `f` to the next corner. A mesh is **closed** (it bounds a
volume) where every edge is run through as often in one direction as in the other; it is **manifold** where
exactly two faces meet at each edge. A mesh can be closed without being manifold: two bodies that touch along
an edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Edges:
    """The half-edges of a mesh, and the undirected edges that they lie on.

    Attributes:
        tail, head: `(3M,)` vertices that each half-edge runs from and to.
        edge: `(3M,)` number of the undirected edge of each half-edge.
        forward: `(3M,)` whether a half-edge runs from the lower vertex number to the higher.
        faces_at: `(E,)` how many faces meet at each edge.
        balance: `(E,)` runs forward less runs backward; 0 on a closed surface.
    """

    tail: Ints
    head: Ints
    edge: Ints
    forward: NDArray[np.bool_]
    faces_at: Ints
    balance: Ints

    @property
    def open_half_edges(self) -> Ints:
        """Numbers of the half-edges that lie on an unbalanced edge."""
        return np.flatnonzero(self.balance[self.edge] != 0)


def edges_of(faces: Ints) -> Edges:
    """Find the edges of `(M, 3)` faces."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    forward = tail < head
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    key = low * (faces.max(initial=0) + 1) + high
    _, edge, faces_at = np.unique(key, return_inverse=True, return_counts=True)
    balance = np.bincount(edge, weights=np.where(forward, 1.0, -1.0), minlength=len(faces_at))
    return Edges(tail, head, edge, forward, faces_at, balance.astype(np.int64))


def groups(first: Ints, second: Ints, count: int) -> tuple[int, Ints]:
    """Connected components of `count` things, where `first[i]` hangs on `second[i]`: (number, labels)."""
    ones = np.ones(len(first), dtype=np.int8)
    graph = coo_matrix((ones, (first, second)), shape=(count, count))
    number, labels = connected_components(graph, directed=False)
    return int(number), labels.astype(np.int64)


def components(faces: Ints) -> tuple[int, Ints]:
    """Parts that share no vertex: (number, `(M,)` label of each face)."""
    used, compact = np.unique(faces, return_inverse=True)
    compact = compact.reshape(-1, 3)
    first = np.concatenate([compact[:, 0], compact[:, 1]])
    number, labels = groups(first, np.concatenate([compact[:, 1], compact[:, 2]]), len(used))
    return number, labels[compact[:, 0]]


def boundaries(faces: Ints) -> tuple[int, Ints, Ints]:
    """Separate boundaries (holes, rims): their number, `(B,)` open half-edges, `(B,)` the boundary of each."""
    edges = edges_of(faces)
    at = edges.open_half_edges
    ends, compact = np.unique(np.concatenate([edges.tail[at], edges.head[at]]), return_inverse=True)
    number, label = groups(compact[: len(at)], compact[len(at) :], len(ends)) if len(at) else (0, ends)
    return number, at, label[compact[: len(at)]]


def pair_half_edges(vertices: Floats, faces: Ints) -> Ints:
    """Decide which two faces belong together at every edge; `(P, 2)` half-edges.

    Where more than two faces meet, going around the edge, a face that opens a piece of solid is paired with
    the one that closes it, so that bodies that only touch come apart. Half-edges without a partner are left
    out.
    """
    edges = edges_of(faces)
    order = np.argsort(edges.edge, kind="stable")
    many = edges.faces_at[edges.edge[order]]
    simple = order[(many == 2) & (edges.balance[edges.edge[order]] == 0)].reshape(-1, 2)
    half = order[many > 2]
    if not len(half):
        return simple
    # Angle of each face around its edge, counted about the direction from the lower vertex to the higher.
    low = np.where(edges.forward[half], edges.tail[half], edges.head[half])
    high = np.where(edges.forward[half], edges.head[half], edges.tail[half])
    axis = vertices[high] - vertices[low]
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), np.finfo(float).tiny)
    side = np.zeros_like(axis)
    side[np.arange(len(axis)), np.argmin(np.abs(axis), axis=1)] = 1.0
    side = np.cross(axis, side)
    apex = vertices[faces[half // 3, (half % 3 + 2) % 3]] - vertices[low]
    angle = np.arctan2(np.sum(apex * np.cross(axis, side), axis=1), np.sum(apex * side, axis=1))
    # A face that runs backward has the solid at larger angles: it opens a bracket; the others close one.
    edge, opens = edges.edge[half], ~edges.forward[half]
    by_angle = np.lexsort((angle, edge))
    half, edge, opens = half[by_angle], edge[by_angle], opens[by_angle]
    start = np.flatnonzero(np.r_[True, edge[1:] != edge[:-1]])
    size = np.diff(np.r_[start, len(edge)])
    which = np.repeat(np.arange(len(start)), size)
    place = np.arange(len(edge)) - start[which]
    depth = np.cumsum(np.where(opens, 1, -1))
    depth -= np.r_[0, depth][start][which]
    # Begin each round where the depth is least; then brackets of equal depth alternate: open, close, ...
    least = np.minimum.reduceat(depth, start)
    at_least = np.where(depth == least[which], place, -1)
    turn = np.maximum.reduceat(at_least, start)
    place = (place - turn[which] - 1) % size[which]
    level = np.where(opens, depth, depth + 1)
    nested = np.lexsort((place, level, which))
    half, which, level, opens = half[nested], which[nested], level[nested], opens[nested]
    fits = (which[1:] == which[:-1]) & (level[1:] == level[:-1]) & opens[:-1] & ~opens[1:]
    at = np.flatnonzero(fits)
    return np.concatenate([simple, np.stack([half[at], half[at + 1]], axis=1)])


def weld(faces: Ints, pairs: Ints) -> tuple[Ints, Ints]:
    """Number the vertices anew so that faces hang together only across `pairs` of opposite half-edges.

    Returns:
        `(V,)` old number of each new vertex, and the `(M, 3)` faces in new numbers.
    """
    following = pairs // 3 * 3 + (pairs % 3 + 1) % 3
    first = np.concatenate([pairs[:, 0], following[:, 0]])
    second = np.concatenate([following[:, 1], pairs[:, 1]])
    number, label = groups(first, second, faces.size)
    source = np.empty(number, dtype=np.int64)
    source[label] = faces.ravel()
    return source, label.reshape(-1, 3)


def merge_equal(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Make vertices at exactly the same place one vertex; drops vertices that no face uses."""
    used, compact = np.unique(faces, return_inverse=True)
    places, number = np.unique(vertices[used] + 0.0, axis=0, return_inverse=True)  # + 0.0: -0 is 0
    return places, number.reshape(-1)[compact].reshape(-1, 3)


def net_faces(faces: Ints, keep_repeats: bool = False) -> tuple[Ints, int, int]:
    """Cancel pairs of faces on the same three vertices that face opposite ways, and drop repeated faces.

    A folded pair bounds no volume: cancelling it changes neither the volume nor the balance of any edge.
    Dropping a repeated face does, and `keep_repeats` leaves those in.

    Returns:
        The faces left, the number that cancelled, and the number of repeated ones dropped.
    """
    shift = np.argmin(faces, axis=1)
    turned = faces[np.arange(len(faces))[:, None], (shift[:, None] + np.arange(3)) % 3]
    sign = np.where(turned[:, 1] < turned[:, 2], 1, -1)
    _, which = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)
    which = which.reshape(-1)
    net = np.bincount(which, weights=sign).astype(np.int64)[which]
    # Rank the faces of each triple, those that agree with the majority first; keep as many as are left over.
    order = np.lexsort((sign * net <= 0, which))
    begins = np.r_[True, which[order][1:] != which[order][:-1]]
    place = np.arange(len(faces))
    rank = np.empty_like(place)
    rank[order] = place - np.maximum.accumulate(np.where(begins, place, 0))
    left = rank < np.abs(net)
    kept = left if keep_repeats else left & (rank == 0)
    return faces[kept], int(np.sum(~left)), int(np.sum(left & ~kept))
