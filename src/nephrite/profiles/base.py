"""The contract of a radial diffusion profile.

A profile R(r) is the light that leaves a flat half-space at the distance r from where it entered, per area
(1/mm^2) and per light that entered: 2 pi r is *not* included. Every profile has

- `eval(r)`     R(r), 1/mm^2, >= 0;
- `albedo()`    the integral of 2 pi r R(r) over all r: what leaves in all, in [0, 1] where the model keeps energy;
- `cdf(r)`      the part of `albedo()` that leaves within r, divided by it: in [0, 1], exact;
- `sample(u)`   the r with `cdf(r) = u` in distribution: follows `pdf`;
- `reach()`   a length within which nearly all leaves;
- `pdf(r)`      density of `sample` per *length* (1/mm): `2 pi r R(r) / albedo()`.

Parameters and arguments are floats, NumPy or Dr.Jit arrays that broadcast against each other; lengths are in the
unit that the coefficients have.
"""

from __future__ import annotations

from typing import Any, Protocol

__all__ = ["RadialProfile"]


class RadialProfile(Protocol):
    """What `nephrite.bssrdf` needs of a profile; see the module's text for measures and laws."""

    def eval(self, r: Any) -> Any:
        """R(r), per area."""
        ...

    def albedo(self) -> Any:
        """Integral of 2 pi r R(r)."""
        ...

    def cdf(self, r: Any) -> Any:
        """Fraction of the albedo within r."""
        ...

    def sample(self, u: Any, v: Any, r_max: Any = None) -> Any:
        """Radius for two uniform numbers; with `r_max`, one within it, of the density `pdf(r) / cdf(r_max)`."""
        ...

    def reach(self) -> Any:
        """Length within which nearly all of the albedo leaves, cheap to compute: bounds searches."""
        ...

    def pdf(self, r: Any) -> Any:
        """Density of `sample` per length."""
        ...
