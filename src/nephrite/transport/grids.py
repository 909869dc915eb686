"""Cells over the nodes of a surface, in grids: those of each are twice as wide as those of the one before."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.transport.nodes import REACH, interpolation, smoothing, spread

GRIDS = 4  # the nodes, and cells of 2, 4, 8 spacings


@dataclass
class Grids:
    """The cells of all grids; those of the first are the nodes.

    `ups`: matrices from each grid's cells to those of the grid before; `facing`: normals of each grid's cells;
    `nearest`: for each grid, the cell of each node; `smooth`: the matrix that averages over neighbouring nodes.
    """

    ups: list[Any]
    facing: list[NDArray]
    nearest: list[NDArray]
    smooth: Any

    @classmethod
    def over(cls, points: NDArray, normals: NDArray, spacing: float) -> Grids:
        """Lay them over nodes at `points`, with `normals`, both [nodes, 3], that keep the distance `spacing`."""
        with ThreadPoolExecutor(1) as beside:
            smooth = beside.submit(smoothing, points, normals, spacing)
            ups, facing, nearest = [], [normals], [np.arange(len(points))]
            for grid in range(1, GRIDS):
                width = 2**grid * spacing
                centres = spread(points, facing[-1], width)
                up = interpolation(points, facing[-1], points[centres], facing[-1][centres], REACH * width)
                ups.append(up)
                nearest.append(np.asarray(up.argmax(axis=1)).ravel()[nearest[-1]])
                points = points[centres]
                facing.append(facing[-1][centres])
            return cls(ups, facing, nearest, smooth.result())
