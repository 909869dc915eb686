"""Values that differ from place to place of an object: means over what was found at random points, on a grid.

Means over few points are noisy, over many they are blurred. Here each place has the width that it needs: beginning with
the mean over the whole object, means over less and less around it take over where they differ by more than noise does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

CELLS = 48  # along the longest side
SCALES = (8.0, 4.0, 2.0)  # cells over which means reach, as standard deviations of a Gaussian
SURE = 2.5  # standard errors that a difference must have


@dataclass(frozen=True)
class Found:
    """What was found at points, [n, 3]: `values` per `weights`, both [n, channels], to the given `power`."""

    points: np.ndarray
    values: np.ndarray
    weights: np.ndarray
    power: float = 1.0


class Grid:
    """A grid around an object, for means over points near each corner of its cells.

    Both sides of a thin part share their cells: they see the same surfaces.
    """

    def __init__(self, bbox: Any) -> None:
        """Lay the grid."""
        self.low, size = np.array(bbox.min).ravel(), np.array(bbox.extents()).ravel()
        self.cell = max(float(size.max()), 1e-9) / CELLS
        self.counts = np.maximum(np.ceil(size / self.cell).astype(int) + 1, 2)

    def logarithm(self, *found: Found) -> np.ndarray:
        """Return log2 of the product of all that was `found`: [z, y, x, channels]."""
        sums = [self._sums(one) for one in found]
        result = sum(
            one.power * np.nan_to_num(_log2_ratio(one.values.sum(0), one.weights.sum(0))) for one in found
        )
        for scale in SCALES:
            here, variance = 0.0, 0.0
            for one, (values, weights, squares) in zip(found, sums, strict=True):
                below = _blurred(weights, scale)
                here = here + one.power * _log2_ratio(_blurred(values, scale), below)
                # a Gaussian's square is a narrower one
                spread = _blurred(squares, scale / math.sqrt(2.0)) * (4.0 * math.pi * scale**2) ** -1.5
                variance = variance + spread / np.maximum(below, 1e-30) ** 2
            apart = np.where(np.isfinite(here), here, result) - result  # no points are no news
            sure = 1.0 - SURE**2 * variance / np.maximum(apart**2, 1e-30)
            result = result + apart * np.maximum(sure, 0.0)
        return np.broadcast_to(result, (*self.counts[::-1], found[0].values.shape[1]))

    def _sums(self, found: Found) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Add up values, weights, and squares of what makes them differ, in log2, cell by cell."""
        shape = tuple(self.counts[::-1])
        index = np.clip(np.rint((found.points - self.low) / self.cell).astype(int), 0, self.counts - 1)
        flat = np.ravel_multi_index(tuple(index[:, ::-1].T), shape)
        mean = found.values.sum(0) / np.maximum(found.weights.sum(0), 1e-30)
        apart = (found.values / np.maximum(mean, 1e-30) - found.weights) / math.log(2.0)

        def add(parts: np.ndarray) -> np.ndarray:
            sums = [np.bincount(flat, part, math.prod(shape)) for part in parts.T]
            return np.stack(sums, axis=-1).reshape(*shape, -1)

        return add(found.values), add(found.weights), add(apart**2)


def _log2_ratio(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Logarithm, not lower than that of 1e-12; NaN where `below` is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log2(np.maximum(above / np.where(below > 0, below, np.nan), 1e-12))


def _blurred(sums: np.ndarray, scale: float) -> np.ndarray:
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(sums, (scale, scale, scale, 0.0), mode="constant", truncate=3.0)


class Field:
    """The logarithm to base 2 of a quantity, for materials numbered from 1; 0 until something is put there."""

    def __init__(self, count: int) -> None:
        """Begin with zeros."""
        self._grids: list[Any] = [None] * count

    def put(self, number: int, grid: Grid, values: np.ndarray) -> None:
        """Set the values of a material at the corners of a grid: [z, y, x, channels]."""
        if mi.is_spectral:  # a wavelength is not tied to a channel
            values = np.repeat(values.mean(axis=-1, keepdims=True), values.shape[-1], axis=-1)
        tensor = mi.TensorXf(values.astype(np.float32).ravel(), values.shape)
        make: Any = mi.Texture3f
        nearest, clamp = dr.FilterMode.Nearest, dr.WrapMode.Clamp
        texture = make(tensor, use_accel=False, filter_mode=nearest, wrap_mode=clamp)
        # values lie at the corners of cells; a texture has them at the centres of its texels
        scale = [1.0 / (grid.cell * float(n)) for n in grid.counts]
        origin = [float(a) - 0.5 * grid.cell for a in grid.low]
        texels = [1.0 / float(n) for n in grid.counts]
        self._grids[number - 1] = (mi.Point3f(*origin), mi.Vector3f(*scale), mi.Vector3f(*texels), texture)

    def logarithm(self, number: Any, p: Any, jitter: Any) -> Any:
        """Return the value at the corner of the grid that is nearest to `p + jitter`, per channel.

        `jitter`: in cells. Where it is even in (-1/2, 1/2)^3, the mean is the linear interpolation between the corners,
        of which there are eight to read.
        """
        result = mi.Spectrum(0.0)
        for i, one in enumerate(self._grids, start=1):
            if one is not None:
                low, scale, texel, texture = one
                values = texture.eval((p - low) * scale + jitter * texel)
                result = dr.select(number == i, mi.Spectrum(values), result)
        return result
