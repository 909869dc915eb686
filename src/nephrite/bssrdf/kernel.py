"""A radial profile as a table: what a wavefront looks up and draws from, one way for all models.

At fixed eta and g a profile depends on two numbers: the reduced albedo a', and the distance in reduced mean free
paths. Rows of the table stand for t = sqrt(1 - a'), in which the logarithm of a profile is nearly straight (sigma_tr
is proportional to it), dense near 0; edges for the distance, even in its logarithm.

A kernel is what a half-space sends out of the light that has scattered at least twice: the rest, S(0) and S(1), is
sharp, and walked. Models of all scattered light give up the energy of S(1), `a h`, and keep their shape.

Points are drawn from two poles: straight rays in all directions from a point at the depth z below a plane meet it with
the density `z / (2 pi d^3)`, d^2 = r^2 + z^2, which is what the dipole's own terms fall off with. Each row has the two
depths, and the share of the first, for which the variance on a plane is least.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from nephrite.physics.single import single_scattering_share
from nephrite.profiles import models

__all__ = [
    "EDGES",
    "EMPTY",
    "FIRST",
    "ROWS",
    "STEP",
    "Table",
    "albedos",
    "multiple",
    "table",
    "tabulate",
    "tabulated",
]

ROWS = 64
EDGES = 137
FIRST = -8.0
"""Logarithm to base 2 of the least distance told apart, in reduced mean free paths."""
STEP = 17.0 / (EDGES - 1)
"""Octaves between edges: the table ends at 512 reduced mean free paths, beyond which a kernel is 0."""
EMPTY = -100.0
"""Logarithm to base 2 of nothing."""

_PARTS, _WEIGHTS = (np.array(part) for part in np.polynomial.legendre.leggauss(4))
_DEPTHS = np.exp2(np.arange(-4.0, 4.6, 0.5))
_SHARES = np.array([0.3, 0.5, 0.7, 0.85])


@dataclass(frozen=True)
class Table:
    """A kernel over `EDGES` of the distance, in rows: `ROWS` values of t, or others (see `fixed`).

    `log_kernel`: [rows, EDGES], logarithm to base 2 of the kernel per area. `poles`: [rows, 3], depths of two
    poles and the share of the first. Lengths in reduced mean free paths.
    """

    log_kernel: np.ndarray
    poles: np.ndarray


def albedos() -> np.ndarray:
    """Return the reduced albedos of the rows, from 1 down to 0: `1 - t^2`, even in the root of t."""
    return 1.0 - np.linspace(0.0, 1.0, ROWS) ** 4


@lru_cache(maxsize=64)
def tabulated(model: str, eta: float, g: float) -> Table:
    """Return the table of a model in `nephrite.profiles.models`; raises `ParameterError` for an unknown one."""
    return tabulate(lambda albedo_prime, r: multiple(model, albedo_prime, r, eta, g))


def multiple(model: str, albedo_prime: Any, r: Any, eta: float, g: float) -> Any:
    """Light that has scattered at least twice, per area and per light that has entered; r in reduced mean free paths.

    NumPy arrays of reduced albedos and distances that broadcast.
    """
    found = models.find(model)
    profile = found.make(1.0 - albedo_prime, albedo_prime, eta, g)
    if found.terms == "multiple":
        return profile.eval(r)
    albedo = albedo_prime / (albedo_prime + (1.0 - albedo_prime) * (1.0 - g))
    single = albedo * single_scattering_share(g, eta)
    return profile.eval(r) * np.maximum(1.0 - single / np.maximum(profile.albedo(), 1e-12), 0.0)


def tabulate(kernel: Callable[[Any, Any], Any]) -> Table:
    """Tabulate `kernel(albedo_prime, r)`, per area, for arrays that broadcast; r in reduced mean free paths."""
    rows = albedos()[:, None]
    return table(lambda r: kernel(rows, r), ROWS)


def table(kernel: Callable[[np.ndarray], Any], rows: int) -> Table:
    """Tabulate `kernel(r)`, per area, which returns [rows, N] for distances [1, N]."""
    edges = np.exp2(FIRST + STEP * np.arange(EDGES))
    inner = np.concatenate([[0.0], edges[:-1]])
    middle, half = 0.5 * (edges + inner), 0.5 * (edges - inner)
    r = (middle[:, None] + half[:, None] * _PARTS).ravel()
    area = (half[:, None] * _WEIGHTS).ravel() * 2.0 * math.pi * r
    values = _clean(kernel(r[None, :]), (rows, r.size))
    at_edges = _clean(kernel(edges[None, :]), (rows, EDGES))
    log_kernel = np.where(at_edges > 0, np.log2(np.maximum(at_edges, 2.0**EMPTY)), EMPTY)
    return Table(log_kernel, _poles(values, r, area))


def _poles(values: np.ndarray, r: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Choose two depths and a share that make the integral of `kernel^2 / density` least, for each row."""
    single = _DEPTHS[:, None] / (2.0 * math.pi * (r**2 + _DEPTHS[:, None] ** 2) ** 1.5)
    first, second = np.triu_indices(_DEPTHS.size)
    best = np.full(len(values), np.inf)
    chosen = np.tile([1.0, 2.0, 0.5], (len(values), 1))
    squares = values**2 * area
    for share in _SHARES:
        density = share * single[first] + (1.0 - share) * single[second]
        cost = squares @ (1.0 / density).T
        index = cost.argmin(axis=1)
        least = cost[np.arange(len(values)), index]
        better = least < best
        best = np.where(better, least, best)
        found = np.stack([_DEPTHS[first[index]], _DEPTHS[second[index]], np.full(len(values), share)], axis=1)
        chosen = np.where(better[:, None], found, chosen)
    return chosen


def _clean(values: Any, shape: tuple[int, int]) -> np.ndarray:
    """Return finite values that are not negative: a row without scattering may be 0 / 0."""
    return np.maximum(np.nan_to_num(np.broadcast_to(values, shape), posinf=0.0), 0.0)
