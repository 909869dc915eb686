"""Normals of meshes whose triangles are wound both ways.

A jump needs the outer side of the point that it lands on. All over a mesh that is the side that the path entered on,
if the mesh is wound in one way, be it outward or inward. `nephrite.scene` turns the others; meshes of Mitsuba's own
are taken as they are, and their normals turned here, a face at a time. Lookups cost nothing where no mesh is mixed.
"""

from __future__ import annotations

import hashlib
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.geometry.winding import against_others

_MOST_CROSSINGS = 256  # of a line
_KEPT = 64  # meshes
_known: dict[bytes, NDArray[np.bool_]] = {}  # a picture's passes ask for the same meshes again and again


class Winding:
    """Which faces of which shapes are wound against the others."""

    def __init__(self, shapes: dict[int, Any]) -> None:
        """Look at the triangle meshes among `shapes`, which are named by their identities."""
        found = {identity: _against_others(shape) for identity, shape in shapes.items() if shape.is_mesh()}
        mixed = {identity: faces for identity, faces in found.items() if faces.any()}
        self.any_mixed = bool(mixed)
        first = np.full(1 + max(mixed, default=0), -1)
        signs = [np.ones(0)]
        for identity, faces in mixed.items():
            first[identity] = sum(map(len, signs))
            signs.append(np.where(faces, -1.0, 1.0))
        self._size = len(first)
        self._first, self._signs = mi.Int32(first), mi.Float(np.concatenate(signs))
        dr.eval(self._first, self._signs)

    def outward(self, si: Any) -> Any:
        """Return the geometric normals of `si`, on a mixed mesh those of faces all wound alike."""
        if not self.any_mixed:
            return si.n
        identity: Any = dr.reinterpret_array(mi.UInt32, si.shape)
        first = dr.gather(mi.Int32, self._first, identity, identity < self._size)
        mixed = (identity < self._size) & (first >= 0)
        sign = dr.gather(mi.Float, self._signs, mi.UInt32(first) + si.prim_index, mixed)
        return mi.Normal3f(si.n * dr.select(mixed, sign, 1.0))


@dr.syntax
def outward(scene: Any, shape: Any, p: Any, n: Any) -> Any:
    """Return `n` or `-n`: the one along which a line from the point `p` of a closed `shape` crosses it evenly often."""
    identity = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    start = dr.zeros(mi.Interaction3f, dr.width(p))
    start.p, start.n = p, n
    ray = start.spawn_ray(n)
    # two loops of one kernel may not both intersect rays: Dr.Jit 1.5 defines the same function twice
    dr.eval(ray)
    inward, active, turns = mi.Bool(False), mi.Bool(True), mi.UInt32(0)
    while active:
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
        active &= si.is_valid() & (turns < _MOST_CROSSINGS)
        inward ^= active & (dr.reinterpret_array(mi.UInt32, si.shape) == identity)
        ray.o = si.spawn_ray(ray.d).o
        turns += 1
    dr.eval(inward)
    return dr.select(inward, -n, n)


def triangles(mesh: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices, (N, 3), and faces, (M, 3), of one of Mitsuba's meshes."""
    vertices, faces = _arrays(mesh)
    return vertices.astype(np.float64).reshape(-1, 3), faces.astype(np.int64).reshape(-1, 3)


def _arrays(mesh: Any) -> tuple[NDArray, NDArray]:
    values = mi.traverse(mesh)
    name = "vertex_positions" if "vertex_positions" in values else "positions"  # the latter from Mitsuba 3.10
    return np.array(values[name]), np.array(values["faces"])


def _against_others(mesh: Any) -> NDArray[np.bool_]:
    key = hashlib.sha256(b"".join(values.tobytes() for values in _arrays(mesh))).digest()
    if key not in _known:
        if len(_known) >= _KEPT:
            _known.clear()
        _known[key] = against_others(*triangles(mesh))
    return _known[key]
