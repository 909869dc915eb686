"""Nodes of a plane, for tests of what is carried between them."""

import numpy as np

from nephrite.transport.nodes import spread


def plane(spacing):
    """Return nodes on the square from -1 to 1 in the plane z = 0, and their normals."""
    points = np.column_stack([np.random.default_rng(1).uniform(-1, 1, (8_000, 2)), np.zeros(8_000)])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    kept = spread(points, normals, spacing)
    return points[kept], normals[kept]
