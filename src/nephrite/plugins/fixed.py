"""Kernels of a measured profile and of slabs; see `nephrite.bssrdf.fixed`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.bssrdf import fixed
from nephrite.errors import ParameterError
from nephrite.plugins.kernels import Kernels, Place, reduced_extinction
from nephrite.profiles.measured import MeasuredProfile

_EDGEWISE = 1e-3  # cosine: a rim, at right angles to the face of entry, belongs to it all over


class Measured(Kernels):
    """One profile, or one for each channel, under all surfaces; it gives up what leaves after one event."""

    def __init__(self, entries: list[Any], profiles: tuple[MeasuredProfile, ...]) -> None:
        """Hold the profiles, in mm, for `media.Entry` objects."""
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
    """The multipole for plates and sheets of a given thickness, of one medium each: two rows for each channel."""

    def __init__(self, entries: list[Any], thickness: float) -> None:
        """Make the tables for `media.Entry` objects; `thickness` in mm.

        Raises `ParameterError` for coefficients that vary.
        """
        self._thickness = mi.Float([thickness / entry.unit for entry in entries])
        tables = []
        for entry, across in zip(entries, self._thickness, strict=True):
            for sigma_a, sigma_s in zip(*_constants(entry), strict=True):
                extinction = max(sigma_a + sigma_s * (1.0 - entry.g), 1e-20)
                albedo = sigma_s * (1.0 - entry.g) / extinction
                tables.append(fixed.slab(albedo, across * extinction, entry.eta, entry.g))
        super().__init__(tables)
        dr.eval(self._thickness)

    def place(self, number: Any, sigma_a: Any, sigma_s: Any, g: Any) -> Place:
        """Find the rows of the face of entry."""
        log_scale = mi.Spectrum(dr.log2(reduced_extinction(sigma_a, sigma_s, g)))
        count = len(log_scale)
        return Place(
            (number - 1) * 2 * count,
            mi.Spectrum([2.0 * i for i in range(count)]),
            log_scale,
            2.0 * log_scale,
            dr.gather(mi.Float, self._thickness, number - 1),
        )

    def seen(self, place: Place, offset: Any, n_o: Any, n_i: Any) -> Any:
        """As above; on the far side light has crossed the slab, and the profile's distance is that along it."""
        far = dr.dot(n_i, n_o) < -_EDGEWISE
        squared = dr.squared_norm(offset)
        along = dr.sqrt(dr.maximum(squared - dr.select(far, dr.square(place.thickness), 0.0), 0.0))
        return self.log_kernel(replace(place, first=place.first + dr.select(far, mi.UInt32(1), 0)), along)


def _channels(values: list[float]) -> Any:
    """Return one number for each channel, or one for all."""
    return mi.Spectrum(values if len(values) > 1 else values[0])


def _constants(entry: Any) -> list[list[float]]:
    """Return sigma_a and sigma_s of each channel, per scene unit."""
    if entry.varies:
        raise ParameterError(
            f"the coefficients of {entry.name} vary over its surface, but a multipole with a thickness is made for one "
            "medium: give it constant coefficients, leave out thickness, or use the model walk or tabulated."
        )
    return [
        [float(np.ravel(channel)[0]) for channel in values]
        for values in entry.coefficients(dr.zeros(mi.SurfaceInteraction3f), True)
    ]
