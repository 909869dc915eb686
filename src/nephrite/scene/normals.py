"""Normals at vertices: smooth where the surface is, with an edge where it has one."""

from __future__ import annotations

import numpy as np

from nephrite.geometry.topology import Floats, Ints, pair_half_edges, weld
from nephrite.geometry.winding import face_crosses

CREASE_DEGREES = 50.0


def with_normals(
    vertices: Floats, faces: Ints, crease_degrees: float = CREASE_DEGREES
) -> tuple[Floats, Ints, Floats]:
    """Give every vertex the mean normal of its faces, weighted by their angles (Thürmer & Wüthrich 1998).

    A vertex on an edge between faces that differ by more than `crease_degrees` is doubled, so that the edge
    stays sharp. Places don't change.

    Returns:
        `(V, 3)` vertices, `(M, 3)` faces, `(V, 3)` unit normals.
    """
    crosses = face_crosses(vertices, faces)
    lengths = np.linalg.norm(crosses, axis=1, keepdims=True)
    flat = lengths[:, 0] == 0
    units = np.where(lengths > 0, crosses / np.where(lengths > 0, lengths, 1.0), 0.0)
    pairs = pair_half_edges(vertices, faces)
    a, b = pairs[:, 0] // 3, pairs[:, 1] // 3
    along = np.einsum("ij,ij->i", units[a], units[b]) > np.cos(np.radians(crease_degrees))
    source, welded = weld(faces, pairs[along | flat[a] | flat[b]])
    places = vertices[source]
    normals = np.zeros_like(places)
    for k in range(3):
        here, after, before = (places[welded[:, (k + step) % 3]] for step in range(3))
        angle = _angle(after - here, before - here)
        for axis in range(3):
            normals[:, axis] += np.bincount(
                welded[:, k], weights=angle * units[:, axis], minlength=len(places)
            )
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])  # for vertices of faces without area only
    return places, welded, np.where(length > 1e-12, normals / np.where(length > 1e-12, length, 1.0), up)


def _angle(u: Floats, v: Floats) -> Floats:
    """Angles between `(M, 3)` vectors; 0 where one of them is null."""
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
