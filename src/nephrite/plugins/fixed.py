"""Kernels of a measured profile and of slabs; see `nephrite.bssrdf.fixed`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import fixed, kernel
from nephrite.plugins.kernels import Kernels, Place, reduced_extinction, row_of
from nephrite.profiles.measured import MeasuredProfile

_EDGEWISE = 1e-3  # cosine: a rim, at right angles to the face of entry, belongs to it all over


class Measured(Kernels):
    """One profile, or one for each channel, under all surfaces; it gives up what leaves after one event."""

    def __init__(self, entries: list[Any], profiles: tuple[MeasuredProfile, ...]) -> None:
        """Hold the profiles, in mm, for `entry.Entry` objects."""
        super().__init__([fixed.measured(profiles)])
        self._length = _channels([profile.reach() / fixed.PER_REACH for profile in profiles])
        self._total = _channels([profile.albedo() for profile in profiles])
        self._row = _channels(list(range(len(profiles))))
        self._unit = mi.Float([entry.unit for entry in entries])
        self._single = mi.Float([entry.single_share for entry in entries])
        dr.eval(self._unit, self._single)

    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the profile's rows; only the share that it gives up depends on the coefficients."""
        albedo = sigma_s / dr.maximum(sigma_a + sigma_s, 1e-20)
        single = albedo * dr.gather(mi.Float, self._single, number - 1)
        log_scale = dr.log2(dr.gather(mi.Float, self._unit, number - 1) / self._length)
        multiple = dr.maximum(1.0 - single / self._total, 1e-30)
        return Place(mi.UInt32(0), self._row, log_scale, 2.0 * log_scale + dr.log2(multiple))


class Slabs(Kernels):
    """The multipole for plates and sheets of a given thickness: rows by reduced albedo and by thickness."""

    def __init__(self, entries: list[Any], thickness: float) -> None:
        """Make the tables for `entry.Entry` objects; `thickness` in mm."""
        self._thickness = mi.Float([thickness / entry.unit for entry in entries])
        tables, firsts, nodes = [], [0], []
        for entry, across in zip(entries, self._thickness, strict=True):
            deep = _nodes(entry, across)
            tables.append(fixed.slabs(deep, entry.eta, entry.g))
            firsts.append(firsts[-1] + len(tables[-1].poles))
            nodes.append((deep[0], len(deep)))
        super().__init__(tables)
        self._first = mi.UInt32(firsts)
        self._least = mi.Float([least for least, _ in nodes])
        self._last = mi.Float([count - 1.001 for _, count in nodes])
        dr.eval(self._thickness, self._first, self._least, self._last)

    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the rows of the face of entry, for the thickness below."""
        extinction = reduced_extinction(sigma_a, sigma_s, g)
        across, least, last = (
            dr.gather(mi.Float, column, number - 1) for column in (self._thickness, self._least, self._last)
        )
        deep = dr.maximum(across * extinction / least, 1.0)
        at = dr.minimum(dr.log2(deep) * fixed.AN_OCTAVE, last)
        below = dr.floor(at)
        # the light that crosses a slab falls off as e to its thickness: even between nodes is even in the thickness
        between = (deep * dr.exp2(-below / fixed.AN_OCTAVE) - 1.0) / (2.0 ** (1.0 / fixed.AN_OCTAVE) - 1.0)
        log_scale = mi.Spectrum(dr.log2(extinction))
        return Place(
            dr.gather(mi.UInt32, self._first, number - 1),
            mi.Spectrum(below * 2.0 * kernel.ROWS + row_of(sigma_a, sigma_s, extinction)),
            log_scale,
            2.0 * log_scale,
            across,
            mi.Spectrum(dr.minimum(between, 1.0)),
        )

    def seen(self, place: Place, offset: Any, n_o: Any, n_i: Any) -> Any:
        """As above; on the far side light has crossed the slab, and the profile's distance is that along it."""
        far = dr.dot(n_i, n_o) < -_EDGEWISE
        squared = dr.squared_norm(offset)
        along = dr.sqrt(dr.maximum(squared - dr.select(far, dr.square(place.thickness), 0.0), 0.0))
        face = place.first + dr.select(far, mi.UInt32(kernel.ROWS), 0)
        below, above = (
            self.log_kernel(replace(place, first=face + rows), along) for rows in (0, 2 * kernel.ROWS)
        )
        return dr.lerp(below, above, place.between)


def _channels(values: list[float]) -> Any:
    """Return one number for each channel, or one for all."""
    return mi.Spectrum(values if len(values) > 1 else values[0])


def _nodes(entry: Any, across: float) -> tuple[float, ...]:
    """Return thicknesses for the coefficients of a material, which may vary, in reduced mean free paths."""
    absorbed, scattered = entry.sampled_coefficients()
    deep = across * (absorbed + scattered * (1.0 - entry.g))
    return fixed.thicknesses(float(deep.min()), float(deep.max()))
