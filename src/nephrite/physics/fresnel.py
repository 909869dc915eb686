"""Fresnel reflection at a smooth dielectric: exact, unpolarised; and its moments over the hemisphere.

Convention everywhere in the package: `eta` is the index of refraction inside divided by the one outside. Only
`moment`, `c1` and `c2` follow the literature's: the side that the light comes from divided by the other.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import checked, lift

__all__ = [
    "boundary_factor",
    "c1",
    "c2",
    "check_eta",
    "external_diffuse_reflectance",
    "fdr",
    "fdr_fit",
    "internal_diffuse_reflectance",
    "lobe_normalization",
    "moment",
    "reflectance",
    "refracted_cosine",
]

_NODES = 128


def check_eta(eta: float) -> float:
    """Return `eta` as a float; raise `ParameterError` unless it is positive and finite."""
    try:
        value = float(eta)
    except (TypeError, ValueError):
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(
            f"eta is {eta!r}, but an index of refraction is a positive number: use 1 for a matched surface, "
            "1.3 for food and milk, 1.5 for stone and glass."
        )
    return value


def refracted_cosine(cos_theta: Any, eta: Any) -> Any:
    """Cosine of the refracted direction by Snell's law; 0 where there is total reflection.

    `cos_theta`: cosine of the incident direction, its sign is ignored; `eta`: index of the side entered
    divided by the index of the side left. Floats, NumPy or Dr.Jit arrays of any common shape.
    """
    xp = namespace(cos_theta, eta)
    cosine = xp.minimum(xp.abs(cos_theta), 1.0)
    squared = 1.0 - (1.0 - cosine * cosine) / (eta * eta)
    return plain(xp.sqrt(xp.maximum(squared, 0.0)))


def reflectance(cos_theta: Any, eta: Any) -> Any:
    """Fraction of unpolarised light that a smooth dielectric reflects, total reflection included (Fresnel).

    `cos_theta`: cosine between the surface's outward normal and the incident direction: positive if the light
    comes from outside, negative from inside. `eta`: inside / outside. Floats, NumPy or Dr.Jit arrays; result
    in [0, 1].
    """
    xp = namespace(cos_theta, eta)
    relative = xp.select(cos_theta >= 0.0, eta * 1.0, 1.0 / eta)
    cos_i = xp.minimum(xp.abs(cos_theta), 1.0)
    squared = 1.0 - (1.0 - cos_i * cos_i) / (relative * relative)
    cos_t = xp.sqrt(xp.maximum(squared, 0.0))
    # Grazing light on a matched surface is 0/0 in both: the small number makes it 0 there and nowhere else
    # matters.
    parallel = (relative * cos_i - cos_t) / xp.maximum(relative * cos_i + cos_t, 1e-20)
    perpendicular = (cos_i - relative * cos_t) / xp.maximum(cos_i + relative * cos_t, 1e-20)
    partial = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    # At exactly grazing incidence everything is reflected unless the surface is matched.
    grazing = (cos_i == 0.0) & (relative != 1.0)
    return plain(xp.select((squared <= 0.0) & (relative < 1.0) | grazing, 1.0, partial))


def moment(order: int, eta: Any) -> Any:
    """Moment of the reflectance that light *inside* meets: integral over [0, 1] of F(mu) mu^order d mu.

    `eta` is, as in d'Eon and Irving (2011), the index of the side that the light comes from divided by the
    other: `moment(1, eta)` is their C1(eta) (internal reflection for eta > 1), `moment(1, 1/eta)` looks from
    the outside. Gauss-Legendre quadrature in the cosine on the denser side, where F is smooth; the part that
    is totally reflected is exact. Cached. `eta` is a number, as for all moments, or a Dr.Jit array of one entry,
    through which derivatives pass. Raises `ParameterError` for an order below 0 or a bad `eta`.
    """
    if order < 0:
        raise ParameterError(f"order is {order}, but only the moments 0, 1, 2, ... are defined here.")
    return lift(lambda number: _moment(order, number), checked(check_eta, eta))


@lru_cache(maxsize=512)
def _moment(order: int, eta: float) -> float:
    if eta == 1.0:
        return 0.0
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    # The nodes crowd towards grazing light (t = u^2), where F rises steeply if the indices are close.
    u, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    t, jacobian = u * u, 2.0 * u
    if eta < 1.0:
        return float(np.sum(weights * jacobian * reflectance(t, 1.0 / eta) * t**order))
    critical = math.sqrt(1.0 - 1.0 / eta**2)
    # Past the critical angle, integrate over the refracted cosine t: mu d mu = t dt / eta^2, F the same both
    # ways.
    mu = np.sqrt(critical**2 + (t / eta) ** 2)
    partial = np.sum(weights * jacobian * reflectance(t, eta) * mu ** (order - 1) * t) / eta**2
    return float(critical ** (order + 1) / (order + 1) + partial)


def c1(eta: Any) -> Any:
    """First moment C1 of d'Eon and Irving (2011): `moment(1, eta)`; their fit is 2 C1."""
    return moment(1, eta)


def c2(eta: Any) -> Any:
    """Second moment C2 of d'Eon and Irving (2011): `moment(2, eta)`; their fit is 3 C2."""
    return moment(2, eta)


def external_diffuse_reflectance(eta: Any) -> Any:
    """Share of diffuse light that the surface reflects outside: 2 C1(1/eta); .0611 at 1.3, .0918 at 1.5."""
    return 2.0 * moment(1, 1.0 / checked(check_eta, eta))


def internal_diffuse_reflectance(eta: Any) -> Any:
    """Share of diffuse light from inside that is reflected back in: 2 C1(eta); .444 at 1.3, .596 at 1.5."""
    return 2.0 * moment(1, eta)


def lobe_normalization(eta: Any) -> Any:
    """The c of the exit lobe `Sw(w) = (1 - F(cos w)) / (c pi)`: 1 - external diffuse reflectance.

    With it the lobe's cosine-weighted integral over the outer hemisphere is 1, so that nothing is lost or
    made.
    """
    return 1.0 - external_diffuse_reflectance(eta)


def fdr(eta: Any) -> Any:
    """Average internal reflectance Fdr of the dipole (Jensen et al. 2001, section 2.3), by quadrature.

    The same integral as `internal_diffuse_reflectance`, under the name that the diffusion literature uses;
    `fdr_fit` is the polynomial that Jensen printed.
    """
    return internal_diffuse_reflectance(eta)


def fdr_fit(eta: float) -> float:
    """Egan and Hilgeman's fit of Fdr for eta >= 1, as in Jensen et al. (2001); within .0016 of `fdr`.

    It gives .0016 instead of 0 at eta = 1: prefer `fdr`. Raises `ParameterError` for eta < 1.
    """
    eta = check_eta(eta)
    if eta < 1.0:
        raise ParameterError(f"eta is {eta}, but this fit holds for eta >= 1 only: use fdr(eta).")
    return -1.440 / eta**2 + 0.710 / eta + 0.668 + 0.0636 * eta


def boundary_factor(eta: Any) -> Any:
    """The dipole's A = (1 + Fdr) / (1 - Fdr) (Jensen et al. 2001, section 2.3); 1 at a matched surface."""
    average = fdr(eta)
    return (1.0 + average) / (1.0 - average)
