"""The tabulated profile: what exact transport under a smooth interface says, with no diffusion theory.

R(r) comes from a table of simulated searchlights (`python -m nephrite.profiles.tabulate` makes it; see
`nephrite.profiles.tabulated_shape`), its integral from an exact solution (`nephrite.physics.halfspace`). For rendering,
light arrives from everywhere and has scattered twice or more often: the default. The classical searchlight is
`incidence="normal", orders="all"`.

Over the table's range - albedo' in [0, 1], eta in [1, 1.85], g in [0, .95] - the total is exact to 2e-4, and the
profile within 2 % (g = 0) or 5 % (L1) of fresh simulations, their noise included: tests/profiles/test_tabulated.py.
Outside of it the *shape* is the nearest one of the table, and the total is exact still.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nephrite.errors import unknown_name
from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike, checked, lift
from nephrite.physics.fresnel import check_eta
from nephrite.physics.phase import check_g
from nephrite.profiles import tabulated_grid, tabulated_shape
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "TabulatedProfile"]

_X_MIN = math.log(tabulated_shape.R_MIN)
_COLUMNS = tabulated_grid.CELLS + 3
_EDGES = tabulated_grid.CELLS + 1
_LEAST_ABSORBED = 1e-12  # of the light in an event; less than that has no derivative


class TabulatedProfile(RadialProfile):
    """The profile of a medium with absorption `sigma_a` and reduced scattering `sigma_s_prime` under an interface.

    | parameter                 | meaning                                                                             |
    | ------------------------- | ----------------------------------------------------------------------------------- |
    | `sigma_a`, `sigma_s_prime`| 1/length; floats, NumPy or Dr.Jit arrays that broadcast                              |
    | `eta`, `g`                | inside / outside, mean cosine: each pair is prepared once                            |
    | `incidence`               | "diffuse" or "normal": how light enters                                              |
    | `orders`                  | "multiple" (scattered twice or more often) or "all"                                  |

    A cubic spline in ln r and in the fourth root of `1 - albedo'`: smooth and differentiable in r, sigma_a and
    sigma_s_prime. Raises `ParameterError`.
    """

    def __init__(
        self,
        sigma_a: Any,
        sigma_s_prime: Any,
        eta: Any,
        g: Any = 0.0,
        incidence: str = "diffuse",
        orders: str = "multiple",
    ) -> None:
        """Look up the grid of `eta` and `g`."""
        for name, value, known in (
            ("incidence", incidence, tabulated_shape.INCIDENCES),
            ("orders", orders, ("multiple", "all")),
        ):
            if value not in known:
                raise unknown_name(name, value, known)
        eta, g = checked(check_eta, eta), checked(check_g, g)
        self.grid = lift(lambda *at: tabulated_grid.grid(*at, incidence, orders), eta, g)
        sigma_a = alike(sigma_a, eta, g)
        xp = namespace(sigma_a, sigma_s_prime)
        self.sigma_t_prime = plain(xp.maximum(sigma_a + sigma_s_prime, 1e-20))
        self.albedo_prime = plain(sigma_s_prime / self.sigma_t_prime)
        self.t = plain(
            xp.sqrt(xp.sqrt(xp.minimum(xp.maximum(sigma_a / self.sigma_t_prime, _LEAST_ABSORBED), 1.0)))
        )
        self._rows = tabulated_shape.bspline(self._row()[1])
        self._tables: dict[Any, Any] = {}

    def _row(self) -> tuple[Any, Any]:
        """Return the first of the four rows that the albedo mixes, and the place between the middle two."""
        return _cell(self.t * tabulated_grid.ROWS, tabulated_grid.ROWS)

    def _column(self, r: Any) -> tuple[Any, Any, Any]:
        """Return the first of four columns, the place in its interval, and r >= R_MIN in reduced mean free paths."""
        xp = namespace(r, self.sigma_t_prime)
        length = xp.maximum(r * self.sigma_t_prime, tabulated_shape.R_MIN)
        column, u = _cell((xp.log(length) - _X_MIN) / tabulated_grid.STEP, tabulated_grid.CELLS)
        return column, u, length

    def _density(self, r: Any) -> tuple[Any, Any]:
        """Light per unit of ln r, without the power of the albedo', and r >= R_MIN in reduced mean free paths."""
        xp = namespace(r, self.t)
        column, u, length = self._column(r)
        total = sum(w * self._mixed("light", column + k) for k, w in enumerate(tabulated_shape.bspline(u)))
        return xp.select(length > tabulated_shape.R_MAX, 0.0, total), length

    def _scale(self) -> Any:
        """Power of the single-scattering albedo that the grid leaves out."""
        albedo = tabulated_shape.albedo_of(self.albedo_prime, self.grid.g)
        return albedo if self.grid.power == 1 else albedo * albedo

    def eval(self, r: Any) -> Any:
        """R(r) per area."""
        density, length = self._density(r)
        scale = self._scale() * self.sigma_t_prime * self.sigma_t_prime
        return plain(scale * density / (2.0 * math.pi * length * length))

    def _total(self) -> Any:
        return self._mixed("within", 0 * self._row()[0] + tabulated_grid.CELLS)

    def albedo(self) -> Any:
        """Integral of 2 pi r R(r): the exact share of the entered light."""
        return plain(self._scale() * self._total())

    def pdf(self, r: Any) -> Any:
        """Density of `sample` per length: `2 pi r R(r) / albedo()`."""
        density, length = self._density(r)
        return plain(
            density / self._total() * (r * self.sigma_t_prime / length) / length * self.sigma_t_prime
        )

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        column, u, length = self._column(r)
        xp = namespace(r, self.t)
        share = xp.minimum(r * self.sigma_t_prime / length, 1.0)
        total = self._mixed("within", column) - self._mixed("within", 0 * column) * (1.0 - share * share)
        for k, weight in enumerate(tabulated_grid.integrals(u)):
            total += tabulated_grid.STEP * weight * self._mixed("light", column + k)
        return plain(xp.minimum(total / self._total(), 1.0))

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius distributed as `pdf`; `u` uniform in [0, 1), `v` is not used."""
        xp = namespace(u, self.t)
        light = u * self._total()
        inner = self._mixed("within", 0 * self._row()[0])
        low, high = _whole(light * 0.0), _whole(light * 0.0) + tabulated_grid.CELLS
        for _ in range(tabulated_grid.CELLS.bit_length()):
            middle = (low + high) // 2
            right = self._mixed("within", middle) <= light
            low, high = xp.select(right, middle, low), xp.select(right, high, middle)
        low = xp.minimum(low, tabulated_grid.CELLS - 1)
        rest = (light - self._mixed("within", low)) / tabulated_grid.STEP
        place = _invert([self._mixed("light", low + k) for k in range(4)], rest)
        x = _X_MIN + tabulated_grid.STEP * (low + place)
        center = tabulated_shape.R_MIN * xp.sqrt(xp.minimum(light / xp.maximum(inner, 1e-30), 1.0))
        return plain(
            self._differentiable(xp.select(light < inner, center, xp.exp(x)) / self.sigma_t_prime, u)
        )

    def reach(self) -> Any:
        """Length within which 99 % of the light leaves."""
        xp = namespace(self.t)
        return plain(xp.exp(self._at_t("reach")) / self.sigma_t_prime)

    def lobe_slope(self) -> Any:
        """Slope of the exit lobe: light leaves as `(1 - F) cos / (c pi)` times `1 + slope (cos_inside - mean_cosine)`.

        Of light that entered diffusely and scattered twice or more often (`nephrite.physics.halfspace.lobe_slope`);
        `mean_cosine` is the attribute. With the slope, at least nine tenths of the plain lobe's error are gone for
        eta >= 1.3, and half at eta = 1: tests/physics/test_halfspace.py.
        """
        return plain(self._at_t("slope"))

    @property
    def mean_cosine(self) -> float:
        """Mean of the cosine inside under the plain exit lobe."""
        return self.grid.mean_cosine

    def _at_t(self, name: str) -> Any:
        row, u = self._row()
        low, high = self._take(name, row), self._take(name, row + 1)
        return low + (high - low) * u

    def _mixed(self, name: str, column: Any) -> Any:
        """Mix a column of the grid's `light` or `within` as the albedo asks for."""
        width = _COLUMNS if name == "light" else _EDGES
        row = self._row()[0]
        return sum(w * self._take(name, (row + j) * width + column) for j, w in enumerate(self._rows))

    def _take(self, name: str, index: Any) -> Any:
        """Values of one of the grid's arrays at whole numbers, whatever kind of array holds those."""
        table = getattr(self.grid, name)
        xp = namespace(index)
        if not hasattr(xp, "gather"):
            return table[index]
        if xp.depth_v(index) > 1:
            parts = [self._take(name, part) for part in index]
            return _floating(xp, type(index))(*parts)
        kind = _floating(xp, type(index))
        if (name, kind) not in self._tables:
            self._tables[name, kind] = kind(table)
        return xp.gather(kind, self._tables[name, kind], xp.uint32_array_t(type(index))(index))


