"""Put a mesh where the scenes expect it: upright, on the ground, of a given size."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nephrite.errors import ParameterError, unknown_name
from nephrite.scene.triangles import TriangleMesh

# Rows: where x, y and z come from, so that the named axis becomes y. All are rotations.
_UPRIGHT = {
    "x": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "y": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "z": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-x": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "-y": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-z": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
}


def placed(mesh: TriangleMesh, size_mm: float, up: str = "y") -> TriangleMesh:
    """Turn, move and scale a mesh: `up` upwards (y), centred on x = z = 0, standing on y = 0.

    Args:
        mesh: in any units.
        size_mm: length of its longest side afterwards, in mm; the scene's unit is a millimetre from then on.
        up: the file's axis that points up: x, y, z, -x, -y or -z.

    Raises:
        ParameterError: the size is not a positive number, or the axis is unknown.
    """
    if not (math.isfinite(size_mm) and size_mm > 0):
        raise ParameterError(f"the size of {mesh.name} is {size_mm} mm. Give its longest side, such as 100.")
    if up not in _UPRIGHT:
        raise unknown_name("axis for up", up, _UPRIGHT)
    low, high = mesh.bounds
    scale = size_mm / float((high - low).max())
    foot = np.array([0.0, 0.5 * scale, 0.0])
    turn = np.array(_UPRIGHT[up], dtype=np.float64)
    height = np.abs(turn) @ (high - low)
    vertices = ((mesh.vertices - (low + high) / 2) * scale) @ turn.T + foot * height
    return replace(mesh, vertices=vertices, report=mesh.report.scaled(scale))
