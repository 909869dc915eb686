"""What leaves a half-space under a smooth interface, exactly: totals and exit directions, with no diffusion theory.

Discrete ordinates for the azimuthal mean of the radiance (Chandrasekhar 1960, chapter 3; Stamnes et al. 1988), which
is all that totals need: the modes that decay with depth give the reflection of the index-matched half-space, and the
interface adds a geometric series of internal reflections. The directions inside are Gauss nodes on both sides of the
critical angle, those of light that passes chosen by their refracted cosine, where Fresnel's reflectance is smooth.
Forward peaks are truncated, with the single scattering put right (delta-M; Wiscombe 1977, Nakajima and Tanaka 1988).

Nothing here knows a length: a half-space has none. Light is counted per light that has *entered*. The profiles and the
atlas take their totals and directions from here, by order of scattering and for straight light too. `color_halfspace`
solves the same in another form, for rough surfaces and up to no absorption: tests/physics/test_color.py compares them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics import fresnel
from nephrite.physics.phase import check_g

__all__ = ["Exits", "check_albedo", "emergent", "lobe_slope", "total_reflectance"]

_NODES = 40
_BEAM = (
    1e-13  # weight of the node that stands for a collimated beam: nothing even beside the least absorption
)
_WHITEST = 1.0 - 1e-7  # beyond, the eigenvalues lose their digits; what is lost is linear in sqrt(1 - albedo)
_LONGEST_SERIES = 2000


@dataclass(frozen=True)
class Exits:
    """Light that leaves, by direction: `[N]` quadrature nodes over the outer hemisphere, azimuth averaged.

    `inside`, `outside`: cosine to the normal before and after the refraction. `lobe`: weights of the plain exit lobe
    `(1 - F) cos / (c pi)`, sum 1. `all`, `single`: radiance relative to that lobe, of any order of scattering and of
    order one alone: the sum of `lobe * all` is the total reflectance.
    """

    inside: np.ndarray
    outside: np.ndarray
    lobe: np.ndarray
    all: np.ndarray
    single: np.ndarray

    @property
    def multiple(self) -> np.ndarray:
        """Radiance, relative to the plain lobe, of light that has scattered twice or more often."""
        return self.all - self.single


def check_albedo(albedo: float) -> float:
    """Return the single-scattering albedo as a float; raise `ParameterError` unless it lies in [0, 1]."""
    value = float(albedo)
    if not 0.0 <= value <= 1.0:
        raise ParameterError(
            f"albedo is {albedo!r}, but the share of light that an event scatters is in [0, 1]."
        )
    return value


def total_reflectance(
    albedo: float, eta: float, g: float = 0.0, incidence: str = "diffuse", multiple: bool = False
) -> float:
    """Share of the light that has entered which leaves again, in [0, 1]; of order two and more if `multiple`.

    `albedo`: single-scattering albedo sigma_s / sigma_t (not reduced). `incidence`: "diffuse" (equal radiance from all
    directions outside) or "normal". Accurate to 1e-7 for |g| up to .5 and 1e-4 at .95 (diffuse), to 1e-4 under
    normal light. Raises `ParameterError`.
    """
    exits = emergent(check_albedo(albedo), fresnel.check_eta(eta), check_g(g), incidence)
    return max(float(exits.lobe @ (exits.multiple if multiple else exits.all)), 0.0)


def lobe_slope(albedo: float, eta: float, g: float = 0.0) -> tuple[float, float]:
    """Best linear correction of the plain exit lobe, for diffuse incidence and order two or more: (slope, mean).

    Light leaves as the plain lobe times `1 + slope * (cos - mean)`, with cos the cosine *inside*, before the
    refraction, and `mean` its mean under the plain lobe, so that no energy is made or lost: least squares under the
    lobe. Inside, the radiance is nearly linear in the cosine; what the line leaves is in the tests.
    """
    exits = emergent(check_albedo(albedo), fresnel.check_eta(eta), check_g(g), "diffuse")
    mean = float(exits.lobe @ exits.inside)
    centred = exits.inside - mean
    total = float(exits.lobe @ exits.multiple)
    if total <= 0.0:
        return 0.0, mean
    return float(exits.lobe @ (centred * exits.multiple) / total / (exits.lobe @ centred**2)), mean


@lru_cache(maxsize=4096)
def emergent(albedo: float, eta: float, g: float = 0.0, incidence: str = "diffuse") -> Exits:
    """Solve for the light that leaves, per light that has entered; see `total_reflectance` for the parameters."""
    if incidence not in ("diffuse", "normal"):
        raise ParameterError(f"incidence is {incidence!r}: it is 'diffuse' or 'normal'.")
    if albedo > _WHITEST:
        return _nearly_white(albedo, eta, g, incidence)
    mu, weight, outside, reflected = _directions(eta)
    entering = np.where(outside > 0.0, 1.0 - reflected, 0.0)  # radiance of the light that has just entered
    if incidence == "normal":
        entering = np.append(np.zeros_like(mu), 1.0 / _BEAM)
        mu, outside, weight = np.append(mu, 1.0), np.append(outside, 1.0), np.append(weight, _BEAM)
        reflected = np.append(reflected, fresnel.reflectance(1.0, eta))
    entering = entering / np.sum(weight * mu * entering)

    terms = _NODES
    peak = g ** (terms + 1)
    scaled = albedo * (1.0 - peak) / (1.0 - albedo * peak)
    order = np.arange(terms + 1)
    smooth = (2 * order + 1) * (float(g) ** order - peak) / (1.0 - peak)
    reflection = _index_matched(mu, weight, scaled, smooth)
    root = np.sqrt(weight)
    up = np.linalg.solve(np.eye(mu.size) - reflection * reflected, reflection @ (root * entering)) / root

    series = _series_length(g)
    backward = _backward(mu, (2 * np.arange(series + 1) + 1) * float(g) ** np.arange(series + 1))
    once = _single(mu, weight, backward, entering)
    truncated = _single(mu, weight, _backward(mu, smooth), entering)
    up = up - scaled * truncated + albedo / (1.0 - albedo * peak) * once

    seen = (outside > 0.0) & (weight > _BEAM)
    lobe = (weight * mu * (1.0 - reflected))[seen]
    plain = lobe.sum()
    return Exits(mu[seen], outside[seen], lobe / plain, up[seen] * plain, albedo * once[seen] * plain)


def _directions(eta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (cosines inside, weights, cosines outside - 0 where none -, reflectance from inside)."""
    nodes, weights = _gauss(_NODES)
    unit, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    if eta <= 1.0:
        outside = np.sqrt(1.0 - eta**2 * (1.0 - unit**2))
        return unit, weights, outside, np.asarray(fresnel.reflectance(-unit, eta))
    squared, doubled = unit * unit, 2.0 * unit * weights  # crowded towards grazing, where F rises steeply
    critical = math.sqrt(1.0 - 1.0 / eta**2)
    passing = np.sqrt(critical**2 + (squared / eta) ** 2)
    # few nodes in a narrow interval: cosines of nearly 0 cost the eigenvalues their digits
    nodes, weights = _gauss(4 + round((_NODES - 4) * critical))
    caught = 0.5 * critical * (nodes + 1.0)
    return (
        np.concatenate([caught, passing]),
        np.concatenate([0.5 * critical * weights, doubled * squared / (eta**2 * passing)]),
        np.concatenate([np.zeros_like(caught), squared]),
        np.concatenate([np.ones_like(caught), np.asarray(fresnel.reflectance(squared, eta))]),
    )


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(count)


