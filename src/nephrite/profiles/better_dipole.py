"""The better dipole of d'Eon (2012): Grosjean's diffusion, exact moments at the boundary, flux and fluence.

Grosjean's approximation takes the first scattering out of the diffusion: the source at one mean free path has the
strength albedo', and what it sends on, another factor albedo'. D = (2 sigma_a + sigma_s') / (3 sigma_t'^2), sigma_tr =
sqrt(sigma_a / D). The image stands at `zr + 4 A D` above the plane, A = (1 + 3 C2) / (1 - 2 C1), and what leaves is
`C_phi` fluence + `C_E` flux, C_phi = (1 - 2 C1) / 4, C_E = (1 - 3 C2) / 2, with the moments C1 and C2 of *internal*
reflection. The profile stands for light that has scattered at least twice.
"""

from __future__ import annotations

import math
from typing import Any

from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike
from nephrite.physics.fresnel import c1, c2
from nephrite.profiles._poles import LEAST_EXTINCTION, fluence, fluence_beyond, flux, flux_beyond
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "BetterDipole"]


class BetterDipole(RadialProfile):
    """The profile of a medium with absorption `sigma_a` and reduced scattering `sigma_s_prime` (1/length).

    `eta`: inside / outside, a number. The closed forms are this package's: d'Eon gives the profile.
    """

    def __init__(self, sigma_a: Any, sigma_s_prime: Any, eta: Any) -> None:
        """Derive the depths of the poles and the factors of flux and fluence (d'Eon 2012, section 3)."""
        sigma_a = alike(sigma_a, eta)
        xp = namespace(sigma_a, sigma_s_prime)
        sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
        diffusion = (2.0 * sigma_a + sigma_s_prime) / sigma_t_prime / (3.0 * sigma_t_prime)
        diffusion = xp.maximum(diffusion, LEAST_EXTINCTION)
        first, second = c1(eta), c2(eta)
        boundary = (1.0 + 3.0 * second) / (1.0 - 2.0 * first)
        self.albedo_prime = plain(sigma_s_prime / sigma_t_prime)
        self.sigma_tr = plain(xp.sqrt(sigma_a / diffusion))
        self.z_real = plain(1.0 / sigma_t_prime)
        self.z_virtual = plain(self.z_real + 4.0 * boundary * diffusion)
        self.of_flux = 0.5 * (1.0 - 3.0 * second)
        self.of_fluence = plain(0.25 * (1.0 - 2.0 * first) / diffusion)

    def reach(self) -> Any:
        """Length within which nearly all leaves, as for the standard dipole."""
        return 1.0 / (0.02 / self.z_virtual + 0.25 * self.sigma_tr)

    def eval(self, r: Any) -> Any:
        """R(r) per area, equation 1 of d'Eon (2012)."""
        near, far, falloff = self.z_real, self.z_virtual, self.sigma_tr
        value = self.of_flux * (flux(r, near, falloff) + flux(r, far, falloff))
        value = value + self.of_fluence * fluence(r, near, far, falloff)
        return plain(self.albedo_prime * self.albedo_prime / (4.0 * math.pi) * value)

    def _beyond(self, r: Any) -> Any:
        """Integral of 2 pi r R from r outwards, without the factor `albedo'^2 / 2`."""
        near, far, falloff = self.z_real, self.z_virtual, self.sigma_tr
        value = self.of_flux * (flux_beyond(r, near, falloff) + flux_beyond(r, far, falloff))
        return value + self.of_fluence * fluence_beyond(r, near, far, falloff)

    def albedo(self) -> Any:
        """Total that leaves after two events or more; 1 without absorption at eta = 1, so that singles come on top."""
        return plain(0.5 * self.albedo_prime * self.albedo_prime * self._beyond(0.0))

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        beyond, whole = self._beyond(r), self._beyond(0.0)
        return plain(1.0 - beyond / namespace(beyond, whole).maximum(whole, 1e-30))


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> BetterDipole:
    """Build the better dipole; it knows of `g` only what is in the reduced scattering."""
    return BetterDipole(sigma_a, sigma_s_prime, eta)


MODEL = Model(
    name="better_dipole",
    title="Better dipole",
    source="d'Eon (2012): A better dipole",
    terms="multiple",
    make=make,
)
