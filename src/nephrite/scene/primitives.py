"""Plain shapes by name, for tests and for looking at a material."""

from __future__ import annotations

import numpy as np

from nephrite.scene.meshes import from_arrays
from nephrite.scene.triangles import TriangleMesh


def sphere() -> TriangleMesh:
    """Return a ball of diameter 1, of 20,480 triangles."""
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=5, radius=0.5)
    return from_arrays(np.array(ball.vertices), np.array(ball.faces), "sphere")


def cube() -> TriangleMesh:
    """Return a cube of side 1."""
    return _box("cube", 1.0, 1.0, 1.0)


def slab() -> TriangleMesh:
    """Return an upright plate, 1 wide, 1 high and 0.05 thick (along z): light from behind shines through."""
    return _box("slab", 1.0, 1.0, 0.05)


def _box(name: str, *extents: float) -> TriangleMesh:
    from trimesh.creation import box

    solid = box(extents)
    return from_arrays(np.array(solid.vertices), np.array(solid.faces), name)
