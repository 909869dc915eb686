"""The standard dipole of Jensen et al. (2001): a source below the surface and its mirror image above.

R(r) is the sum of two terms, one for each pole, `albedo'/(4 pi) z (1 + sigma_tr d) e^(-sigma_tr d) / d^3` with
d^2 = r^2 + z^2 (their equation 4). Each integrates to `albedo'/2 e^(-sigma_tr z)` over the plane, with the
antiderivative `-z e^(-sigma_tr d) / d`, so that the radius can be drawn exactly: pick a pole by its share, then
solve `d e^(sigma_tr d) = z e^(sigma_tr z) / (1 - u)`.
"""

from __future__ import annotations

import math
from typing import Any

from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike
from nephrite.physics.fresnel import boundary_factor
from nephrite.profiles._poles import LEAST_EXTINCTION
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "StandardDipole"]

_NEWTON_STEPS = 4  # residual of the CDF under 2e-8


class StandardDipole(RadialProfile):
    """The profile of a medium with absorption `sigma_a` and reduced scattering `sigma_s_prime`.

    `boundary`: the A of `nephrite.physics.fresnel.boundary_factor(eta)`. Coefficients in 1/length; floats, NumPy
    or Dr.Jit arrays of any common shape. Without extinction the profile is 0.
    """

    def __init__(self, sigma_a: Any, sigma_s_prime: Any, boundary: Any) -> None:
        """Derive the depths of the poles (Jensen et al. 2001, section 2.3)."""
        sigma_a = alike(sigma_a, boundary)
        xp = namespace(sigma_a, sigma_s_prime)
        sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
        self.albedo_prime = plain(sigma_s_prime / sigma_t_prime)
        self.sigma_tr = plain(xp.sqrt(3.0 * sigma_a) * xp.sqrt(sigma_t_prime))
        self.z_real = plain(1.0 / sigma_t_prime)
        self.z_virtual = plain(self.z_real * (1.0 + (4.0 / 3.0) * boundary))

    def reach(self) -> Any:
        """Length within which nearly all leaves: where the slower of the two poles' terms has fallen to 1 or 2 %."""
        return 1.0 / (0.02 / self.z_virtual + 0.25 * self.sigma_tr)

    def _term(self, r: Any, z: Any) -> Any:
        xp = namespace(r, z)
        d = xp.sqrt(r * r + z * z)
        falloff = self.sigma_tr * d
        return z * (1.0 + falloff) * xp.exp(-falloff) / (d * d * d)

    def eval(self, r: Any) -> Any:
        """R(r) per area, equation 4 of Jensen et al. (2001)."""
        return plain(
            self.albedo_prime / (4.0 * math.pi) * (self._term(r, self.z_real) + self._term(r, self.z_virtual))
        )

    def _shares(self) -> tuple[Any, Any]:
        xp = namespace(self.sigma_tr)
        return plain(xp.exp(-self.sigma_tr * self.z_real)), plain(xp.exp(-self.sigma_tr * self.z_virtual))

    def albedo(self) -> Any:
        """Total diffuse reflectance `(albedo'/2) (1 + e^(-(4/3) A s)) e^(-s)`, s = sqrt(3 (1 - albedo'))."""
        real, virtual = self._shares()
        return plain(0.5 * self.albedo_prime * (real + virtual))

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        xp = namespace(r, self.sigma_tr)
        real, virtual = self._shares()

        def beyond(z: Any) -> Any:
            d = xp.sqrt(r * r + z * z)
            return z * xp.exp(-self.sigma_tr * d) / d

        return plain(1.0 - (beyond(self.z_real) + beyond(self.z_virtual)) / xp.maximum(real + virtual, 1e-30))

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius distributed as `pdf`, for uniform numbers in [0, 1): `v` chooses the pole."""
        xp = namespace(u, v, self.sigma_tr)
        real, virtual = self._shares()
        z = xp.select(v * (real + virtual) < real, self.z_real, self.z_virtual)
        # d = z e^y, y + t (e^y - 1) = -ln(1 - u): Newton's method from the right, where it can't overshoot
        t, target = self.sigma_tr * z, -xp.log(1.0 - u)
        y = xp.minimum(target, xp.log(1.0 + target / xp.maximum(t, 1e-30)))
        for _ in range(_NEWTON_STEPS):
            grown = t * xp.exp(y)
            y = y - (y + grown - t - target) / (1.0 + grown)
        d = z * xp.exp(y)
        return plain(xp.sqrt(xp.maximum(d * d - z * z, 0.0)))

    def pdf(self, r: Any) -> Any:
        """Density of `sample` per length: `2 pi r R(r) / albedo()`."""
        xp = namespace(r, self.sigma_tr)
        real, virtual = self._shares()
        terms = self._term(r, self.z_real) + self._term(r, self.z_virtual)
        return plain(r * terms / xp.maximum(real + virtual, 1e-30))


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> StandardDipole:
    """Build the dipole under an interface; it knows of `g` only what is in the reduced scattering."""
    return StandardDipole(sigma_a, sigma_s_prime, boundary_factor(eta))


MODEL = Model(
    name="dipole",
    title="Standard dipole",
    source="Jensen, Marschner, Levoy, Hanrahan (2001): A practical model for subsurface light transport",
    # They add single scattering to it; but the dipole alone sends out all that isn't absorbed
    terms="single+multiple",
    make=make,
)
