"""Which way triangles are wound: made alike where they meet, and outward.

A triangle is wound counter-clockwise seen from outside. Files often have some the other way: what is here finds them,
on plain arrays, and never moves a vertex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nephrite.geometry.topology import Floats, Ints, components, edges_of, groups, merge_equal

Mask = NDArray[np.bool_]

MOST_ANGLES = 50_000_000  # solid angles to be computed at most, some ten seconds


def turned_over(faces: Ints, which: Mask) -> Ints:
    """Return `(M, 3)` faces with those wound the other way that the `(M,)` mask names."""
    result = faces.copy()
    result[which] = result[which][:, ::-1]
    return result


def wound_apart(faces: Ints) -> tuple[Mask, bool]:
    """Find the faces to turn over so that neighbours agree, keeping each patch's majority.

    Neighbours are two faces that alone share an edge. Solved at once on the double cover: every face is there
    twice, as it is and turned; neighbours that disagree are joined crosswise.

    Returns:
        The `(M,)` mask, and whether the surface has two sides everywhere (a Möbius strip has not; its patch is
        left alone).
    """
    edges = edges_of(faces)
    order = np.argsort(edges.edge, kind="stable")
    order = order[edges.faces_at[edges.edge[order]] == 2].reshape(-1, 2)
    crossed = edges.forward[order[:, 0]] == edges.forward[order[:, 1]]
    if not crossed.any():
        return np.zeros(len(faces), dtype=bool), True
    a, b, count = order[:, 0] // 3, order[:, 1] // 3, len(faces)
    first = np.concatenate([a, a + count])
    second = np.concatenate([b + count * crossed, b + count * ~crossed])
    number, sheet = groups(first, second, 2 * count)
    one_sided = sheet[:count] == sheet[count:]
    # Of the two sheets of a patch, turn over the faces that the larger one holds turned.
    kept = np.bincount(sheet[:count], minlength=number)
    turned = (kept[sheet[:count]] < kept[sheet[count:]]) & ~one_sided
    tie = (kept[sheet[:count]] == kept[sheet[count:]]) & (sheet[:count] > sheet[count:]) & ~one_sided
    return turned | tie, not one_sided.any()


def inside_out(vertices: Floats, faces: Ints) -> tuple[Mask, int, int]:
    """Find the closed parts that face inward, each with all that lies inside it, so that cavities stay cavities.

    Returns:
        The `(M,)` mask of their faces, the number of these parts, and of all parts.
    """
    number, part = components(faces)
    volume = np.bincount(part, weights=face_volumes(vertices, faces), minlength=number)
    is_open = np.zeros(number, dtype=bool)
    is_open[part[edges_of(faces).open_half_edges // 3]] = True
    if not (volume[~is_open] < 0).any():
        return np.zeros(len(faces), dtype=bool), 0, number
    inverted = _outermost(vertices, faces, part, np.where(is_open, 0.0, np.abs(volume)), volume < 0)
    inverted &= ~is_open
    return inverted[part], int(inverted.sum()), number


def against_others(vertices: Floats, faces: Ints) -> Mask:
    """Find the faces, `(M,)`, to turn over in a mesh that is wound both ways; none in one wound in one way.

    Vertices need not be shared. In a mixed mesh closed parts are turned outward; where it is open there is no inside,
    and neighbours agree with their majority.
    """
    if edges_of(faces).balance.any():  # open, wound both ways, or in pieces that only lie side by side
        vertices, faces = merge_equal(vertices, faces)
    whole = ~(faces == np.roll(faces, -1, axis=1)).any(axis=1)
    found = np.zeros(len(faces), dtype=bool)
    apart, _ = wound_apart(faces[whole])
    if apart.any():
        found[whole] = apart ^ inside_out(vertices, turned_over(faces[whole], apart))[0]
    return found


def winding_number(vertices: Floats, faces: Ints, point: Floats) -> float:
    """How often a closed surface winds around a `point`: 1 inside, 0 outside.

    Sums the solid angles of the faces (Van Oosterom & Strackee 1983, equation 8).
    """
    a, b, c = (vertices[faces[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    dot = lambda x, y: np.einsum("ij,ij->i", x, y)  # noqa: E731
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return float(np.arctan2(dot(a, np.cross(b, c)), below).sum() / (2 * np.pi))


def face_crosses(vertices: Floats, faces: Ints) -> Floats:
    """`(M, 3)` normals whose length is twice the area of each face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def face_volumes(vertices: Floats, faces: Ints) -> Floats:
    """`(M,)` signed volumes of the tetrahedra between each face and the middle of the mesh."""
    if not len(faces):
        return np.zeros(0)
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return np.einsum("ij,ij->i", vertices[faces[:, 0]] - middle, face_crosses(vertices, faces)) / 6


def _outermost(vertices: Floats, faces: Ints, part: Ints, size: Floats, answer: Mask) -> Mask:
    """For each part, the `answer` of the largest part (by `size`; 0: not closed) around it, or its own."""
    corners = vertices[faces].reshape(-1, 3)
    low, high = np.full((len(size), 3), np.inf), np.full((len(size), 3), -np.inf)
    np.minimum.at(low, np.repeat(part, 3), corners)
    np.maximum.at(high, np.repeat(part, 3), corners)
    first = np.unique(part, return_index=True)[1]
    points = vertices[faces[first]].mean(axis=1)
    result, budget = answer.copy(), MOST_ANGLES
    for p, point in enumerate(points):
        within = (low < point).all(axis=1) & (point < high).all(axis=1) & (size > size[p])
        for q in sorted(np.flatnonzero(within), key=lambda q: -size[q]):
            shell = faces[part == q]
            budget -= len(shell)
            if budget < 0:
                return result
            if abs(winding_number(vertices, shell, point)) > 0.5:
                result[p] = answer[q]
                break
    return result
