"""The contract of a radial diffusion profile, and what follows from `eval` alone by quadrature.

A profile R(r) is the light that leaves a flat half-space at the distance r from where it entered, per area
(1/mm^2) and per light that entered: 2 pi r is *not* included. Every profile has

- `eval(r)`     R(r), 1/mm^2, >= 0;
- `albedo()`    the integral of 2 pi r R(r) over all r: what leaves in all, in [0, 1] where the model keeps energy;
- `cdf(r)`      the part of `albedo()` that leaves within r, divided by it: in [0, 1];
- `sample(u)`   the r with `cdf(r) = u` in distribution: follows `pdf`;
- `reach()`     a length within which nearly all leaves;
- `pdf(r)`      density of `sample` per *length* (1/mm): `2 pi r R(r) / albedo()`.

Parameters and arguments are floats, NumPy or Dr.Jit arrays that broadcast against each other; lengths are in the
unit that the coefficients have. With Dr.Jit arrays everything is differentiable in the arguments and the parameters,
`sample` too, but for the choice between its parts that some models make by a second number. Indices of refraction and
g belong to a material, not to a point: each is a number, or for derivatives a Dr.Jit array of one entry.

A model must define `eval` and `reach`; what it has in closed form, it overrides. The rest comes from
`nephrite.profiles.quadrature`, exact to 3e-5 of the albedo.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

from nephrite.physics._arrays import namespace, plain
from nephrite.profiles import quadrature

__all__ = ["Make", "Model", "RadialProfile"]


class RadialProfile(ABC):
    """A radial profile; see the module's text for measures and laws."""

    parts = 1
    """Number of terms that `eval` adds up, for `_part`."""

    @abstractmethod
    def eval(self, r: Any) -> Any:
        """R(r), per area; finite at r = 0 too, where some models diverge."""

    @abstractmethod
    def reach(self) -> Any:
        """Length within which nearly all of the albedo leaves, cheap to compute: bounds searches."""

    def _part(self, r: Any, k: Any) -> Any:
        """Term k of R(r): a model that is an integral itself gives its nodes, to be summed with those over r."""
        return self.eval(r)

    def albedo(self) -> Any:
        """Integral of 2 pi r R(r)."""
        return plain(quadrature.total(self._part, self.parts, self.reach()))

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo within r."""
        return plain(quadrature.within(self._part, self.parts, self.reach(), r))

    def pdf(self, r: Any) -> Any:
        """Density of `sample` per length: 2 pi r R(r) / albedo; 0 where nothing leaves."""
        albedo = self.albedo()
        value = 2.0 * math.pi * r * self.eval(r)
        return plain(value / namespace(albedo, value).maximum(albedo, 1e-30))

    def sample(self, u: Any, v: Any = 0.5) -> Any:
        """Radius for uniform numbers in [0, 1): `u` suffices here; models that are sums choose their part by `v`."""
        r = quadrature.invert(self._part, self.parts, self.reach(), u)
        return plain(self._differentiable(r, u))

    def _differentiable(self, r: Any, share: Any) -> Any:
        """Return r, the root of `cdf(r) = share` that a search has found, with the derivatives that it has.

        A search has none; one step of Newton's method from its end has.
        """
        xp = namespace(r, share)
        if not hasattr(xp, "replace_grad"):
            return r
        r = xp.detach(r)
        with xp.suspend_grad():
            slope = xp.maximum(self.pdf(r), 1e-30)
        return xp.replace_grad(r, r + (share - self.cdf(r)) / slope)


class Make(Protocol):
    """How a profile comes from a medium under a smooth interface."""

    def __call__(self, sigma_a: Any, sigma_s_prime: Any, eta: Any, g: Any = 0.0) -> RadialProfile:
        """Build the profile for absorption and *reduced* scattering (1/length), eta = inside / outside."""
        ...


@dataclass(frozen=True)
class Model:
    """An entry of `nephrite.profiles.models.MODELS`.

    `terms`: "multiple" if the profile stands for light that has scattered at least twice, so that single scattering is
    to be added; "single+multiple" if it stands for all scattered light. `finite`: whether the integrator fits its light
    to the object (`bssrdf.finite`, `plugins.balance`); it leaves models of the literature as they are.
    """

    name: str
    title: str
    source: str
    terms: str
    make: Make
    finite: bool = False
