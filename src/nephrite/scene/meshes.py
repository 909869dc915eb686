"""Meshes in and out: `load` a file, `repair` it, have it `placed`, `write_ply` for Mitsuba."""

from __future__ import annotations

from pathlib import Path

from nephrite.geometry.topology import Floats, Ints
from nephrite.scene.check import UNSEEN, Finding, MeshReport
from nephrite.scene.place import placed
from nephrite.scene.ply import write_ply
from nephrite.scene.reading import FORMATS, read
from nephrite.scene.repair import repair
from nephrite.scene.triangles import TriangleMesh

__all__ = [
    "FORMATS",
    "Finding",
    "MeshReport",
    "TriangleMesh",
    "from_arrays",
    "load",
    "placed",
    "repair",
    "write_ply",
]


def load(path: Path | str) -> TriangleMesh:
    """Read a mesh file and repair it; `mesh.report` says what was found and done.

    Args:
        path: a file in one of `FORMATS`, also gzipped. Several meshes in one file become one.

    Returns:
        The mesh in the file's units, facing outwards; `mesh.closed` tells whether it bounds a volume.

    Raises:
        MeshError: the file cannot be read, or holds no surface.
    """
    vertices, faces = read(path)
    return from_arrays(vertices, faces, Path(path).name)


def from_arrays(vertices: Floats, faces: Ints, name: str) -> TriangleMesh:
    """Make a repaired mesh of `(N, 3)` vertices and `(M, 3)` faces.

    Raises:
        MeshError: there is no surface in them.
    """
    return repair(TriangleMesh(vertices, faces, name, UNSEEN))
