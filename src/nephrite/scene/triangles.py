"""A triangle mesh in memory: two arrays, a name, and the report of what was found in it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nephrite.geometry.topology import Floats, Ints
from nephrite.geometry.winding import face_crosses
from nephrite.scene.check import MeshReport, signed_volume


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """An indexed triangle mesh; treat the arrays as read-only.

    Attributes:
        vertices: `(N, 3)` float64 positions, in the file's units (millimetres after `placed`).
        faces: `(M, 3)` int64 vertex numbers, counter-clockwise seen from outside.
        name: what to call it in messages: the file's name, or the built-in piece's.
        report: what was found, and what was done about it.
        note: something that the user should be told (a substitute was taken, ...); empty otherwise.
    """

    vertices: Floats
    faces: Ints
    name: str
    report: MeshReport
    note: str = ""

    @property
    def closed(self) -> bool:
        """Whether the surface bounds a volume: no rim, no hole."""
        return self.report.closed

    @cached_property
    def bounds(self) -> Floats:
        """`(2, 3)`: the smallest and the largest coordinates."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def extents(self) -> Floats:
        """`(3,)` lengths of the box around the mesh."""
        return self.bounds[1] - self.bounds[0]

    @cached_property
    def volume(self) -> float:
        """Enclosed volume in cubed units of length; only meaningful if `closed`."""
        return signed_volume(self.vertices, self.faces)

    @cached_property
    def area(self) -> float:
        """Area of the surface in squared units of length."""
        return float(np.linalg.norm(face_crosses(self.vertices, self.faces), axis=1).sum() / 2)
