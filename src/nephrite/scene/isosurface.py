"""From a function in space to the triangles of its zero surface: surface nets (Gibson 1998)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.geometry.topology import Floats, Ints

Values = NDArray[np.floating[Any]]
Field = Callable[[Values, Values, Values], Values]
_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = [(a, b) for a in range(8) for b in range(a) if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1]


def polygonise(field: Field, low: Floats, high: Floats, spacing: float) -> tuple[Floats, Ints]:
    """Triangulate where `field(x, y, z)` changes sign; negative is inside.

    One vertex is put into each cell of a grid that the surface passes through, and is then drawn onto the
    surface along the gradient. The result is closed if the field is positive on the box's faces; its faces
    point to where the field is positive.

    Args:
        field: maps three equally shaped arrays to values, about a distance near the surface.
        low, high: `(3,)` corners of the box to search.
        spacing: size of a cell.

    Returns:
        `(N, 3)` vertices and `(M, 3)` faces.
    """
    low = np.asarray(low, dtype=np.float64)
    counts = np.ceil((np.asarray(high) - low) / spacing).astype(int) + 1
    axes = [(low[a] + spacing * np.arange(counts[a])).astype(np.float32) for a in range(3)]
    # Plane by plane: what is computed for one stays in the processor's cache.
    values = np.stack(
        [field(*np.meshgrid(axes[0][i : i + 1], *axes[1:], indexing="ij"))[0] for i in range(counts[0])]
    )
    inside = values < 0
    cells, places = _cell_vertices(values, inside)
    vertices = low + places * spacing
    quads = _quads(inside, cells)
    vertices = _drawn_to_surface(field, vertices, quads, spacing)
    return vertices, _split_quads(vertices, quads)


def _cell_vertices(values: Values, inside: NDArray[np.bool_]) -> tuple[Ints, Floats]:
    """Number the cells that the surface passes (-1: none), and place their vertices, in cells."""
    n = np.array(values.shape) - 1
    corner = lambda a, of: of[tuple(slice(_CORNERS[a][k], _CORNERS[a][k] + n[k]) for k in range(3))]  # noqa: E731
    number_inside = np.sum([corner(a, inside) for a in range(8)], axis=0)
    mixed = (number_inside > 0) & (number_inside < 8)
    cells = np.full(n, -1, dtype=np.int64)
    cells[mixed] = np.arange(mixed.sum())
    at = np.argwhere(mixed)
    value = np.stack([corner(a, values)[mixed] for a in range(8)], axis=1).astype(np.float64)
    total, crossings = np.zeros((len(at), 3)), np.zeros((len(at), 1))
    for a, b in _EDGES:
        crosses = (value[:, a] < 0) != (value[:, b] < 0)
        step = value[:, a] - value[:, b]
        t = value[:, a] / np.where(crosses, step, 1.0)
        point = _CORNERS[a] + t[:, None] * (_CORNERS[b] - _CORNERS[a])
        total += np.where(crosses[:, None], point, 0.0)
        crossings += crosses[:, None]
    return cells, at + total / crossings


def _quads(inside: NDArray[np.bool_], cells: Ints) -> Ints:
    """Return `(Q, 4)` quadrilaterals, one around every grid edge that the surface cuts."""
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        first, last = [slice(None)] * 3, [slice(None)] * 3
        first[axis], last[axis] = slice(None, -1), slice(1, None)
        for other in (u, v):
            first[other] = last[other] = slice(1, -1)
        starts, ends = inside[tuple(first)], inside[tuple(last)]
        at = np.argwhere(starts != ends)
        leaves = starts[tuple(at.T)]
        at[:, u] += 1
        at[:, v] += 1
        ring = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = at.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            ring.append(cells[tuple(cell.T)])
        quad = np.stack(ring, axis=1)
        quads.append(np.where(leaves[:, None], quad, quad[:, ::-1]))
    return np.concatenate(quads)


def _drawn_to_surface(field: Field, vertices: Floats, quads: Ints, spacing: float) -> Floats:
    """Even the vertices out, and draw them back along the gradient, by half a cell at most; thrice."""
    start, end = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    degree = np.maximum(np.bincount(start, minlength=len(vertices)), 1)[:, None]
    h = 0.1 * spacing
    for _ in range(3):
        around = [np.bincount(start, weights=vertices[end, k], minlength=len(vertices)) for k in range(3)]
        vertices = 0.5 * (vertices + np.stack(around, axis=1) / degree)
        value = field(*vertices.T.astype(np.float32))
        slope = [field(*(vertices + h * axis).T.astype(np.float32)) - value for axis in np.eye(3)]
        slope = np.stack(slope, axis=1).astype(np.float64) / h
        step = -value[:, None] * slope / np.maximum((slope**2).sum(axis=1, keepdims=True), 0.05)
        length = np.linalg.norm(step, axis=1, keepdims=True)
        vertices = vertices + step * np.minimum(1.0, 0.5 * spacing / np.maximum(length, 1e-12))
    return vertices


def _split_quads(vertices: Floats, quads: Ints) -> Ints:
    """Cut each quadrilateral along its shorter diagonal."""
    a, b, c, d = quads.T
    straight = np.linalg.norm(vertices[a] - vertices[c], axis=1) <= np.linalg.norm(
        vertices[b] - vertices[d], axis=1
    )
    one = np.where(straight[:, None], np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    other = np.where(straight[:, None], np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.concatenate([one, other])
