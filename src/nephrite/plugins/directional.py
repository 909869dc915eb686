"""The directional dipole on top of a jump: how its light depends on the directions, point by point.

A jump is drawn from the standard dipole's kernel. What it brings is then multiplied by what the directional dipole of
Frisvad et al. (2014) sends between the two points, over what the standard one does.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.profiles import StandardDipole
from nephrite.profiles.directional import DirectionalDipole, ReciprocalDirectionalDipole

MODELS = {"directional": DirectionalDipole, "directional_reciprocal": ReciprocalDirectionalDipole}

_MOST = 20.0  # times the standard dipole: nearer to a source than diffusion holds for, the ratio has no bound


class Directional:
    """The chosen variant of the model, for materials numbered from 1."""

    def __init__(self, entries: list[Any], model: str) -> None:
        """Hold what is needed of `entry.Entry` objects."""
        self._constants = [(entry.eta, entry.g, entry.boundary) for entry in entries]
        self._make = MODELS[model]

    def ratio(
        self,
        number: Any,
        sigma_a: Any,
        sigma_s: Any,
        x_o: Any,
        n_o: Any,
        w_o: Any,
        x_i: Any,
        n_i: Any,
        w_i: Any,
    ) -> Any:
        """Light from `w_i` that enters at `x_i` and leaves at `x_o` toward `w_o`, over the standard dipole's.

        Unit vectors that point outward; coefficients and result per channel.
        """
        result = mi.Spectrum(1.0)
        distance = dr.norm(x_o - x_i)
        for i, (eta, g, boundary) in enumerate(self._constants, start=1):
            reduced = sigma_s * (1.0 - g)
            model = self._make(sigma_a, reduced, eta, g)
            sent = model.exitance(x_i, n_i, w_i, x_o, n_o, w_o)
            usual = StandardDipole(sigma_a, reduced, boundary).eval(distance)
            value = dr.minimum(sent / dr.maximum(usual, 1e-30), _MOST)
            result = dr.select(number == i, mi.Spectrum(value), result)
        return result
