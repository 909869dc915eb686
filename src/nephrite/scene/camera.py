"""Cameras: one that frames an object, and the benchmark's."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

FIELD_OF_VIEW = 38.0  # degrees, across the larger side of the picture
MARGIN = 0.08  # of the picture, kept free on each side of the object
TOWARDS_CAMERA = (0.25, 0.42, 1.75)  # from the object; not normalised


def framing(vertices: ArrayLike, resolution: tuple[int, int]) -> dict[str, Any]:
    """Return a perspective camera that shows all `vertices` (N, 3) as large as `MARGIN` allows, centred.

    It looks from `TOWARDS_CAMERA`, so objects that face +z are seen from the front and a little above.
    """
    points = np.asarray(vertices, dtype=float)
    towards = np.asarray(TOWARDS_CAMERA) / np.linalg.norm(TOWARDS_CAMERA)
    right = np.cross((0.0, 1.0, 0.0), towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    x, y, depth = np.stack([right, up, towards]) @ points.T

    # A camera at height h and distance d sees y - h <= slope (d - depth) and h - y <= slope (d - depth).
    distance, aside = 0.0, []
    for offset, slope in zip((x, y), _slopes(resolution), strict=True):
        reach = slope * (1 - 2 * MARGIN)
        highest, lowest = np.max(offset + reach * depth), np.min(offset - reach * depth)
        distance = max(distance, float(highest - lowest) / (2 * reach))
        aside.append((highest + lowest) / 2)
    start = aside[0] * right + aside[1] * up
    middle = (depth.min() + depth.max()) / 2
    return sensor(start + distance * towards, start + middle * towards, resolution)


def benchmark(size_mm: float, resolution: tuple[int, int]) -> dict[str, Any]:
    """Return the camera of benchmark scene B1 for an object of `size_mm`."""
    return sensor(size_mm * np.array((0.25, 0.75, 1.75)), size_mm * np.array((0.0, 0.33, 0.0)), resolution)


def sensor(origin: ArrayLike, target: ArrayLike, resolution: tuple[int, int]) -> dict[str, Any]:
    """Return a perspective sensor at `origin` that looks at `target`, with a box-filtered linear RGB film."""
    import mitsuba as mi

    start, end = np.asarray(origin, dtype=float), np.asarray(target, dtype=float)
    distance = float(np.linalg.norm(end - start))
    width, height = resolution
    return {
        "type": "perspective",
        "fov": FIELD_OF_VIEW,
        "fov_axis": "larger",
        "near_clip": distance * 1e-3,
        "far_clip": distance * 1e3,
        "to_world": mi.ScalarTransform4f().look_at(origin=start.tolist(), target=end.tolist(), up=[0, 1, 0]),
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "pixel_format": "luminance" if mi.is_monochromatic else "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }


def _slopes(resolution: tuple[int, int]) -> tuple[float, float]:
    """Tangents of half the field of view across and down the picture."""
    width, height = resolution
    larger = math.tan(math.radians(FIELD_OF_VIEW) / 2)
    return larger * width / max(resolution), larger * height / max(resolution)
