"""What is asked of a shape before anything is rendered: points on it, and how large it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.plugins.winding import Winding, outward, triangles

_TELLING = 1 << 12  # points that tell which way the normals of a shape point


def surface_points(shape: Any, u2: Any, u1: Any) -> Any:
    """Return interactions at points that are uniform over a shape's area, seen at sampled wavelengths."""
    place = shape.sample_position(0.0, u2)
    si: Any = dr.zeros(mi.SurfaceInteraction3f, dr.width(u1))
    si.p, si.n, si.uv, si.sh_frame = place.p, place.n, place.uv, mi.Frame3f(place.n)
    if mi.is_spectral:
        shifted: Any = mi.sample_shifted(u1)
        si.wavelengths = mi.sample_rgb_spectrum(shifted)[0]
    return si


@dataclass
class Start:
    """Random points of a `shape`, uniform over its area, from which light enters.

    `si`: interactions, with normals that point outward; `side`: 1 if so do those of `Winding`, and -1 else.
    """

    shape: Any
    si: Any
    side: float


def start(scene: Any, winding: Winding, shape: Any, sampler: Any) -> Start:
    """Return as many points as the sampler has lanes."""
    si = surface_points(shape, sampler.next_2d(), sampler.next_1d())
    if winding.any_mixed:  # which face it is tells a ray from above
        n = mi.Vector3f(outward(scene, shape, si.p, mi.Vector3f(si.n)))
        above = si.spawn_ray(n)
        above.d = -n
        side = _side(n, winding.outward(scene.ray_intersect(above)))
    else:  # some points tell of all
        some = dr.arange(mi.UInt32, min(_TELLING, dr.width(si.p)))
        p, own = (dr.gather(type(values), values, some) for values in (si.p, si.n))
        side = _side(outward(scene, shape, p, mi.Vector3f(own)), own)
        n = side * mi.Vector3f(si.n)
    si.n, si.sh_frame = mi.Normal3f(n), mi.Frame3f(n)
    return Start(shape, si, side)


def _side(n: Any, own: Any) -> float:
    return 1.0 if float(dr.mean(dr.dot(n, own))[0]) > 0 else -1.0


def mean_chord(shape: Any) -> float:
    """Mean length of the straight lines through a shape: 4 V / S (Cauchy); scene units.

    A mesh's volume is the sum of its signed tetrahedra; for other shapes that of the ellipsoid in the bounding box.
    """
    area = max(float(dr.max(shape.surface_area())[0]), 1e-30)
    extents = np.array(shape.bbox().extents(), dtype=np.float64).ravel()
    volume = float(np.prod(extents)) * np.pi / 6.0
    if shape.is_mesh():
        vertices, faces = triangles(shape)
        corners = vertices[faces] - vertices.mean(axis=0)
        volume = (
            abs(float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()))
            / 6.0
        )
    return 4.0 * volume / area
