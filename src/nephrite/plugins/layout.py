"""Where the nodes of precomputed transport lie on a shape: as dense as its mean free path asks for, normals outward."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.plugins.shapes import surface_points
from nephrite.plugins.winding import outward
from nephrite.transport.nodes import DENSITY, spread

SPACING = 0.8  # of nodes, in mean free paths of the densest channel
MOST_NODES, LEAST_NODES = 60_000, 4_000
_CANDIDATES = 5  # random points per node, of which the nodes are chosen


def free_paths(entry: Any) -> NDArray:
    """Return the reduced mean free path of each channel, in scene units."""
    sigma_a, sigma_s = entry.mean_coefficients()
    return 1.0 / np.maximum(sigma_a + sigma_s * (1.0 - entry.g), 1e-30)


def spacing(entry: Any, shape: Any) -> float:
    """Return the distance that nodes keep on a shape, in scene units."""
    area = float(dr.max(shape.surface_area())[0])
    widest, narrowest = ((area * DENSITY / count) ** 0.5 for count in (LEAST_NODES, MOST_NODES))
    return min(max(SPACING * float(free_paths(entry).min()), narrowest), widest)


def lay(entry: Any, shape: Any, scene: Any) -> tuple[NDArray, NDArray, float]:
    """Return nodes of a shape, their outward normals, both [n, 3], and their spacing."""
    apart = spacing(entry, shape)
    area = float(dr.max(shape.surface_area())[0])
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, int(_CANDIDATES * DENSITY * area / apart**2) + 1)
    si = surface_points(shape, sampler.next_2d(), sampler.next_1d())
    points, normals = np.array(si.p).T, np.array(outward(scene, shape, si.p, mi.Vector3f(si.n))).T
    kept = spread(points, normals, apart)
    return points[kept], normals[kept], apart


def at_nodes(points: NDArray, normals: NDArray) -> Any:
    """Return surface interactions at nodes."""
    si: Any = dr.zeros(mi.SurfaceInteraction3f, len(points))
    si.p, si.n = mi.Point3f(points.T), mi.Normal3f(normals.T)
    si.sh_frame = mi.Frame3f(mi.Vector3f(si.n))
    return si