def _floating(xp: Any, index: Any) -> Any:
    """Return the Dr.Jit type whose precision `_whole` has kept in the type of an index."""
    return xp.float64_array_t(index) if xp.type_v(index) == xp.VarType.UInt64 else xp.float32_array_t(index)


def _cell(place: Any, count: int) -> tuple[Any, Any]:
    """Return the interval, below `count`, and the place in it in [0, 1]."""
    xp = namespace(place)
    place = xp.minimum(xp.maximum(place, 0.0), float(count))
    whole = _whole(xp.minimum(place, count - 0.5))
    return whole, place - whole


def _whole(value: Any) -> Any:
    """Round down what is not negative to whole numbers that can be indices, of as many bits as the value has."""
    xp = namespace(value)
    if not hasattr(xp, "gather"):
        return np.asarray(value).astype(np.int64)
    kind = type(value)
    return (xp.uint64_array_t if xp.type_v(kind) == xp.VarType.Float64 else xp.uint32_array_t)(kind)(value)


def _invert(near: list[Any], rest: Any) -> Any:
    """Solve for the place in [0, 1] of a cell up to which its light, a quartic that rises, is `rest`."""
    xp = namespace(rest, near[0])
    place, half = rest * 0.0 + 0.5, 0.25
    for _ in range(10):
        light = sum(c * w for c, w in zip(near, tabulated_grid.integrals(place), strict=True))
        place = xp.select(light < rest, place + half, place - half)
        half = 0.5 * half
    for _ in range(2):
        light = sum(c * w for c, w in zip(near, tabulated_grid.integrals(place), strict=True))
        slope = sum(c * w for c, w in zip(near, tabulated_shape.bspline(place), strict=True))
        move = (rest - light) / xp.maximum(slope, 1e-30)
        place = xp.minimum(xp.maximum(place + xp.minimum(xp.maximum(move, -1e-3), 1e-3), 0.0), 1.0)
    return place


MODEL = Model(
    "tabulated",
    "Tabulated transport",
    "this package: simulated searchlights with the exact total (nephrite.physics)",
    "multiple",
    TabulatedProfile,
    finite=True,
)
