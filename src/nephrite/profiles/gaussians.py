"""Sums of Gaussians, as game engines use them: cheap to blur with, exact to sample, fitted to any other profile.

`R(r) = sum_i w_i e^(-r^2 / (2 v_i)) / (2 pi v_i)` (d'Eon and Luebke 2007): each term's integral is its weight. The
variances are fixed, even in their logarithm, and the weights the non-negative least squares fit of 2 pi r R over ln(r),
scaled to the total of what is fitted. `make` fits photon beam diffusion for a row of albedos and interpolates the
weights, so that textures can go through it and derivatives exist.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike, checked, lift
from nephrite.physics.fresnel import check_eta
from nephrite.physics.phase import check_g
from nephrite.profiles import photon_beam
from nephrite.profiles._poles import LEAST_EXTINCTION
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["DEVIATIONS", "MODEL", "GaussianSum", "fit"]

DEVIATIONS = tuple(float(x) for x in np.geomspace(0.03, 30.0, 10))
"""Standard deviations that `make` fits with, in reduced mean free paths."""

_ROWS = tuple(float(x) for x in np.linspace(0.0, 1.0, 33) ** 1.5)  # sqrt(1 - albedo') of the fits
_POINTS = 300


class GaussianSum(RadialProfile):
    """The sum with `weights` (>= 0) and `variances` (length^2, > 0): as many of both, at least one.

    Each is a float, NumPy or Dr.Jit array; they broadcast. Raises `ParameterError` if the numbers differ.
    """

    def __init__(self, weights: Sequence[Any], variances: Sequence[Any]) -> None:
        """Store the terms."""
        if len(weights) != len(variances) or len(weights) == 0:
            raise ParameterError(
                f"there are {len(weights)} weights and {len(variances)} variances: each Gaussian needs one of both."
            )
        self.weights = tuple(weights)
        self.variances = tuple(variances)

    def reach(self) -> Any:
        """Length within which nearly all leaves: three deviations of the wider terms, by their weights."""
        mean = sum(w * namespace(v).sqrt(v * 1.0) for w, v in zip(self.weights, self.variances, strict=True))
        widest = self.variances[0]
        for variance in self.variances[1:]:
            widest = namespace(widest, variance).maximum(widest, variance)
        total = self.albedo()
        xp = namespace(mean, total)
        longest = 3.0 * namespace(widest).sqrt(widest * 1.0)
        return plain(
            xp.select(total > 0.0, xp.minimum(6.0 * mean / xp.maximum(total, 1e-30), longest), longest)
        )

    def _sum(self, r: Any, divided: bool) -> Any:
        """Sum of `w e^(-r^2/(2v))`, each divided by 2 pi v or not."""
        total = 0.0
        for weight, variance in zip(self.weights, self.variances, strict=True):
            factor = weight / (2.0 * math.pi * variance) if divided else weight
            total = total + factor * namespace(r, variance).exp(r * r / (-2.0 * variance))
        return total

    def eval(self, r: Any) -> Any:
        """R(r) per area."""
        return plain(self._sum(r, True))

    def albedo(self) -> Any:
        """Sum of the weights."""
        return plain(sum(self.weights[1:], self.weights[0] + 0.0 * self.variances[0]))

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        total = self.albedo()
        beyond = self._sum(r, False)
        return plain(1.0 - beyond / namespace(total, beyond).maximum(total, 1e-30))

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius distributed as `pdf`: `v` chooses the term, whose cdf has a closed inverse."""
        xp = namespace(u, v, *self.weights, *self.variances)
        left, variance = v * sum(self.weights), self.variances[0] * 1.0
        for weight, following in zip(self.weights, self.variances[1:], strict=False):
            left = left - weight
            variance = xp.select(left >= 0.0, following, variance)
        return plain(xp.sqrt(-2.0 * variance * xp.log(xp.maximum(1.0 - u, 1e-30))))


def fit(profile: RadialProfile, deviations: Sequence[float]) -> GaussianSum:
    """Fit a sum of Gaussians with the given standard deviations (lengths > 0) to a profile of one medium.

    `profile`: with numbers, not arrays, for parameters. The fit looks at radii from a tenth of the least deviation to
    six of the greatest, and has the profile's total. Raises `ParameterError` for deviations that are not positive.
    """
    if len(deviations) == 0 or min(deviations) <= 0.0:
        raise ParameterError(f"deviations are {deviations!r}: give at least one length above 0.")
    from scipy.optimize import nnls

    variances = np.square(np.asarray(deviations, dtype=np.float64))
    r = np.geomspace(0.1 * min(deviations), 6.0 * max(deviations), _POINTS)
    mass = 2.0 * math.pi * r * r
    terms = np.exp(r[:, None] ** 2 / (-2.0 * variances)) / (2.0 * math.pi * variances)
    weights, _ = nnls(terms * mass[:, None], mass * np.asarray(profile.eval(r)))
    if weights.sum() > 0.0:
        weights *= float(profile.albedo()) / weights.sum()
    return GaussianSum([float(w) for w in weights], [float(v) for v in variances])


@lru_cache(maxsize=64)
def _table(eta: float, g: float) -> tuple[tuple[float, ...], ...]:
    """Weights of photon beam diffusion, [Gaussian][row]."""
    rows = []
    for root in _ROWS:
        profile = photon_beam.make(root * root, 1.0 - root * root, eta, g)
        rows.append(fit(profile, DEVIATIONS).weights)
    return tuple(zip(*rows, strict=True))


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> GaussianSum:
    """Build the sum that fits photon beam diffusion; at most 8 % (L1) from it, more where nothing is absorbed.

    Each pair of `eta` and `g` is fitted once, which takes a moment.
    """
    sigma_a = alike(sigma_a, eta, g)
    xp = namespace(sigma_a, sigma_s_prime)
    sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
    absorbed = xp.minimum(sigma_a / sigma_t_prime, 1.0)
    root = xp.select(sigma_s_prime > 0.0, xp.sqrt(absorbed), 1.0)
    near = []
    for before, here, after in zip((-1.0, *_ROWS), _ROWS, (*_ROWS[1:], 2.0), strict=False):
        tent = xp.minimum((root - before) / (here - before), (after - root) / (after - here))
        near.append(xp.maximum(tent, 0.0))
    weights = []
    for of_rows in lift(_table, checked(check_eta, eta), checked(check_g, g)):
        weights.append(plain(sum(share * weight for share, weight in zip(near, of_rows, strict=True))))
    mfp = 1.0 / sigma_t_prime
    return GaussianSum(weights, [plain((deviation * mfp) * (deviation * mfp)) for deviation in DEVIATIONS])


MODEL = Model(
    name="gaussians",
    title="Sum of Gaussians",
    source="d'Eon, Luebke (2007): Advanced techniques for realistic real-time skin rendering",
    terms=photon_beam.MODEL.terms,
    make=make,
)
