"""The multipole of Donner and Jensen (2005): dipoles mirrored at both faces of a slab of finite thickness.

The fluence vanishes at zb = 2 A D outside either face, so that the source at the depth l has images with the period
P = 2 (thickness + 2 zb): real ones at `i P + l`, virtual ones at `i P - l - 2 zb`, i = ... -1, 0, 1 ... What leaves the
lit face is the sum of their fluxes; what leaves the far one is the same for a source at the depth `thickness - l`.

Beyond `_PAIRS` images the sum goes on as an integral (by the midpoint rule): cut off, it would have a tail r^-3 and
other totals than the infinite sum. A slab thinner than some mean free paths scatters only part of the light: the
source is then at the mean depth of what scatters, and has its share. In a thick slab these are the paper's, one mean
free path and all; in one thinner than a mean free path, the paper's source is outside. The profile stands for all
scattered light, like the standard dipole, which it is if the slab is thick; the light that crosses the slab without
scattering, `e^(-sigma_t' thickness)`, is not in it.
"""

from __future__ import annotations

import copy
import math
from typing import Any

from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import alike
from nephrite.physics.fresnel import boundary_factor
from nephrite.profiles._poles import LEAST_EXTINCTION, decayed, flux, flux_beyond
from nephrite.profiles.base import Model, RadialProfile

__all__ = ["MODEL", "Multipole"]

_PAIRS = 4
_THICKEST = 1e4  # mean free paths: stands for infinity


class Multipole(RadialProfile):
    """What leaves a slab on the side that is lit; `transmitted()` is the profile of the other side.

    `sigma_a`, `sigma_s_prime`: absorption and reduced scattering (1/length); `boundary`: the A of
    `nephrite.physics.fresnel.boundary_factor(eta)`, both faces alike; `thickness`: a length >= 0, may be infinite.
    Floats, NumPy or Dr.Jit arrays.
    """

    def __init__(self, sigma_a: Any, sigma_s_prime: Any, boundary: Any, thickness: Any = math.inf) -> None:
        """Derive source and period (Donner and Jensen 2005, section 3)."""
        sigma_a = alike(sigma_a, boundary)
        xp = namespace(sigma_a, sigma_s_prime, thickness)
        sigma_t_prime = xp.maximum(sigma_a + sigma_s_prime, LEAST_EXTINCTION)
        deep = xp.minimum(thickness * sigma_t_prime, _THICKEST)  # in mean free paths, as all until the end
        scattered = deep * decayed(deep)
        # mean of the depth over the exponential that ends with the slab; 1 if it is thick
        depth = _mean_depth(deep)
        self.strength = plain(sigma_s_prime / sigma_t_prime * scattered)
        self.sigma_tr = plain(xp.sqrt(3.0 * sigma_a) * xp.sqrt(sigma_t_prime))
        self.mfp_prime = plain(1.0 / sigma_t_prime)
        self.outside = plain((2.0 / 3.0) * boundary * self.mfp_prime)
        self.depth = plain(depth * self.mfp_prime)
        self.opposite = plain((deep - depth) * self.mfp_prime)

    def transmitted(self) -> Multipole:
        """Return the profile of what leaves the far face, r from the point opposite to the entry."""
        other = copy.copy(self)
        other.depth, other.opposite = self.opposite, self.depth
        return other

    def _period(self) -> Any:
        return 2.0 * (self.depth + self.opposite + 2.0 * self.outside)

    def _sum(self, term: Any, r: Any) -> Any:
        """Sum a term `f(r, z, sigma_tr)`, odd in z, over real images less virtual ones, without `strength`."""
        period, real, virtual = self._period(), self.depth, self.depth + 2.0 * self.outside
        falloff = self.sigma_tr
        total = term(r, real, falloff) + term(r, virtual, falloff)
        for i in range(1, _PAIRS + 1):
            away = i * period
            total = total - (term(r, away - real, falloff) - term(r, away + real, falloff))
            total = total - (term(r, away - virtual, falloff) - term(r, away + virtual, falloff))
        # each further pair is nearly the term's slope times the distance within the pair: their sum is an integral,
        # by the midpoint rule and its first correction, with the second derivative from differences
        end = (_PAIRS + 0.5) * period
        last = term(r, end, falloff)
        bend = term(r, end + 0.5 * period, falloff) - 2.0 * last + term(r, end - 0.5 * period, falloff)
        for depth in (real, virtual):
            share = 2.0 * depth / period
            total = total - share * (last - (1.0 - share * share) * (1.0 / 6.0) * bend)
        return total

    def reach(self) -> Any:
        """Length within which nearly all leaves: as for the dipole, or some thicknesses."""
        image = self.mfp_prime + 2.0 * self.outside
        return 1.0 / (0.02 / image + 0.25 * self.sigma_tr + 0.15 / self._period())

    def eval(self, r: Any) -> Any:
        """R(r) - or T(r) of the profile `transmitted` - per area, equations 1 to 3 of Donner and Jensen (2005)."""
        value = self.strength / (4.0 * math.pi) * self._sum(flux, r)
        return plain(namespace(value).maximum(value, 0.0))

    def albedo(self) -> Any:
        """Share that leaves through this face; both faces' add up to what scatters if nothing is absorbed."""
        return plain(0.5 * self.strength * self._sum(flux_beyond, 0.0))

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo that leaves within `r`."""
        beyond, whole = self._sum(flux_beyond, r), self._sum(flux_beyond, 0.0)
        xp = namespace(beyond, whole)
        return plain(xp.minimum(xp.maximum(1.0 - beyond / xp.maximum(whole, 1e-30), 0.0), 1.0))


def _mean_depth(thickness: Any) -> Any:
    """Mean depth of the first event in a slab, in mean free paths: `1 - t e^(-t) / (1 - e^(-t))`."""
    xp = namespace(thickness)
    small = thickness < 0.1
    safe = xp.select(small, 1.0, thickness)
    closed = 1.0 - xp.exp(-safe) / decayed(safe)
    return xp.select(small, thickness * (0.5 - thickness * (1.0 / 12.0)), closed)


def make(sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0, thickness: Any = math.inf) -> Multipole:
    """Build the profile of a slab's lit side; without a thickness, the standard dipole."""
    return Multipole(sigma_a, sigma_s_prime, boundary_factor(eta), thickness)


MODEL = Model(
    name="multipole",
    title="Multipole",
    source="Donner, Jensen (2005): Light diffusion in multi-layered translucent materials",
    terms="single+multiple",
    make=make,
)
