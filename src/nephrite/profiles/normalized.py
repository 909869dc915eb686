"""Normalized diffusion of Christensen and Burley (2015): two exponentials fitted to Monte Carlo simulations.

`R(r) = A (e^(-r/d) + e^(-r/(3d))) / (8 pi d r)`, whose integral is A. The length d is a free path divided by a fitted
function of A, in three parametrisations:

- "searchlight": light enters along the normal, `d = mfp / (1.85 - A + 7 |A - .8|^3)`;
- "diffuse": light enters evenly, `d = mfp / (1.9 - A + 3.5 (A - .8)^2)`;
- "dmfp": by the diffuse mean free path, `d = dmfp / (3.5 + 100 (A - .33)^4)`.

`make` goes by the third, whose fit is nearest under an interface, which spreads the light: the others were made
without. A is the exact total in even light (`nephrite.physics.color`); dmfp = 1 / sigma_tr with Grosjean's `sigma_tr^2
= 3 sigma_a sigma_t'^2 / (2 sigma_a + sigma_s')`, as in the authors' photon beam diffusion, but at most 60 mean free
paths: with less absorption, a half-space's profile hardly grows wider.
"""

from __future__ import annotations

import math
from typing import Any

from nephrite.errors import unknown_name
from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike
from nephrite.physics.color import color_map
from nephrite.profiles._poles import LEAST_EXTINCTION
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "PARAMETRISATIONS", "NormalizedDiffusion"]

PARAMETRISATIONS = ("searchlight", "diffuse", "dmfp")

_CLOSEST = 1e-6  # of d, within which R stays as it is there
_LONGEST = 60.0  # mean free paths


class NormalizedDiffusion(RadialProfile):
    """The profile of total `color` A in [0, 1], and of the `length` (1/unit of the coefficients) that it scales with.

    `length`: mean free path, or diffuse mean free path with the parametrisation "dmfp". Floats, NumPy or Dr.Jit arrays.
    Raises `ParameterError` for an unknown parametrisation.
    """

    def __init__(self, color: Any, length: Any, parametrisation: str = "searchlight") -> None:
        """Derive d (Christensen and Burley 2015, equations 6, 7 and 8)."""
        if parametrisation not in PARAMETRISATIONS:
            raise unknown_name("parametrisation", parametrisation, PARAMETRISATIONS)
        from_peak = color - 0.8
        if parametrisation == "searchlight":
            distance = namespace(color).abs(from_peak)
            scale = 1.85 - color + 7.0 * distance * distance * distance
        elif parametrisation == "diffuse":
            scale = 1.9 - color + 3.5 * from_peak * from_peak
        else:
            squared = (color - 0.33) * (color - 0.33)
            scale = 3.5 + 100.0 * squared * squared
        self.color = color
        self.d = plain(length / scale)

    def reach(self) -> Any:
        """Length within which 99 % leaves."""
        return 13.0 * self.d

    def _decay(self, r: Any) -> tuple[Any, Any]:
        """Return e^(-r/d) and e^(-r/(3d))."""
        slow = namespace(r, self.d).exp(r / (-3.0 * self.d))
        return slow * slow * slow, slow

    def eval(self, r: Any) -> Any:
        """R(r) per area (Christensen and Burley 2015, equation 3)."""
        r = namespace(r, self.d).maximum(r, _CLOSEST * self.d)
        fast, slow = self._decay(r)
        return plain(self.color * (fast + slow) / (8.0 * math.pi * self.d * r))

    def albedo(self) -> Any:
        """The colour A: exact."""
        return plain(self.color + 0.0 * self.d)

    def cdf(self, r: Any) -> Any:
        """Fraction within r: `1 - e^(-r/d)/4 - 3 e^(-r/(3d))/4` (Christensen and Burley 2015, equation 11)."""
        fast, slow = self._decay(r)
        return plain(1.0 - 0.25 * fast - 0.75 * slow)

    def pdf(self, r: Any) -> Any:
        """Density of `sample` per length; does not depend on A but through d."""
        fast, slow = self._decay(r)
        return plain((fast + slow) / (4.0 * self.d))

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius for one uniform number, by the exact inverse of the cdf (Golubev 2018, a cubic in e^(r/(3d)))."""
        xp = namespace(u, self.d)
        left = xp.maximum(1.0 - u, 1e-9)
        root = 1.0 + 4.0 * left * (2.0 * left + xp.sqrt(1.0 + 4.0 * left * left))
        cube = xp.exp(xp.log(root) * (1.0 / 3.0))
        r = 3.0 * self.d * xp.log((1.0 + cube + 1.0 / cube) / (4.0 * left))
        return plain(xp.maximum(r, 0.0))


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> NormalizedDiffusion:
    """Build the profile by the diffuse mean free path; `g` counts in the total only."""
    colors = color_map(eta, g)
    sigma_a = alike(sigma_a, eta, g)
    xp = namespace(sigma_a, sigma_s_prime)
    sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
    share = sigma_a / sigma_t_prime
    falloff = xp.maximum(xp.sqrt(3.0 * share / (1.0 + share)), 1.0 / _LONGEST)
    total = colors.of_coefficients(sigma_a, sigma_s_prime / (1.0 - g))
    return NormalizedDiffusion(total, 1.0 / sigma_t_prime / falloff, "dmfp")


MODEL = Model(
    name="normalized",
    title="Normalized diffusion",
    source="Christensen, Burley (2015): Approximate reflectance profiles for efficient subsurface scattering",
    terms="single+multiple",
    make=make,
)
