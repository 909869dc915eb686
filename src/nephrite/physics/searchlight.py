"""Searchlights: where light that enters a half-space or slab at one point leaves it, simulated photon by photon.

The ground truth of the radial profiles: exact transport, Henyey-Greenstein scattering and a smooth interface with
Fresnel's reflectance, and no code in common with the integrator. One simulation serves every albedo: a path of n events
weighs albedo^n, so exits are counted by n (Graaff et al. 1993), in bins of their own up to n = 128.

Lengths are mean free paths `1/sigma_t`; `1 - albedo g` of them are a reduced one, `1/sigma_t'`. Light is counted per
light that has *entered*: the fraction `specular` of what arrives never does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics import fresnel
from nephrite.physics.phase import check_g
from nephrite.physics.searchlight_walk import EXACT_ORDERS, Counts, Setting, representative_orders, trace

__all__ = ["Estimate", "Histogram", "Searchlight", "simulate"]


class Estimate(NamedTuple):
    """A share of the light that has entered, and its standard error; arrays of the albedo's shape."""

    value: Any
    error: Any


class Histogram(NamedTuple):
    """Shares [..., K] between `edges` [K + 1] with standard errors; leading axes are the albedo's."""

    edges: np.ndarray
    value: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class Searchlight:
    """Result of `simulate`. Every method takes the albedo sigma_s/sigma_t in [0, 1], a number or an array.

    `transmitted` asks for the far side of a slab. `first`, `last`: least and greatest order of scattering that counts,
    each at most 128; `last=None` is no limit.
    """

    setting: Setting
    specular: float
    counts: Counts

    def total(
        self, albedo: Any, transmitted: bool = False, first: int = 0, last: int | None = None
    ) -> Estimate:
        """Share that leaves anywhere, in any direction."""
        sums = self.counts.rings[int(transmitted)].sum(axis=-1)
        return Estimate(*self._weighted(sums, albedo, first, last))

    def profile(
        self, albedo: Any, transmitted: bool = False, first: int = 0, last: int | None = None
    ) -> Histogram:
        """Share that leaves in each ring around the beam: R(r) integrated over the ring's area.

        `edges` begin with 0 and end with infinity.
        """
        value, error = self._weighted(self.counts.rings[int(transmitted)], albedo, first, last)
        return Histogram(np.concatenate([[0.0], self.setting.radii, [math.inf]]), value, error)

    def directions(
        self, albedo: Any, transmitted: bool = False, first: int = 0, last: int | None = None
    ) -> Histogram:
        """Share that leaves in each bin of the squared sine to the normal, outside; even shares are a Lambert lobe."""
        value, error = self._weighted(self.counts.sines[int(transmitted)], albedo, first, last)
        return Histogram(np.linspace(0.0, 1.0, self.setting.directions + 1), value, error)

    def cut(self, albedo: Any) -> Any:
        """Share that was inside after `longest` events, when the walk was ended: an upper limit of what is missing."""
        return (
            np.asarray(albedo, dtype=np.float64) ** self.setting.longest * self.counts.cut / self.counts.paths
        )

    def _weighted(
        self, sums: np.ndarray, albedo: Any, first: int, last: int | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard error over the walks of albedo^order, summed over the axis of orders."""
        for name, limit in (("first", first), ("last", last)):
            if limit is not None and not 0 <= limit <= EXACT_ORDERS:
                raise ParameterError(
                    f"{name} is {limit}, but orders are told apart from 0 to {EXACT_ORDERS} only."
                )
        orders = representative_orders(sums.shape[1])
        albedo = np.asarray(albedo, dtype=np.float64)
        weights = albedo[..., None] ** orders
        weights = weights * ((orders >= first) & (orders <= (math.inf if last is None else last)))
        paths = self.counts.paths
        mean = np.tensordot(weights, sums[0], axes=1) / paths
        squares = np.tensordot(weights**2, sums[1], axes=1) / paths
        return mean, np.sqrt(np.maximum(squares - mean**2, 0.0) / paths)


def simulate(
    eta: float = 1.0,
    g: float = 0.0,
    thickness: float = math.inf,
    *,
    incidence: str | float = "normal",
    beam_radius: float = 0.0,
    paths: int = 2**20,
    seed: int = 0,
    longest: int = 2**20,
    radii: tuple[float, float, int] = (1e-4, 1e4, 160),
    directions: int = 20,
) -> Searchlight:
    """Trace photons that enter a half-space, or a slab of finite `thickness`, at the origin.

    `eta`: inside / outside, the same on both sides of a slab. `g`: mean cosine. `thickness`, `beam_radius`, `radii`: in
    mean free paths 1/sigma_t. `incidence`: "normal", "diffuse" (equal radiance from every direction outside), or the
    cosine outside of a slanted beam. `beam_radius`: where the irradiance of a Gaussian beam has fallen to 1/e^2 (0: a
    pencil). `paths`: walks, rounded up to a whole number a lane. `longest`: events after which a walk is ended, see
    `Searchlight.cut`. `radii`: first and last edge and number of the rings, even in log r. `directions`: bins of the
    squared sine outside. The same seed gives the same result. Raises `ParameterError`.
    """
    eta, g = fresnel.check_eta(eta), check_g(g)
    if incidence not in ("normal", "diffuse"):
        cosine = incidence if isinstance(incidence, (int, float)) else math.nan
        if not 0.0 < cosine <= 1.0 or fresnel.reflectance(cosine, eta) == 1.0:
            raise ParameterError(
                f"incidence is {incidence!r}: it is 'normal', 'diffuse', or the cosine in (0, 1] of light that is not "
                "totally reflected."
            )
    if not thickness > 0.0 or beam_radius < 0.0:
        raise ParameterError(
            f"thickness is {thickness!r} and beam_radius {beam_radius!r} mean free paths: the first must be above 0 "
            "(math.inf for a half-space), the second not negative."
        )
    if paths < 1 or longest < 1 or directions < 1 or not (0.0 < radii[0] < radii[1] and radii[2] >= 1):
        raise ParameterError(
            f"paths = {paths}, longest = {longest}, directions = {directions}, radii = {radii}: there must be at least "
            "one of each, and radii from a positive one to a greater one."
        )
    edges = np.geomspace(*radii[:2], radii[2] + 1)
    setting = Setting(eta, g, float(thickness), incidence, beam_radius, longest, edges, directions)
    if incidence == "diffuse":
        specular = fresnel.external_diffuse_reflectance(eta)
    else:
        specular = fresnel.reflectance(1.0 if incidence == "normal" else float(incidence), eta)
    return Searchlight(setting, specular, trace(setting, int(paths), int(seed)))
