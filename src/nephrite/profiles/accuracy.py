"""How far models are from the truth: light in rings around its entry, simulated, and as the models have it.

Light enters a half-space diffusely, as it does in renders, and all of it that has scattered is compared. A model of
multiple scattering alone is given the single scattering that the simulation finds, for that is what renders add to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nephrite.physics import searchlight
from nephrite.physics.medium import Medium
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["Comparison", "Truth", "compare", "rings", "simulate"]

_RADII = (1e-3, 1e5, 80)  # first and last edge, in mean free paths, and number of the rings: ten a decade
_NODES = 6


@dataclass(frozen=True)
class Truth:
    """What a simulation says of one colour channel; shares are of the light that has entered.

    `edges`: of the rings, (K + 1,), in mm, from 0 to infinity. `light`, `error`: share that leaves in each ring and its
    standard error, (K,); `single`: the part that has scattered once. `total`, `total_error`: all that leaves.
    """

    edges: NDArray[np.float64]
    light: NDArray[np.float64]
    error: NDArray[np.float64]
    single: NDArray[np.float64]
    total: float
    total_error: float

    @property
    def area(self) -> NDArray[np.float64]:
        """Areas of the rings, (K,), in mm^2: `light / area` is R(r), averaged over the ring."""
        return math.pi * np.diff(self.edges**2)

    @property
    def noise(self) -> float:
        """What `Comparison.profile_error` is of a perfect model: the noise of the simulation."""
        return float(self.error.sum() * math.sqrt(2.0 / math.pi) / self.total)


@dataclass(frozen=True)
class Comparison:
    """A model beside the truth, for one channel.

    `light`: share in each of its rings, (K,). `total_error`: of all that leaves, relative. `profile_error`: the L1
    distance of 2 pi r R(r), ring by ring, relative to all that leaves.
    """

    light: NDArray[np.float64]
    total_error: float
    profile_error: float


def simulate(medium: Medium, paths: int, seed: int = 0) -> list[Truth | None]:
    """Simulate a medium's half-space: one `Truth` for each channel, None for a channel that does not scatter.

    `paths`: photons; one simulation serves all channels, whose mean free paths are the unit of its lengths.
    """
    light = searchlight.simulate(
        medium.eta, medium.g, incidence="diffuse", paths=paths, seed=seed, radii=_RADII
    )
    albedos = np.array(medium.albedo)
    every, once, total = (
        light.profile(albedos, first=1),
        light.profile(albedos, first=1, last=1),
        light.total(albedos, first=1),
    )
    return [
        Truth(
            every.edges * mfp, every.value[i], every.error[i], once.value[i],
            float(total.value[i]), float(total.error[i]),
        )
        if albedos[i] > 0.0
        else None
        for i, mfp in enumerate(medium.mfp)
    ]  # fmt: skip


def compare(model: Model, medium: Medium, channel: int, truth: Truth) -> Comparison:
    """Compare a model's profile of one channel with the truth about it."""
    profile = model.make(medium.sigma_a[channel], medium.sigma_s_prime[channel], medium.eta, medium.g)
    light = rings(profile, truth.edges)
    if model.terms == "multiple":
        light = light + truth.single
    total_error = light.sum() / truth.total - 1.0
    return Comparison(light, float(total_error), float(np.abs(light - truth.light).sum() / truth.total))


def rings(profile: RadialProfile, edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Integrate 2 pi r R(r) over rings; `edges`, (K + 1,), begin with 0 and end with infinity. Returns (K,)."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    inner, outer = edges[1:-2, None], edges[2:-1, None]
    r = inner * (outer / inner) ** nodes
    within = 2.0 * math.pi * np.log(outer / inner)[:, 0] * ((r * r * np.asarray(profile.eval(r))) @ weights)
    r = edges[1] * nodes
    middle = 2.0 * math.pi * edges[1] * float((r * np.asarray(profile.eval(r))) @ weights)
    return np.concatenate([[middle], within, [max(profile.albedo() - middle - within.sum(), 0.0)]])
