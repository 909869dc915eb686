"""The table behind `nephrite.profiles.tabulated`: what is stored, and how it is read back.

Lengths are reduced mean free paths `1/sigma_t'`, but mean free paths `1/sigma_t` for light of order one. The albedo's
axis is t = (1 - albedo')^(1/4), even in [0, 1]: white is 0, and the decay of far light is nearly quadratic in it. Over
r, a cubic spline in log r with even knots holds the logarithm of R(r) relative to `reference`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

__all__ = [
    "INCIDENCES",
    "KNOTS",
    "LEAST_REDUCED",
    "PACKAGED",
    "R_MAX",
    "R_MIN",
    "STEP",
    "T_NODES",
    "Shapes",
    "albedo_of",
    "basis",
    "bspline",
    "decay",
    "light",
    "load",
    "reference",
    "single_decay",
    "write",
]

PACKAGED = Path(__file__).parent / "data" / "tabulated.npz"
"""The file that the package ships."""

INCIDENCES = ("diffuse", "normal")
T_NODES = np.linspace(0.0, 1.0, 29)
R_MIN, R_MAX = 1e-4, 1e4
LEAST_REDUCED = 1e-3
"""Below this albedo', profiles have the shape that they have there."""
_INTERVALS = 56
KNOTS = _INTERVALS + 3
"""Coefficients of the spline over log r."""
STEP = math.log(R_MAX / R_MIN) / _INTERVALS
_QUANTUM = 2.0**-11  # of the stored logarithm: .05 %


def albedo_of(reduced: Any, g: float) -> Any:
    """Single-scattering albedo for a reduced one: albedo' / (1 - g + albedo' g)."""
    return reduced / (1.0 - g + reduced * g)


def reference(x: Any, rate: Any) -> Any:
    """Light per unit of x = ln r of a dipole's profile, integral about 1: what the stored logarithm is relative to."""
    squared = np.exp(2.0 * x)
    distance = np.sqrt(squared + 1.0)
    return squared * (1.0 + rate * distance) * np.exp(-rate * (distance - 1.0)) / distance**3


def light(x: np.ndarray, spline: np.ndarray, rate: Any) -> np.ndarray:
    """Light per unit of x = ln r, [..., N], for the coefficients [..., KNOTS] of a stored spline."""
    return np.exp(np.sum(basis(x) * spline[..., None, :], axis=-1)) * reference(x, rate)


@lru_cache(maxsize=1024)
def decay(reduced: float) -> float:
    """Rate at which far light decays: albedo'/(2 k) ln((1 + k)/(1 - k)) = 1 (Case and Zweifel 1967), by bisection."""
    if reduced >= 1.0:
        return 0.0
    low, high = 0.0, 1.0 - 1e-12
    for _ in range(60):
        middle = 0.5 * (low + high)
        if reduced * math.atanh(middle) < middle:
            low = middle
        else:
            high = middle
    return low


def single_decay(eta: float, incidence: str) -> float:
    """Rate at which light of order one decays along the surface: of the flattest path in and out (eta >= 1)."""
    return eta + math.sqrt(eta * eta - 1.0) if incidence == "normal" else eta


def bspline(u: Any) -> tuple[Any, Any, Any, Any]:
    """Weights of the four cubic B-splines that reach the place `u` in [0, 1] of an interval; their sum is 1."""
    v = 1.0 - u
    return (
        v * v * v / 6.0,
        (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0,
        (4.0 - 6.0 * v * v + 3.0 * v * v * v) / 6.0,
        u * u * u / 6.0,
    )


def basis(x: np.ndarray) -> np.ndarray:
    """Values [..., KNOTS] of the spline's basis at x = ln r; beyond the ends, those at the ends."""
    place = np.clip((x - math.log(R_MIN)) / STEP, 0.0, _INTERVALS)
    index = np.minimum(place.astype(int), _INTERVALS - 1)
    matrix = np.zeros((*x.shape, KNOTS))
    for offset, weight in enumerate(bspline(place - index)):
        np.put_along_axis(matrix, (index + offset)[..., None], weight[..., None], axis=-1)
    return matrix


@dataclass(frozen=True)
class Shapes:
    """The stored splines: `multiple` [incidence, eta, g, T, KNOTS], `single` [incidence, eta, g, KNOTS]."""

    eta: np.ndarray
    g: np.ndarray
    multiple: np.ndarray
    single: np.ndarray

    def at(self, eta: float, g: float, incidence: str) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the splines [T, KNOTS] and [KNOTS], cubic in eta and in ln(1 - g), and the `single_decay`.

        Beyond the table's ends they are those at the ends.
        """
        eta, g = min(max(eta, self.eta[0]), self.eta[-1]), min(max(g, self.g[0]), self.g[-1])
        at_eta = _spline_weights(self.eta, eta)
        weights = at_eta[:, None] * _spline_weights(np.log(1.0 - self.g), math.log(1.0 - g))
        which = INCIDENCES.index(incidence)
        multiple, single = (np.tensordot(weights, table[which]) for table in (self.multiple, self.single))
        return multiple, single, single_decay(eta, incidence)


def _spline_weights(nodes: np.ndarray, place: float) -> np.ndarray:
    """What each node's value weighs in the cubic spline through them (not-a-knot), at `place`."""
    from scipy.interpolate import CubicSpline

    order = np.argsort(nodes)
    return CubicSpline(nodes[order], np.eye(nodes.size)[order])(place)


def write(path: Path, eta: np.ndarray, g: np.ndarray, multiple: np.ndarray, single: np.ndarray) -> None:
    """Store the splines as differences of whole numbers, which compress well."""
    arrays = {}
    for name, values in (("multiple", multiple), ("single", single)):
        whole = np.round(values / _QUANTUM).astype(np.int64)
        steps = np.diff(whole, axis=-1, prepend=0)
        assert np.abs(steps).max() < 2**15, "the logarithm jumps"
        arrays[name] = steps.astype(np.int16)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, eta=eta, g=g, **arrays)


@lru_cache(maxsize=2)
def load(path: Path = PACKAGED) -> Shapes:
    """Read the table; cached."""
    with np.load(path) as file:
        return Shapes(
            file["eta"],
            file["g"],
            *(np.cumsum(file[name].astype(np.int64), axis=-1) * _QUANTUM for name in ("multiple", "single")),
        )
