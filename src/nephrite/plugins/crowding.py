"""How crowded the surface is around a point: light that jumps would bring there, over all that there is.

A kernel knows distances on a plane only. In a fold, or on both sides of a thin part, more surface lies within reach
than on a plane, and the jumps would bring more light than arrives. The crowding e(x) is the ratio where that is so, and
1 elsewhere. A jump between x and y is divided by the greater of e(x) and e(y): then no point sends out more than
arrives, and light between two points stays reciprocal.

e is estimated at random points and kept, per channel, on a grid around the object, of which a cell is a few per cent of
its length: front and back of a thin part share it, as they see the same surfaces.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

CELLS = 48  # along the longest side
MOST = 0.985  # of the light that arrives: what is left covers the estimate's noise


class Crowding:
    """The logarithm to base 2 of e, for materials numbered from 1; 0 until something is added."""

    def __init__(self, count: int) -> None:
        """Begin with planes everywhere."""
        self._grids: list[Any] = [None] * count

    def logarithm(self, number: Any, p: Any) -> Any:
        """Return log2 e at points, per channel."""
        result = mi.Spectrum(0.0)
        for i, grid in enumerate(self._grids, start=1):
            if grid is not None:
                low, scale, texture = grid
                values = texture.eval((p - low) * scale)
                result = dr.select(number == i, mi.Spectrum(values), result)
        return result

    def estimate(self, number: int, bbox: Any, points: np.ndarray, ratios: np.ndarray) -> None:
        """Take e from estimates at points, [n, 3] and [n, channels], for the material `number`."""
        low, size = np.array(bbox.min).ravel(), np.array(bbox.extents()).ravel()
        cell = max(float(size.max()), 1e-9) / CELLS
        counts = np.maximum(np.ceil(size / cell).astype(int) + 1, 2)
        index = np.clip(np.rint((points - low) / cell).astype(int), 0, counts - 1)
        flat = (index[:, 2] * counts[1] + index[:, 1]) * counts[0] + index[:, 0]
        smooth = _smoother(flat, counts[::-1])
        weight = smooth(np.ones(len(flat)))
        known = weight > 1e-3
        channels = [np.where(known, smooth(channel) / np.maximum(weight, 1e-3), 1.0) for channel in ratios.T]
        if mi.is_spectral:  # a wavelength is not tied to a channel
            channels = [np.mean(channels, axis=0)] * len(channels)
        values = np.log2(np.maximum(np.stack(channels, axis=-1) / MOST, 1.0)).astype(np.float32)
        tensor = mi.TensorXf(values.ravel(), values.shape)
        make: Any = mi.Texture3f
        texture = make(tensor, use_accel=False, wrap_mode=dr.WrapMode.Clamp)
        # values lie at the corners of cells; a texture has them at the centres of its texels
        scale = [1.0 / (cell * float(n)) for n in counts]
        origin = [float(a) - 0.5 * cell for a in low]
        self._grids[number - 1] = (mi.Point3f(*origin), mi.Vector3f(*scale), texture)


def _smoother(flat: np.ndarray, shape: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function that adds values up in cells and spreads them over neighbours."""
    from scipy.ndimage import gaussian_filter

    def smooth(values: np.ndarray) -> np.ndarray:
        total = np.bincount(flat, weights=values, minlength=int(np.prod(shape))).reshape(shape)
        return gaussian_filter(total, 1.0, mode="constant", truncate=3.0)

    return smooth
