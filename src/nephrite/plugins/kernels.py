"""The jump's kernels of all materials, in tables that a wavefront looks up; see `nephrite.bssrdf.kernel`.

Where coefficients vary over the surface, the kernel is the geometric mean of those at its two ends: light between two
points stays reciprocal.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.bssrdf import finite, kernel
from nephrite.profiles import models

_ALIGNED = 64  # bytes


@dataclass
class Place:
    """Where to look for a point's kernel: first row of its material; the others per channel.

    `row`: from the first; `log_scale`: log2 of the table's lengths per scene unit; `log_gain`: log2 of what its values
    are multiplied by. Of a slab: `thickness`, in scene units, and `between`, how far it is from the thickness of
    these rows, 0, to the next one, 1.
    """

    first: Any
    row: Any
    log_scale: Any
    log_gain: Any
    thickness: Any = 0.0
    between: Any = 0.0


class Kernels(ABC):
    """Tables of the materials numbered from 1, and lookups in them; lengths in scene units.

    `finite`: whether the light is fitted to the object, see `balance`.
    """

    finite = False

    def __init__(self, tables: list[kernel.Table]) -> None:
        """Put the tables' rows on the device, one after the other."""
        self._corners = _flat([_corners(table.log_kernel) for table in tables])
        self._poles = _flat([np.pad(table.poles, ((0, 0), (0, 1))) for table in tables])
        dr.eval(self._corners, self._poles)

    @abstractmethod
    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the rows for the coefficients of material `number`, per channel."""

    def core(self, place: Place) -> Any:
        """Longest reduced mean free path of the channels."""
        return dr.exp2(-dr.min(place.log_scale))

    def between(self, place: Place, there: Any, offset: Any, n_o: Any, n_i: Any) -> Any:
        """Logarithm to base 2 of the kernel between two points, per channel.

        `place`, `there`: where to look for the kernels at the two points; None if they are the same. `offset`: from the
        first to the second; `n_o`, `n_i`: unit normals there, outward.
        """
        result = self.seen(place, offset, n_o, n_i)
        return result if there is None else 0.5 * (result + self.seen(there, offset, n_o, n_i))

    def seen(self, place: Place, offset: Any, n_o: Any, n_i: Any) -> Any:
        """Return what `between` does for the kernel of one place: here, of the distance alone."""
        return self.log_kernel(place, dr.norm(offset))

    def log_kernel(self, place: Place, r: Any) -> Any:
        """Logarithm to base 2 of the kernel at the distance `r`, per channel."""
        found = []
        log_r = dr.log2(r)
        for row, log_scale, gain in zip(place.row, place.log_scale, place.log_gain, strict=True):
            x = dr.clip((log_r + log_scale - kernel.FIRST) / kernel.STEP, 0.0, kernel.EDGES - 1.001)
            bin_, low = mi.UInt32(x), mi.UInt32(row)
            u, v = x - mi.Float(bin_), row - mi.Float(low)
            c: Any = dr.gather(_four(), self._corners, (place.first + low) * (kernel.EDGES - 1) + bin_)
            value = dr.lerp(dr.lerp(c[0], c[1], u), dr.lerp(c[2], c[3], u), v)
            found.append(value + gain)
        return mi.Spectrum(found)

    def poles(self, place: Place) -> list[tuple[Any, Any, Any]]:
        """Return depths of the two poles, and the share of the first, for each channel."""
        found = []
        for row, log_scale in zip(place.row, place.log_scale, strict=True):
            pair: Any = dr.gather(_four(), self._poles, place.first + mi.UInt32(row + 0.5))
            mfp = dr.exp2(-log_scale)
            found.append((pair[0] * mfp, pair[1] * mfp, pair[2]))
        return found


class HalfSpaces(Kernels):
    """Kernels of a diffusion model in `nephrite.profiles.models`, by reduced albedo."""

    def __init__(self, entries: list[Any], model: str) -> None:
        """Look up the tables for `entry.Entry` objects."""
        self.finite = models.find(model).finite
        super().__init__([kernel.tabulated(model, entry.eta, entry.g) for entry in entries])

    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the rows for the coefficients of material `number`, per channel."""
        extinction = reduced_extinction(sigma_a, sigma_s, g)
        row, log_scale = row_of(sigma_a, sigma_s, extinction), mi.Spectrum(dr.log2(extinction))
        return Place((number - 1) * kernel.ROWS, row, log_scale, 2.0 * log_scale)

    def seen(self, place: Place, offset: Any, n_o: Any, n_i: Any) -> Any:
        """As above; a finite model knows where the surface is seen through the body."""
        result = super().seen(place, offset, n_o, n_i)
        if not self.finite:
            return result
        # sqrt(3 (1 - a')) sigma_t', of which rows hold the fourth root of 1 - a'
        sigma_tr = math.sqrt(3.0) * dr.square(place.row / (kernel.ROWS - 1.0)) * dr.exp2(place.log_scale)
        return result + dr.log2(finite.facing(offset, n_o, n_i, sigma_tr))


def reduced_extinction(sigma_a: Any, sigma_s: Any, g: Any) -> Any:
    """Return sigma_t', above 0."""
    return dr.maximum(sigma_a + sigma_s * (1.0 - g), 1e-20)


def row_of(sigma_a: Any, sigma_s: Any, extinction: Any) -> Any:
    """Return where a table by reduced albedo has these coefficients, from 0 to below `ROWS - 1`, per channel."""
    absorbed = dr.select(sigma_s > 0, dr.minimum(sigma_a / extinction, 1.0), 1.0)
    return mi.Spectrum(dr.minimum(dr.sqrt(dr.sqrt(absorbed)) * (kernel.ROWS - 1.0), kernel.ROWS - 1.001))


def _corners(values: np.ndarray) -> np.ndarray:
    """Return the values at the four corners of each cell between rows and edges: [ROWS, EDGES - 1, 4]."""
    below = np.concatenate([values[1:], values[-1:]])
    return np.stack([values[:, :-1], values[:, 1:], below[:, :-1], below[:, 1:]], axis=-1)


def _four() -> Any:
    return mi.Vector4f


def _flat(tables: list[np.ndarray]) -> Any:
    """Return all tables in one array whose address is a multiple of `_ALIGNED`.

    From there Dr.Jit gathers four numbers at once. From elsewhere it gathers them one by one, by another kernel, which
    is compiled anew whenever chance has it.
    """
    count = sum(table.size for table in tables)
    space = np.empty(count + _ALIGNED // 4, np.float32)
    first = -space.ctypes.data % _ALIGNED // 4
    flat = space[first : first + count]
    np.concatenate([table.ravel() for table in tables], out=flat, casting="same_kind")
    return mi.Float(flat)
