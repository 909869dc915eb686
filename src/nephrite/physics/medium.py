"""A homogeneous translucent medium and every coefficient that follows from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nephrite.errors import ParameterError
from nephrite.physics.fresnel import boundary_factor, check_eta
from nephrite.physics.phase import check_g

__all__ = ["RGB", "Medium", "rgb"]

RGB = tuple[float, float, float]


def rgb(value: float | Sequence[float] | np.ndarray | Any, name: str) -> RGB:
    """Return one number or three as a tuple of three floats, each finite and >= 0; errors name `name`."""
    try:
        numbers = [float(v) for v in np.ravel(np.asarray(value, dtype=np.float64))]
    except (TypeError, ValueError):
        numbers = []
    if isinstance(value, (str, bool)) or len(numbers) not in (1, 3):
        raise ParameterError(f"{name} is {value!r}: give one number, or three for red, green and blue.")
    for number in numbers:
        if not math.isfinite(number):
            raise ParameterError(f"{name} is {value!r}: every channel must be a finite number.")
        if number < 0:
            raise ParameterError(
                f"{name} is {value!r}: no channel can be negative; use 0 where there is none."
            )
    red, green, blue = numbers * 3 if len(numbers) == 1 else numbers
    return red, green, blue


def _quotient(above: float, below: float, empty: float) -> float:
    """`above / below`, `empty` for 0/0, infinite where `below` is 0 or the quotient overflows."""
    if below == 0.0:
        return empty if above == 0.0 else math.inf
    return above / below


@dataclass(frozen=True, init=False)
class Medium:
    """Absorption, scattering, mean cosine and relative index of refraction of a homogeneous medium.

    | field     | meaning                                                         | unit | range            |
    | --------- | --------------------------------------------------------------- | ---- | ---------------- |
    | `sigma_a` | absorption coefficient, RGB; one number serves all channels      | 1/mm | >= 0, finite     |
    | `sigma_s` | scattering coefficient (*not* reduced), RGB or one number        | 1/mm | >= 0, finite     |
    | `g`       | mean cosine of the Henyey-Greenstein phase function              | -    | inside (-1, 1)   |
    | `eta`     | index of refraction inside / outside                             | -    | > 0, finite      |

    Anything else raises `ParameterError`. Measured tables give *reduced* scattering: use `from_reduced`.
    Every derived property is a tuple of three floats and never divides by zero: where nothing absorbs or
    nothing scatters, lengths are infinite, and the albedo of an empty channel is 0. Notation as in Jensen et
    al. (2001), section 2.
    """

    sigma_a: RGB
    sigma_s: RGB
    g: float = 0.0
    eta: float = 1.3

    def __init__(
        self,
        sigma_a: float | Sequence[float] | np.ndarray,
        sigma_s: float | Sequence[float] | np.ndarray,
        g: float = 0.0,
        eta: float = 1.3,
    ) -> None:
        """Check and store the coefficients (1/mm)."""
        object.__setattr__(self, "sigma_a", rgb(sigma_a, "sigma_a"))
        object.__setattr__(self, "sigma_s", rgb(sigma_s, "sigma_s"))
        object.__setattr__(self, "g", check_g(g))
        object.__setattr__(self, "eta", check_eta(eta))

    @classmethod
    def from_reduced(
        cls,
        sigma_a: float | Sequence[float] | np.ndarray,
        sigma_s_prime: float | Sequence[float] | np.ndarray,
        g: float = 0.0,
        eta: float = 1.3,
    ) -> Medium:
        """Build a medium from *reduced* scattering (1/mm): `sigma_s = sigma_s_prime / (1 - g)`."""
        g = check_g(g)
        reduced = rgb(sigma_s_prime, "sigma_s_prime")
        return cls(sigma_a, [value / (1.0 - g) for value in reduced], g, eta)

    def scaled(self, factor: float) -> Medium:
        """Return this medium with both coefficients multiplied: `factor` = mm per scene unit gives 1/unit."""
        return Medium(
            [factor * value for value in self.sigma_a],
            [factor * value for value in self.sigma_s],
            self.g,
            self.eta,
        )

    @property
    def sigma_t(self) -> RGB:
        """Extinction `sigma_a + sigma_s` (1/mm)."""
        return _three(a + s for a, s in zip(self.sigma_a, self.sigma_s, strict=True))

    @property
    def albedo(self) -> RGB:
        """Single-scattering albedo `sigma_s / sigma_t`; 0 where the channel is empty."""
        return _three(_quotient(s, t, 0.0) for s, t in zip(self.sigma_s, self.sigma_t, strict=True))

    @property
    def mfp(self) -> RGB:
        """Mean free path `1 / sigma_t` (mm); infinite where the channel is empty."""
        return _three(_quotient(1.0, t, math.inf) for t in self.sigma_t)

    @property
    def sigma_s_prime(self) -> RGB:
        """Reduced scattering `sigma_s (1 - g)` (1/mm)."""
        return _three(s * (1.0 - self.g) for s in self.sigma_s)

    @property
    def sigma_t_prime(self) -> RGB:
        """Reduced extinction `sigma_a + sigma_s_prime` (1/mm)."""
        return _three(a + s for a, s in zip(self.sigma_a, self.sigma_s_prime, strict=True))

    @property
    def albedo_prime(self) -> RGB:
        """Reduced albedo `sigma_s_prime / sigma_t_prime`; 0 where the channel is empty."""
        return _three(
            _quotient(s, t, 0.0) for s, t in zip(self.sigma_s_prime, self.sigma_t_prime, strict=True)
        )

    @property
    def sigma_tr(self) -> RGB:
        """Effective transport coefficient `sqrt(3 sigma_a sigma_t_prime)` (1/mm); 0 without absorption."""
        return _three(
            math.sqrt(3.0 * a) * math.sqrt(t) for a, t in zip(self.sigma_a, self.sigma_t_prime, strict=True)
        )

    @property
    def dmfp(self) -> RGB:
        """Diffuse mean free path `1 / sigma_tr` (mm); infinite without absorption."""
        return _three(_quotient(1.0, t, math.inf) for t in self.sigma_tr)

    @property
    def diffuse_reflectance(self) -> RGB:
        """Total diffuse reflectance Rd of the dipole with interface (Jensen et al. 2001, section 2.4).

        Light that has entered and leaves again somewhere, per light that has entered a flat half-space; in
        [0, 1].
        """
        boundary = boundary_factor(self.eta)
        channels = []
        for absorbed, extinct in zip(self.sigma_a, self.sigma_t_prime, strict=True):
            # from the absorbed share, not from 1 - albedo': media of albedo .99999 keep their digits
            share = _quotient(absorbed, extinct, 1.0)
            falloff = math.sqrt(3.0 * share)
            both = 1.0 + math.exp((-4.0 / 3.0) * boundary * falloff)
            channels.append(0.5 * (1.0 - share) * both * math.exp(-falloff))
        return _three(channels)


def _three(values: Any) -> RGB:
    red, green, blue = values
    return red, green, blue
