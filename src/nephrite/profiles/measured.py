"""A profile that was measured: a CSV file of r and R, one column of R or three for red, green and blue.

Between the radii R is linear, within the first it is as there, beyond the last it is 0: the integral, the cdf and its
inverse are exact for that. R is per area and per light that has entered, in the square of the unit of 1/r.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace, plain
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MeasuredProfile", "model", "read"]

_MOST = 1.01  # of the light may leave: measurements have errors
_BISECTIONS = 40


class MeasuredProfile(RadialProfile):
    """The profile through the points `radii` [N] (length, rising, >= 0) and `values` [N] (1/length^2, >= 0), N >= 2.

    Works with floats, NumPy arrays and Dr.Jit arrays of one dimension; the points themselves are numbers. Raises
    `ParameterError` for points that are none such, or that add up to more than the light that enters.
    """

    def __init__(self, radii: Sequence[float] | np.ndarray, values: Sequence[float] | np.ndarray) -> None:
        """Check the points and integrate between them."""
        r, value = np.asarray(radii, dtype=np.float64), np.asarray(values, dtype=np.float64)
        if r.ndim != 1 or r.shape != value.shape or r.size < 2:
            raise ParameterError(
                f"there are {r.size} radii and {value.size} values: at least two of each are needed, as many of both."
            )
        _check_points(r, value)
        if r[0] > 0.0:
            r, value = np.concatenate([[0.0], r]), np.concatenate([value[:1], value])
        self._radii, self._values = r, value
        self._slopes = np.append(np.diff(value) / np.diff(r), 0.0)
        masses = _mass(r[:-1], value[:-1], self._slopes[:-1], r[1:])
        self._cumulative = np.concatenate([[0.0], np.cumsum(masses)])
        if not 0.0 < self._cumulative[-1] <= _MOST:
            raise ParameterError(
                f"the profile adds up to {self._cumulative[-1]:.4g} of the light that enters, but it must be above 0 "
                "and not above 1: R is per area, in 1/mm^2 if r is in mm; scale it, or check the units."
            )

    def reach(self) -> float:
        """Last radius: nothing leaves beyond."""
        return float(self._radii[-1])

    def albedo(self) -> float:
        """Integral of 2 pi r R."""
        return float(self._cumulative[-1])

    def eval(self, r: Any) -> Any:
        """R(r) per area."""
        first, value, slope, _ = self._find(self._radii, r)
        inside = namespace(r).select(r < self.reach(), value + slope * (r - first), 0.0)
        return plain(inside)

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        xp = namespace(r)
        r = xp.minimum(r, self.reach())
        first, value, slope, before = self._find(self._radii, r)
        return plain((before + _mass(first, value, slope, r)) / self.albedo())

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius for one uniform number: the cell by its mass, the place in it by bisection."""
        xp = namespace(u)
        target = u * self.albedo()
        low, value, slope, before = self._find(self._cumulative, target)
        first = low
        high = low + self._find(self._cumulative, target, np.append(np.diff(self._radii), 0.0))
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            less = before + _mass(first, value, slope, middle) < target
            low, high = xp.select(less, middle, low), xp.select(less, high, middle)
        return plain(self._differentiable(0.5 * (low + high), u))

    def _find(self, table: np.ndarray, x: Any, *wanted: np.ndarray) -> Any:
        """Look up, for the interval of `table` that x is in, the first radius, its value, slope and mass before it."""
        wanted = wanted or (self._radii, self._values, self._slopes, self._cumulative)
        xp, last = namespace(x), table.size - 2
        if not hasattr(xp, "gather"):
            index = np.clip(np.searchsorted(table, x, side="right") - 1, 0, last)
            found = [column[index] for column in wanted]
        else:
            real = xp.detached_t(type(x))
            edges = real(table)
            index = xp.binary_search(0, last + 1, lambda i: xp.gather(real, edges, i) <= xp.detach(x))
            index = xp.clip(index, 1, last + 1) - 1
            found = [xp.gather(real, real(column), index) for column in wanted]
        return found if len(found) > 1 else found[0]


def model(profile: MeasuredProfile) -> Model:
    """Return the profile as a model, whatever the coefficients."""

    def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> MeasuredProfile:
        return profile

    return Model("measured", "Measured", "a CSV file", "single+multiple", make)


def _mass(first: Any, value: Any, slope: Any, r: Any) -> Any:
    """Integral of 2 pi r R from `first` to r, for R = value + slope (r - first)."""
    step = r - first
    return math.pi * step * (value * (r + first) + slope * step * (first + step * (2.0 / 3.0)))


def _check_points(r: np.ndarray, value: np.ndarray) -> None:
    for what, column in (("r", r), ("R", value)):
        wrong = np.flatnonzero(~(np.isfinite(column) & (column >= 0.0)))
        if wrong.size:
            raise ParameterError(
                f"{what} of point {wrong[0] + 1} is {column[wrong[0]]:g}, but it must be a number and not below 0: "
                "leave out such points, or set noise below 0 to 0."
            )
    back = np.flatnonzero(np.diff(r) <= 0.0)
    if back.size:
        i = int(back[0])
        raise ParameterError(
            f"r of point {i + 2} is {r[i + 1]:g}, after {r[i]:g}: sort the points by r and give each r once."
        )


def read(path: str | Path) -> tuple[MeasuredProfile, ...]:
    """Read a CSV of r (mm) and R (1/mm^2): one profile if R has one column, three - red, green, blue - if it has three.

    Columns are separated by commas, semicolons, tabs or blanks; `#` begins a comment; one line of names may come first.
    Raises `ParameterError` that names the file and, where there is one, the line.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"cannot read the profile {path}: {error}.") from error
    rows: list[list[float]] = []
    seen = 0
    for number, line in enumerate(lines, 1):
        fields = [field for field in re.split(r"[,;\s]+", line.split("#")[0].strip()) if field]
        if not fields:
            continue
        seen += 1
        try:
            row = [float(field) for field in fields]
        except ValueError as error:
            if seen == 1:
                continue  # names of the columns
            raise ParameterError(
                f"{path}, line {number}: {error}; a line is r and one or three values of R, such as `0.5, 0.012`."
            ) from error
        if len(row) not in (2, 4) or (rows and len(row) != len(rows[0])):
            expected = (
                f"{len(rows[0])}, as in the lines before" if rows else "2 (r, R) or 4 (r, red, green, blue)"
            )
            raise ParameterError(f"{path}, line {number}: {len(row)} numbers, but there must be {expected}.")
        rows.append(row)
    if len(rows) < 2:
        raise ParameterError(
            f"{path} has {len(rows)} lines of numbers, but a profile needs two points or more."
        )
    table = np.array(rows)
    try:
        return tuple(MeasuredProfile(table[:, 0], column) for column in table[:, 1:].T)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from error
