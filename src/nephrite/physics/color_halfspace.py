"""Light in a half-space by discrete ordinates: the light that comes back up for the light that goes down.

Everything is averaged over the azimuth, which loses nothing where light is diffuse. No noise and no table: radiance is
known at some tens of cosines (`Streams`), between which quadrature is exact for polynomials, and the radiative transfer
equation becomes an eigenvalue problem of that size (Chandrasekhar 1960; Stamnes et al. 1988).

It is for `color`: a rough surface sends light back along other cosines than it came from, so radiance must be known
between the nodes, and its whitest colour is that of a medium without absorption. `halfspace` solves the same for
totals under a smooth surface; tests/physics/test_color.py compares the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import legendre

__all__ = ["Streams", "gauss", "reflection", "streams"]

_NARROW = 0.02  # total reflection up to this cosine, .04 % of the light, needs no panel of its own


@lru_cache(maxsize=8)
def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss-Legendre nodes in (0, 1) and their weights, (count,) each."""
    nodes, weights = legendre.leggauss(count)
    return 0.5 * (nodes + 1.0), 0.5 * weights


@dataclass(frozen=True)
class Panel:
    """Cosines `start + (end - start) u^power` at Gauss nodes u in (0, 1), and how to interpolate between them."""

    start: float
    end: float
    power: int
    unit: np.ndarray
    unit_weights: np.ndarray

    @classmethod
    def of(cls, start: float, end: float, power: int, count: int) -> Panel:
        """Return a panel with `count` nodes."""
        return cls(start, end, power, *gauss(count))

    @property
    def cosines(self) -> np.ndarray:
        """The cosines, (count,)."""
        return self.start + (self.end - self.start) * self.unit**self.power

    @property
    def weights(self) -> np.ndarray:
        """Weights of an integral over the cosine, (count,)."""
        return (self.end - self.start) * self.power * self.unit ** (self.power - 1) * self.unit_weights

    def project(self, cosines: np.ndarray, amounts: np.ndarray) -> np.ndarray:
        """Return the row x for which `x @ values` is the sum of amounts times the values between the nodes, (count,).

        Cosines outside the panel are left out.
        """
        mine = (cosines > self.start) & (cosines <= self.end)
        degrees = np.arange(len(self.unit))
        place = ((cosines[mine] - self.start) / (self.end - self.start)) ** (1.0 / self.power)
        moments = amounts[mine] @ legendre.legvander(2.0 * place - 1.0, degrees[-1])
        basis = legendre.legvander(2.0 * self.unit - 1.0, degrees[-1]) * self.unit_weights[:, None]
        return basis @ (moments * (2 * degrees + 1))


@dataclass(frozen=True)
class Streams:
    """The cosines, in (0, 1), at which radiance is known, and weights of an integral over them, (n,) each.

    `order`: the phase function's Legendre moments up to here are integrated exactly.
    """

    panels: tuple[Panel, ...]
    order: int

    @cached_property
    def cosines(self) -> np.ndarray:
        """Cosines, (n,)."""
        return np.concatenate([panel.cosines for panel in self.panels])

    @cached_property
    def weights(self) -> np.ndarray:
        """Weights of an integral over the cosine, (n,)."""
        return np.concatenate([panel.weights for panel in self.panels])

    def project(self, cosines: np.ndarray, amounts: np.ndarray) -> np.ndarray:
        """Return the row x for which `x @ values` is the sum of amounts times the values between the nodes, (n,)."""
        return np.concatenate([panel.project(cosines, amounts) for panel in self.panels])


def streams(eta: float, count: int) -> Streams:
    """Choose cosines for light inside a surface of relative index `eta`; `count` nodes, half as many more if split.

    Where light starts to be reflected totally, radiance jumps and transmission has a square root: there two
    panels meet, and the nodes of the upper one crowd quadratically.
    """
    critical = math.sqrt(max(1.0 - 1.0 / eta**2, 0.0))
    if critical < _NARROW:
        return Streams((Panel.of(0.0, 1.0, 1, count),), count - 1)
    return Streams((Panel.of(0.0, critical, 1, count // 2), Panel.of(critical, 1.0, 2, count)), count - 1)


def reflection(at: Streams, g: float, albedo: float) -> np.ndarray:
    """Return the operator R of a half-space without interface: `upward = R @ downward`, radiances at its top, (n, n).

    `albedo`: of single scattering, in [0, 1], not reduced. Henyey-Greenstein; a forward peak too sharp for the streams
    counts as not scattered (Wiscombe 1977, delta-M).
    """
    mu, weights = at.cosines, at.weights
    degrees = np.arange(at.order + 1)
    peak = g ** (at.order + 1) if g > 0.0 else 0.0
    moments = (2 * degrees + 1) * (g**degrees - peak) / (1.0 - peak)
    albedo = albedo * (1.0 - peak) / (1.0 - albedo * peak)
    polynomials = legendre.legvander(mu, at.order)
    onward = (polynomials * moments) @ polynomials.T
    back = (polynomials * moments * (-1.0) ** degrees) @ polynomials.T

    # Sum S and difference D of the upward and the downward radiance of a mode e^(-k tau):
    #   -k mu S = Q- W D,  -k mu D = Q+ W S,  Q+- = 1/W - albedo/2 (onward +- back), both symmetric and positive.
    # With z = sqrt(W mu) S both become one symmetric problem.
    root = np.sqrt(weights / mu)
    even = root[:, None] * (np.diag(1.0 / weights) - 0.5 * albedo * (onward + back)) * root
    odd = root[:, None] * (np.diag(1.0 / weights) - 0.5 * albedo * (onward - back)) * root
    lower = np.linalg.cholesky(odd)
    squared, vectors = np.linalg.eigh(lower.T @ even @ lower)
    z = lower @ vectors
    decay = np.sqrt(np.maximum(squared, 0.0))
    total = root[:, None] * z / weights[:, None]
    difference = -root[:, None] * np.linalg.solve(odd, z * decay) / weights[:, None]
    up, down = 0.5 * (total + difference), 0.5 * (total - difference)
    return np.linalg.solve(down.T, up.T).T
