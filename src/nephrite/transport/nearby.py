"""Finds the nodes near a point of a surface, for whole wavefronts of points at once.

Nodes lie in the cells of a grid, sorted, so that a point looks at rows of cells. Those that face away from it, on the
far side of a thin part, count only where there are no others.
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray


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
        # lists: Dr.Jit copies them to where it gathers four numbers at once. NumPy's memory may lie elsewhere, and then
        # kernels are others, and compiled anew whenever chance has it
        self._place = mi.Float(table[:, :4].ravel().tolist())
        self._layout = mi.Int32(table[:, 4:].astype(int).ravel().tolist())
        dr.eval(self._p, self._n, self._starts, self._place, self._layout)

    def nearest(self, which: Any, p: Any, n: Any, active: Any) -> Any:
        """Return the index of the node nearest to `p`, within the cells around its own, that faces as `n` does."""
        return self._nearest(3, which, p, n, active)[0]

    @dr.syntax
    def beside(self, which: Any, p: Any, n: Any, u: Any, active: Any) -> Any:
        """Return the node nearest to a point by chance beside `p`, of the surface's reach; `u`: two uniform numbers.

        What is looked up there is in the mean smooth in `p`, and noise between neighbours adds little to a path's.
        """
        reach = dr.gather(mi.Float, self._place, 4 * which + 3, active)
        radius = reach * dr.sqrt(1 - dr.sqrt(dr.sqrt(1 - u.x)))  # density (1 - r² / reach²)³
        sine, cosine = dr.sincos(2 * math.pi * u.y)
        q = p + dr.select(active, mi.Frame3f(n).to_world(mi.Vector3f(radius * cosine, radius * sine, 0)), 0)
        found, faces = self._nearest(2, which, q, n, active)
        lost = active & ~faces  # beside an edge
        if lost:
            found = self._nearest(3, which, p, n, lost)[0]
        return found

    @dr.syntax
    def _nearest(self, width: int, which: Any, p: Any, n: Any, active: Any) -> tuple[Any, Any]:
        """Return the node nearest to `p` that faces as `n` does, or if none does, any; and whether it does.

        Within a cube of `width` cells: what is nearer than half a cell is found in 2, and than a cell in 3.
        """
        place: Any = dr.gather(mi.Vector4f, self._place, which, active)
        layout: Any = dr.gather(mi.Vector4i, self._layout, which, active)
        corner: Any = mi.Vector3i(dr.floor((mi.Vector3f(p) - place.xyz) / place.w - 0.5 * (width - 1)))
        corner = dr.clip(corner, 0, layout.xyz - width)
        row, at, end = mi.Int32(0), mi.UInt32(0), mi.UInt32(0)
        best, found, faces = mi.Float(dr.largest(mi.Float)), mi.UInt32(0), mi.Bool(False)
        going = mi.Bool(active)
        while going:
            if at < end:
                q = dr.gather(mi.Point3f, self._p, at)
                facing = dr.dot(dr.gather(mi.Vector3f, self._n, at), n) > 0
                distance = dr.squared_norm(p - q)
                better = (facing & ~faces) | ((facing == faces) & (distance < best))
                found, best = dr.select(better, at, found), dr.select(better, distance, best)
                faces |= facing
                at += 1
            else:
                y, z = corner.y + row % width, corner.z + row // width
                cell = layout.w + (z * layout.y + y) * layout.x + corner.x
                at = dr.gather(mi.UInt32, self._starts, cell)
                end = dr.gather(mi.UInt32, self._starts, cell + width)
                row += 1
            going = (row < width**2) | (at < end)
        return found, faces
