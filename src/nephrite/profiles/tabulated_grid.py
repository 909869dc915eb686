"""The profiles of one index of refraction and mean cosine, ready to be evaluated: `nephrite.profiles.tabulated`'s grid.

Over t = (1 - albedo')^(1/4) and x = ln r, a bicubic B-spline with coefficients >= 0 holds the light per unit of x, 2 pi
r^2 R(r), divided by a power of the albedo. So a profile at any albedo is a mixture, with weights that are never
negative, of rows that can be integrated and inverted; each row has exactly the light that it should have. Within
`R_MIN` R is constant, beyond `R_MAX` it is 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from nephrite.physics import halfspace
from nephrite.profiles import tabulated_shape as shape

__all__ = ["CELLS", "ROWS", "STEP", "Grid", "grid", "integrals"]

ROWS = 4 * (shape.T_NODES.size - 1)
"""Intervals of t."""
CELLS = 16 * round(math.log10(shape.R_MAX / shape.R_MIN))
"""Intervals of x."""
STEP = math.log(shape.R_MAX / shape.R_MIN) / CELLS
_REACH = 0.99
_LEAST_FALL = 0.01


@dataclass(frozen=True)
class Grid:
    """What `TabulatedProfile` looks up, each flat for gathers; lengths in reduced mean free paths.

    `light` [ROWS + 3, CELLS + 3]: the B-spline's coefficients. `within` [ROWS + 3, CELLS + 1]: each row's light within
    the edges of the cells. `reach`, `slope` [ROWS + 1]: logarithm of the radius that holds 99 % of the light, and slope
    of the exit lobe, at even t. `mean_cosine`: of the plain lobe, inside. `power`: of the albedo, which multiplies all.
    `g`: mean cosine of scattering.
    """

    light: np.ndarray
    within: np.ndarray
    reach: np.ndarray
    slope: np.ndarray
    mean_cosine: float
    power: int
    g: float


def integrals(u: Any) -> tuple[Any, Any, Any, Any]:
    """Integrals of the four `tabulated_shape.bspline` from 0 to `u`, a part of an interval."""
    v = 1.0 - u
    v3, v4, u3, u4 = v * v * v, v * v * v * v, u * u * u, u * u * u * u
    return (
        (1.0 - v4) / 24.0,
        (4.0 * u - 2.0 * u3 + 0.75 * u4) / 6.0,
        (4.0 * u - 2.0 * (1.0 - v3) + 0.75 * (1.0 - v4)) / 6.0,
        u4 / 24.0,
    )


def _interpolating(intervals: int, first: tuple[float, float, float]) -> np.ndarray:
    """Matrix from values at the knots to coefficients; `first` times the first three is 0, the last end is straight."""
    count = intervals + 3
    matrix = np.zeros((count, count))
    for row in range(intervals + 1):
        matrix[row + 1, row : row + 3] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    matrix[0, :3] = first
    matrix[-1, -3:] = 1.0, -2.0, 1.0
    return np.linalg.inv(matrix)[:, 1:-1]


@lru_cache(maxsize=64)
def grid(eta: float, g: float, incidence: str, orders: str) -> Grid:
    """Build the grid for an index and a mean cosine: shapes by interpolation, totals exact (cached)."""
    multiple, single, rate = shape.load().at(eta, g, incidence)
    power = 2 if orders == "multiple" else 1
    t = np.linspace(0.0, 1.0, ROWS + 1)
    x = math.log(shape.R_MIN) + STEP * np.arange(CELLS + 1)
    reduced = np.maximum(1.0 - t**4, shape.LEAST_REDUCED)[:, None]
    once, more, slopes, mean = _exact(eta, g, incidence)

    rates = np.array([[shape.decay(value)] for value in reduced[:, 0]])
    albedo = shape.albedo_of(reduced, g)
    light = _filled(
        shape.light(x, _over_t(multiple, t), rates), _over_t(more, t) * albedo[:, 0] ** (2 - power)
    )
    if orders == "all":
        own = x - np.log(1.0 - albedo * g)  # ln of the radius in mean free paths
        light += _filled(shape.light(own, single, rate), _over_t(once, t))
    return _grid(light, _over_t(slopes, t), mean, power, g)


def _exact(eta: float, g: float, incidence: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Light of order one / albedo, of more / albedo^2, slope of the lobe, at `T_NODES`; mean cosine of the lobe."""
    rows = []
    for t in shape.T_NODES:
        reduced = max(1.0 - t**4, shape.LEAST_REDUCED)
        albedo = shape.albedo_of(reduced, g)
        every = halfspace.total_reflectance(albedo, eta, g, incidence)
        more = halfspace.total_reflectance(albedo, eta, g, incidence, multiple=True)
        slope, mean = halfspace.lobe_slope(albedo, eta, g)
        rows.append(((every - more) / albedo, more / albedo**2, slope, mean))
    columns = np.array(rows).T
    return columns[0], columns[1], columns[2], float(columns[3, 0])


def _over_t(values: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Interpolate between `T_NODES`, along the first axis; all is even in t, for it depends on t^2."""
    from scipy.interpolate import CubicSpline

    ends: Any = ((1, np.zeros(values.shape[1:])), "not-a-knot")
    return CubicSpline(shape.T_NODES, values, bc_type=ends)(t)


def _falling(light: np.ndarray) -> np.ndarray:
    """Let R fall with r as it does where there is no noise, by r^-.01 at the least."""
    x = STEP * np.arange(CELLS + 1)
    radial = light * np.exp((_LEAST_FALL - 2.0) * x)
    return np.maximum.accumulate(radial[:, ::-1], axis=1)[:, ::-1] * np.exp((2.0 - _LEAST_FALL) * x)


def _filled(light: np.ndarray, totals: np.ndarray) -> np.ndarray:
    """Scale each row, values at the edges of the cells, to its total."""
    return light * (totals / (STEP * (light.sum(axis=1) - 0.5 * light[:, -1])))[:, None]


def _grid(light: np.ndarray, slopes: np.ndarray, mean: float, power: int, g: float) -> Grid:
    """From values at the knots to coefficients, whose rows keep their totals."""
    rows = _interpolating(ROWS, (-1.0, 0.0, 1.0))  # even in t
    columns = _interpolating(CELLS, (1.0, -math.exp(-2.0 * STEP), 0.0))  # as r^2
    totals = rows @ (STEP * (light.sum(axis=1) - 0.5 * light[:, -1]))
    spline = np.maximum(rows @ _falling(light) @ columns.T, 0.0)
    whole = np.array(integrals(1.0)) * STEP
    cells = np.sum([whole[k] * spline[:, k : k + CELLS] for k in range(4)], axis=0)
    # within the first edge R is constant: half of the light per unit of ln r there
    inner = 0.5 * (spline[:, :3] @ np.array(shape.bspline(0.0))[:3])
    within = np.concatenate([inner[:, None], inner[:, None] + np.cumsum(cells, axis=1)], axis=1)
    scale = (totals / within[:, -1])[:, None]
    spline, within = spline * scale, within * scale

    middle = np.array(shape.bspline(0.0))[:3]
    at_knots = np.sum([middle[k] * within[k : k + ROWS + 1] for k in range(3)], axis=0)
    x = math.log(shape.R_MIN) + STEP * np.arange(CELLS + 1)
    reach = np.array([np.interp(_REACH, row / row[-1], x) for row in at_knots])
    return Grid(spline.ravel(), within.ravel(), reach, slopes, mean, power, g)