def _legendre(mu: np.ndarray, last: int) -> np.ndarray:
    values = np.empty((last + 1, mu.size))
    values[0], values[1] = 1.0, mu
    for order in range(1, last):
        values[order + 1] = ((2 * order + 1) * mu * values[order] - order * values[order - 1]) / (order + 1)
    return values


def _index_matched(mu: np.ndarray, weight: np.ndarray, albedo: float, series: np.ndarray) -> np.ndarray:
    """Reflection of a half-space without interface: radiance down to radiance up, both times sqrt(weight).

    `series`: the phase function's coefficients `(2l + 1) chi_l`. With the sum and the difference of radiance down and
    up, mu d/dtau of one is the other, scattered by the even or odd half of the series; so the squared decay rates are
    the eigenvalues of one symmetric matrix.
    """
    values = _legendre(mu, series.size - 1)
    root = np.sqrt(weight)
    values = values * root
    identity = np.eye(mu.size)
    even = identity - albedo * (values[0::2].T * series[0::2]) @ values[0::2]
    odd = identity - albedo * (values[1::2].T * series[1::2]) @ values[1::2]
    lower = np.linalg.cholesky(even)
    product = lower.T @ (odd / mu[:, None] / mu) @ lower
    rates, modes = np.linalg.eigh(0.5 * (product + product.T))
    total = np.linalg.solve(lower.T, modes)
    net = (even @ total) / mu[:, None] / np.sqrt(rates)
    return np.linalg.solve((total + net).T, (total - net).T).T


def _backward(mu: np.ndarray, series: np.ndarray) -> np.ndarray:
    """Azimuthal mean of the phase function from every direction down to every direction up."""
    values = _legendre(mu, series.size - 1)
    return (values.T * (series * (-1.0) ** np.arange(series.size))) @ values


def _single(mu: np.ndarray, weight: np.ndarray, backward: np.ndarray, entering: np.ndarray) -> np.ndarray:
    """Radiance up at the surface after one event, per albedo (Chandrasekhar 1960, section 14)."""
    return 0.5 * (backward / (mu[:, None] + mu)) @ (weight * mu * entering)


def _series_length(g: float) -> int:
    return 1 if g == 0.0 else min(_LONGEST_SERIES, 2 + int(math.log(1e-9) / math.log(abs(g))))


def _nearly_white(albedo: float, eta: float, g: float, incidence: str) -> Exits:
    """Extrapolate to no absorption, where all leaves: the loss is proportional to sqrt(1 - albedo)."""
    near = emergent(_WHITEST, eta, g, incidence)
    kept = math.sqrt((1.0 - albedo) / (1.0 - _WHITEST))
    total = float(near.lobe @ near.all)
    factor = (1.0 - (1.0 - total) * kept) / total
    return Exits(near.inside, near.outside, near.lobe, near.all * factor, near.single * factor)
