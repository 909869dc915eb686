"""The jump's kernels of all materials, in tables that a wavefront looks up; see `nephrite.bssrdf.kernel`.

Where coefficients vary over the surface, the kernel is the geometric mean of those at its two ends: light between two
points stays reciprocal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.bssrdf import finite, kernel
from nephrite.profiles import models


@dataclass
class Place:
    """Where to look for a point's kernel: first row of its material; row, and log2 of sigma_t', per channel."""

    first: Any
    row: Any
    log_scale: Any


class Kernels:
    """Tables of the materials numbered from 1, and lookups in them; lengths in scene units."""

    def __init__(self, entries: list[Any], model: str) -> None:
        """Look up the tables of a diffusion model for `media.Entry` objects."""
        self.finite = models.find(model).finite
        tables = [kernel.tabulated(model, entry.eta, entry.g) for entry in entries]
        self._corners = _flat([_corners(table.log_kernel) for table in tables])
        self._poles = _flat([np.pad(table.poles, ((0, 0), (0, 1))) for table in tables])
        dr.eval(self._corners, self._poles)

    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the rows for the coefficients of material `number`, per channel."""
        extinction = dr.maximum(sigma_a + sigma_s * (1.0 - g), 1e-20)
        absorbed = dr.select(sigma_s > 0, dr.minimum(sigma_a / extinction, 1.0), 1.0)
        row = dr.sqrt(dr.sqrt(absorbed)) * (kernel.ROWS - 1.0)
        return Place((number - 1) * kernel.ROWS, mi.Spectrum(row), mi.Spectrum(dr.log2(extinction)))

    def core(self, place: Place) -> Any:
        """Longest reduced mean free path of the channels."""
        return dr.exp2(-dr.min(place.log_scale))

    def facing(self, place: Place, there: Any, offset: Any, n_o: Any, n_i: Any) -> Any:
        """Light between two points of a body over that on a plane, per channel; see `finite.facing`.

        `there` as in `jump.visit`: sigma_tr is the mean of those at both ends.
        """
        sigma_tr = _sigma_tr(place)
        if there is not None:
            sigma_tr = 0.5 * (sigma_tr + _sigma_tr(there))
        return finite.facing(offset, n_o, n_i, sigma_tr)

    def log_kernel(self, place: Place, r: Any) -> Any:
        """Logarithm to base 2 of the kernel at the distance `r`, per channel."""
        found = []
        log_r = dr.log2(r)
        for row, log_scale in zip(place.row, place.log_scale, strict=True):
            x = dr.clip((log_r + log_scale - kernel.FIRST) / kernel.STEP, 0.0, kernel.EDGES - 1.001)
            bin_, low = mi.UInt32(x), dr.minimum(mi.UInt32(row), kernel.ROWS - 2)
            u, v = x - mi.Float(bin_), row - mi.Float(low)
            c: Any = dr.gather(_four(), self._corners, (place.first + low) * (kernel.EDGES - 1) + bin_)
            value = dr.lerp(dr.lerp(c[0], c[1], u), dr.lerp(c[2], c[3], u), v)
            found.append(value + 2.0 * log_scale)
        return mi.Spectrum(found)

    def poles(self, place: Place) -> list[tuple[Any, Any, Any]]:
        """Return depths of the two poles, and the share of the first, for each channel."""
        found = []
        for row, log_scale in zip(place.row, place.log_scale, strict=True):
            pair: Any = dr.gather(_four(), self._poles, place.first + mi.UInt32(row + 0.5))
            mfp = dr.exp2(-log_scale)
            found.append((pair[0] * mfp, pair[1] * mfp, pair[2]))
        return found


def _sigma_tr(place: Place) -> Any:
    """`sqrt(3 (1 - a')) sigma_t'`, of which rows hold the fourth root of 1 - a'."""
    return math.sqrt(3.0) * dr.square(place.row / (kernel.ROWS - 1.0)) * dr.exp2(place.log_scale)


def _corners(values: np.ndarray) -> np.ndarray:
    """Return the values at the four corners of each cell between rows and edges: [ROWS, EDGES - 1, 4]."""
    below = np.concatenate([values[1:], values[-1:]])
    return np.stack([values[:, :-1], values[:, 1:], below[:, :-1], below[:, 1:]], axis=-1)


def _four() -> Any:
    return mi.Vector4f


def _flat(tables: list[np.ndarray]) -> Any:
    return mi.Float(np.concatenate([table.ravel() for table in tables]).astype(np.float32))
