"""Finds the nodes near a point of a surface, for whole wavefronts of points at once.

Nodes lie in the cells of a grid, sorted, so that a point looks at 9 rows of 3 cells each. Those that face away from
it, on the far side of a thin part, do not count.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

_FAR_SIDE = 1e-6  # weight of nodes that face away: they count where there are no others


class Nearby:
    """The nodes of several surfaces; a query says which surface it means by its number."""

    def __init__(self, surfaces: list[tuple[NDArray, NDArray, float]]) -> None:
        """Sort the nodes of each surface, (points, normals, reach), into cells as wide as its `reach`.

        `points`, `normals`: those of all surfaces, one after the other, in the order of the indices that queries use.
        """
        points, normals, starts, columns = [], [], [], []
        nodes = cells = 0
        for p, n, reach in surfaces:
            low = p.min(0) - 2.0 * reach
            counts = np.ceil((p.max(0) + 2.0 * reach - low) / reach).astype(int) + 1
            x, y, z = np.floor((p - low) / reach).astype(int).T
            flat = (z * counts[1] + y) * counts[0] + x
            order = np.argsort(flat, kind="stable")
            size = int(np.prod(counts))
            starts.append(np.searchsorted(flat[order], np.arange(size + 1)) + nodes)
            columns.append([*low, reach, *counts, cells])
            points.append(p[order])
            normals.append(n[order])
            nodes, cells = nodes + len(p), cells + size + 1
        self.points, self.normals = np.concatenate(points), np.concatenate(normals)
        self._p = mi.Float(self.points.astype(np.float32).ravel())
        self._n = mi.Float(self.normals.astype(np.float32).ravel())
        self._starts = mi.UInt32(np.concatenate(starts).astype(np.uint32))
        table = np.array(columns)
        self._place = mi.Float(table[:, :4].astype(np.float32).ravel())
        self._layout = mi.Int32(table[:, 4:].astype(np.int32).ravel())
        dr.eval(self._p, self._n, self._starts, self._place, self._layout)

    @dr.syntax
    def nearest(self, which: Any, p: Any, n: Any, active: Any) -> Any:
        """Return the index of the node nearest to `p` that faces as `n` does."""
        place, layout, cell = self._cell(which, p, active)
        row, at, end = mi.Int32(0), mi.UInt32(0), mi.UInt32(0)
        best, found = mi.Float(dr.largest(mi.Float)), mi.UInt32(0)
        going = mi.Bool(active)
        while going:
            if at < end:
                squared, facing = self._apart(at, p, n)
                distance = squared + dr.select(facing > 0, 0.0, 1e3 * dr.square(place.w))
                found = dr.select(distance < best, at, found)
                best = dr.minimum(best, distance)
                at += 1
            else:
                at, end = self._row(layout, cell, row)
                row += 1
            going = (row < 9) | (at < end)
        return found

    @dr.syntax
    def mean(self, which: Any, p: Any, n: Any, table: Any, active: Any) -> tuple[Any, Any, Any, Any]:
        """Return the mean of a `table` of four vectors a node, over the nodes near `p`; it is smooth in `p`."""
        place, layout, cell = self._cell(which, p, active)
        row, at, end = mi.Int32(0), mi.UInt32(0), mi.UInt32(0)
        total = mi.Float(0)
        a: Any = mi.Vector3f(0)
        b: Any = mi.Vector3f(0)
        c: Any = mi.Vector3f(0)
        d: Any = mi.Vector3f(0)
        going = mi.Bool(active)
        while going:
            if at < end:
                squared, facing = self._apart(at, p, n)
                inside = dr.maximum(1.0 - squared / dr.square(place.w), 0.0)
                weight = dr.square(inside) * inside * dr.maximum(facing, _FAR_SIDE)
                total += weight
                a += weight * dr.gather(mi.Vector3f, table, 4 * at)
                b += weight * dr.gather(mi.Vector3f, table, 4 * at + 1)
                c += weight * dr.gather(mi.Vector3f, table, 4 * at + 2)
                d += weight * dr.gather(mi.Vector3f, table, 4 * at + 3)
                at += 1
            else:
                at, end = self._row(layout, cell, row)
                row += 1
            going = (row < 9) | (at < end)
        scale = dr.rcp(dr.maximum(total, 1e-30))
        return a * scale, b * scale, c * scale, d * scale

    def _cell(self, which: Any, p: Any, active: Any) -> tuple[Any, Any, Any]:
        place: Any = dr.gather(mi.Vector4f, self._place, which, active)
        layout: Any = dr.gather(mi.Vector4i, self._layout, which, active)
        cell = mi.Vector3i(dr.floor((mi.Vector3f(p) - place.xyz) / place.w))
        return place, layout, dr.clip(cell, 1, layout.xyz - 2)

    def _row(self, layout: Any, cell: Any, row: Any) -> tuple[Any, Any]:
        y, z = cell.y + row % 3 - 1, cell.z + row // 3 - 1
        first = layout.w + (z * layout.y + y) * layout.x + cell.x - 1
        return dr.gather(mi.UInt32, self._starts, first), dr.gather(mi.UInt32, self._starts, first + 3)

    def _apart(self, node: Any, p: Any, n: Any) -> tuple[Any, Any]:
        """Squared distance to a node, and the cosine between its normal and `n`."""
        q = dr.gather(mi.Point3f, self._p, node)
        return dr.squared_norm(p - q), dr.dot(dr.gather(mi.Vector3f, self._n, node), n)
