"""What a half-space under a smooth interface sends out in all: the one place where the profiles' `A` comes from.

Models that only give a shape - normalized diffusion - need the total from elsewhere. It is
`nephrite.physics.halfspace.total_reflectance`, exact transport with the interface and the phase function, as a
polynomial in s = sqrt(sigma_a / sigma_t'), in which it is smooth: made once for each eta and g, then cheap for arrays
and differentiable. Another map from coefficients to A - one that knows roughness - goes here.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from nephrite.physics._arrays import namespace, plain
from nephrite.physics.fresnel import check_eta
from nephrite.physics.halfspace import total_reflectance
from nephrite.physics.phase import check_g
from nephrite.profiles._poles import LEAST_EXTINCTION

__all__ = ["surface_albedo"]

_DEGREE = 18


def surface_albedo(
    sigma_a: Any, sigma_s_prime: Any, eta: float, g: float = 0.0, incidence: str = "normal"
) -> Any:
    """Share of the light that has entered a half-space and leaves it again, in [0, 1].

    Coefficients in 1/length, scattering reduced: floats, NumPy or Dr.Jit arrays. `eta`: inside / outside, `g`: mean
    cosine, numbers; `incidence`: "normal" or "diffuse". The polynomial is within 3e-5 of the exact value for eta from
    .7 to 2 and g from 0 to .95. Raises `ParameterError`.
    """
    xp = namespace(sigma_a, sigma_s_prime)
    absorbed = sigma_a / xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
    # an empty medium scatters nothing: as if all were absorbed
    s = xp.select(sigma_s_prime > 0.0, xp.sqrt(xp.minimum(absorbed, 1.0)), 1.0)
    value = (1.0 - s) * _clenshaw(_coefficients(check_eta(eta), check_g(g), incidence), 2.0 * s - 1.0)
    return plain(xp.minimum(xp.maximum(value, 0.0), 1.0))


@lru_cache(maxsize=256)
def _coefficients(eta: float, g: float, incidence: str) -> tuple[float, ...]:
    """Chebyshev coefficients of A / (1 - s) over s in [0, 1]: s = 1 is no scattering."""
    points = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
    values = []
    for s in 0.5 * (points + 1.0):
        reduced = 1.0 - s * s
        albedo = float(reduced / (reduced + s * s * (1.0 - g)))
        values.append(total_reflectance(albedo, eta, g, incidence) / (1.0 - s))
    return tuple(float(c) for c in np.polynomial.chebyshev.chebfit(points, values, _DEGREE))


def _clenshaw(coefficients: tuple[float, ...], x: Any) -> Any:
    """Value of a Chebyshev series at x in [-1, 1]."""
    last, before = 0.0, 0.0
    for c in coefficients[:0:-1]:
        last, before = 2.0 * x * last - before + c, last
    return x * last - before + coefficients[0]
