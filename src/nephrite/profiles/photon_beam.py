"""Photon beam diffusion of Habel, Christensen and Jarosz (2013): the better dipole along the whole refracted beam.

Light enters at normal incidence. At each depth z, the beam `sigma_t' e^(-sigma_t' z)` is the source of a better
dipole; what leaves close to it, where diffusion sends out too much, is weighted by the empirical
`1 - e^(-2 sigma_t' (d + z))`. Single scattering is integrated along the same beam with the phase function and the
interface, from the depth `r sqrt(eta^2 - 1)` on, above which all is reflected back. Both integrals run over the
logarithm of the depth, with the trapezoidal rule: R(r) grows like a logarithm (1/r: the single part) towards r = 0,
and an even spread of depths would not see it.
"""

from __future__ import annotations

import math
from typing import Any

from nephrite.physics import phase
from nephrite.physics._arrays import namespace, plain, root
from nephrite.physics._lift import alike, checked
from nephrite.physics.fresnel import c1, c2, check_eta, reflectance
from nephrite.physics.phase import check_g
from nephrite.profiles._poles import LEAST_EXTINCTION, distance, fluence, flux
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "PhotonBeam"]

_NODES = 32
_START = -8.0  # ln(depth / shorter of r and the mean free path) of the first node
_END = math.log(35.0)  # ln(depth / mean free path) of the last: e^-35 of the beam is left
_CLOSEST = 1e-6  # mean free paths within which R stays as it is there


class PhotonBeam(RadialProfile):
    """The profile of a medium with absorption `sigma_a` and reduced scattering `sigma_s_prime` (1/length).

    `eta`: inside / outside, `g`: mean cosine of scattering: single scattering sees the medium as it is, not
    reduced. Its totals and radii are found by quadrature.
    """

    parts = _NODES

    def __init__(self, sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> None:
        """Derive the coefficients of diffusion (Habel et al. 2013, sections 3 and 4)."""
        self.eta, self.g = checked(check_eta, eta), checked(check_g, g)
        sigma_a = alike(sigma_a, eta, g)
        xp = namespace(sigma_a, sigma_s_prime)
        sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
        diffusion = (2.0 * sigma_a + sigma_s_prime) / sigma_t_prime / (3.0 * sigma_t_prime)
        diffusion = xp.maximum(diffusion, LEAST_EXTINCTION)
        first, second = c1(eta), c2(eta)
        self.albedo_prime = plain(sigma_s_prime / sigma_t_prime)
        self.sigma_tr = plain(xp.sqrt(sigma_a / diffusion))
        self.mfp_prime = plain(1.0 / sigma_t_prime)
        self.sigma_s = plain(sigma_s_prime / (1.0 - self.g))
        self.sigma_t = plain(xp.maximum(sigma_a + self.sigma_s, LEAST_EXTINCTION))
        self.image = plain(4.0 * (1.0 + 3.0 * second) / (1.0 - 2.0 * first) * diffusion)
        self.of_flux = 0.5 * (1.0 - 3.0 * second)
        self.steepest = plain(root(namespace(self.eta).maximum(self.eta * self.eta - 1.0, 0.0)))
        self.of_fluence = plain(0.25 * (1.0 - 2.0 * first) / diffusion)

    def reach(self) -> Any:
        """Length within which nearly all leaves, as for the standard dipole."""
        return 1.0 / (0.02 / (self.mfp_prime + self.image) + 0.25 * self.sigma_tr)

    def eval(self, r: Any) -> Any:
        """R(r) per area, single scattering included."""
        return plain(self.multiple(r) + self.single(r))

    def multiple(self, r: Any) -> Any:
        """Part of R(r) that has scattered at least twice (Habel et al. 2013, equations 8 to 11)."""
        return sum(self._multiple_from(r, k) for k in range(self.parts))

    def single(self, r: Any) -> Any:
        """Part of R(r) that has scattered once (Habel et al. 2013, equation 13)."""
        return sum(self._single_from(r, k) for k in range(self.parts))

    def _part(self, r: Any, k: Any) -> Any:
        return self._multiple_from(r, k) + self._single_from(r, k)

    def _multiple_from(self, r: Any, k: Any) -> Any:
        """Node k of the integral over the source's depth."""
        xp = namespace(r, self.mfp_prime, k)
        r = xp.maximum(r, _CLOSEST * self.mfp_prime)
        z, weight = _depth(k, r, self.mfp_prime)
        far = z + self.image
        sent = self.of_flux * (flux(r, z, self.sigma_tr) + flux(r, far, self.sigma_tr))
        sent = sent + self.of_fluence * fluence(r, z, far, self.sigma_tr)
        depth = z / self.mfp_prime
        close = 1.0 - xp.exp(-2.0 * (distance(r, z) / self.mfp_prime + depth))
        strength = self.albedo_prime * self.albedo_prime / (4.0 * math.pi * self.mfp_prime)
        return strength * weight * close * xp.exp(-depth) * sent

    def _single_from(self, r: Any, k: Any) -> Any:
        """Node k of the integral over the depth of the only event, counted from where light begins to get out."""
        xp = namespace(r, self.sigma_t, k)
        r = xp.maximum(r, _CLOSEST / self.sigma_t)
        z, weight = _depth(k, r, 1.0 / self.sigma_t)
        z = z + r * self.steepest
        d = distance(r, z)
        cosine = z / d
        leaving = (1.0 - reflectance(-cosine, self.eta)) * cosine / (d * d)
        scattered = self.sigma_s * phase.eval(-cosine, self.g) * leaving
        return weight * scattered * xp.exp(-self.sigma_t * (z + d))


def _depth(k: Any, r: Any, mfp: Any) -> tuple[Any, Any]:
    """Node k of an integral over all depths on the scales of both r and the mean free path, and its weight."""
    xp = namespace(k, r, mfp)
    first = xp.log(r / (1.0 + r / mfp)) + _START
    step = (xp.log(mfp) + _END - first) / (_NODES - 1)
    z = xp.exp(first + step * k)
    return z, step * z


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> PhotonBeam:
    """Build the profile of a photon beam."""
    return PhotonBeam(sigma_a, sigma_s_prime, eta, g)


MODEL = Model(
    name="photon_beam",
    title="Photon beam diffusion",
    source="Habel, Christensen, Jarosz (2013): Photon beam diffusion",
    terms="single+multiple",
    make=make,
)
