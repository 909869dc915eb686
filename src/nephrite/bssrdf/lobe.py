"""The lobe in which multiply scattered light leaves a smooth surface, and the memory of direction in it.

A walk that arrives at the surface leaves in one direction only, so no light can be connected to it. Averaged
over walks the light that leaves is spread over the whole hemisphere: `ExitLobe.pdf` is that lobe if the
radiance inside is uniform. It is not quite: light that leaves has a memory of where it came from, without
which a side-lit ball is too dark. `kernel` brings it back. The outgoing radiance,
relative to the plain lobe, is expanded in functions that are orthonormal under the lobe,

    1,   x sqrt(2/m2),   y sqrt(2/m2),   (r^2 - m2)/s,   (x^2 - y^2) sqrt(2/m4),   2xy sqrt(2/m4),

of the tangential components (x, y) of the direction, r^2 = x^2 + y^2, m2 = <r^2>, m4 = <r^4>,
s^2 = m4 - m2^2. The coefficients of such an expansion are mean values over the walks, so one walk, leaving in
direction v, estimates the radiance in direction w by `pdf(w) * sum_j phi_j(v) phi_j(w)`: an orthogonal series
estimate of a density (Cencov 1962). It is exact in the mean for every radiance that is such a polynomial, makes
and loses no energy, and needs no knowledge of the walk but its last direction.

One direction is a noisy estimate of how long walks leave, which on average is known: all steps of a random walk have
the same share in how far it has come. If that is r, on a way of length s, its last direction has the mean r / (2 s).
(The last of n steps, of exponential lengths around l, has the covariance <l> with it, which itself has the variance
n <l^2> = 2 n l^2 in units of a direction's.) `usual` is what that is outside; long walks use it in place of the
direction that they have, and so keep the linear part of their lobe without its noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import drjit as dr
import numpy as np

from nephrite.physics import fresnel

__all__ = ["LINEAR_MEMORY", "QUADRATIC_MEMORY", "ExitLobe", "exit_lobe"]

LINEAR_MEMORY = 8.0
"""Reduced order of scattering over which the usual direction takes the place of the walk's own in the linear part."""

QUADRATIC_MEMORY = 6.0
"""Reduced order of scattering over which the quadratic part of the kernel fades."""


@dataclass(frozen=True)
class ExitLobe:
    """The exit lobe of a smooth interface with relative index `eta` (inside / outside).

    `normalization`: the c of `(1 - F) cos / (c pi)`; `m2`, `m4`: mean of r^2 and r^4 under the lobe, r the sine
    of the angle to the normal.
    """

    eta: float
    normalization: float
    m2: float
    m4: float


@lru_cache(maxsize=256)
def exit_lobe(eta: float) -> ExitLobe:
    """Return the lobe for `eta` with its moments, by Gauss-Legendre quadrature in the squared sine."""
    nodes, weights = np.polynomial.legendre.leggauss(256)
    cosine, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    density = 2.0 * weights * cosine * (1.0 - fresnel.reflectance(cosine, eta))
    total = float(density.sum())
    squared = 1.0 - cosine * cosine
    m2 = float((density * squared).sum()) / total
    m4 = float((density * squared * squared).sum()) / total
    return ExitLobe(eta, total, m2, m4)


def pdf(cos_theta: Any, reflectance: Any, normalization: Any) -> Any:
    """Density of the plain lobe per solid angle (1/sr): `(1 - F) cos / (c pi)`, 0 below the horizon.

    Jensen et al. (2001), equation 5, normalised; its integral over the outer hemisphere is 1. `reflectance` is the
    Fresnel term F of `cos_theta`.
    """
    return dr.select(cos_theta > 0, (1.0 - reflectance) * cos_theta / (math.pi * normalization), 0.0)


def usual(drift: Any, eta: Any, m2: Any) -> Any:
    """Return the mean tangential direction in which walks leave that have come by `drift` times their own length.

    The radiance inside is in proportion to `1 + 3 u.w`, u = drift / 2; a tangential component is eta times as large
    outside, where the mean of its square is m2 / 2. What is not tangential in `drift` is void.
    """
    return drift * (0.75 * m2 / eta)


def kernel(
    v: Any, w: Any, n: Any, m2: Any, m4: Any, linear: Any = 1.0, quadratic: Any = 1.0, usually: Any = None
) -> Any:
    """Radiance in direction `w`, relative to the plain lobe, as one walk leaving in direction `v` sees it.

    `v`, `w`: unit directions outside; `n`: outward normal; `m2`, `m4`: moments of the lobe; `linear`,
    `quadratic` in [0, 1] weigh the two groups of terms; `usually`: the direction that takes the place of `v` in the
    first by the rest of the weight (see `usual`). May be negative; its mean over `w` under the lobe is 1 for every `v`,
    and so is its mean over `v`, with nothing in its place.
    """
    cos_v, cos_w = dr.dot(v, n), dr.dot(w, n)
    inner = dr.dot(v, w) - cos_v * cos_w
    r2_v, r2_w = 1.0 - cos_v * cos_v, 1.0 - cos_w * cos_w
    known = linear * inner
    if usually is not None:
        known += (1.0 - linear) * (dr.dot(usually, w) - dr.dot(usually, n) * cos_w)
    first = 2.0 * known / m2
    radial = (r2_v - m2) * (r2_w - m2) / (m4 - m2 * m2)
    twofold = 2.0 * (2.0 * inner * inner - r2_v * r2_w) / m4
    return 1.0 + first + quadratic * (radial + twofold)


def memory(order: Any, g: Any) -> tuple[Any, Any]:
    """Weights (linear, quadratic) of the kernel's terms after `order` events in a medium of mean cosine `g`.

    Deep light has forgotten its direction: leaving the quadratic terms out there costs a little accuracy and saves the
    noise that they bring, and the linear ones are known on average (see `usual`). The reduced order `order (1 - g)`
    counts the events that matter.
    """
    reduced = order * (1.0 - g)
    return dr.exp(-reduced / LINEAR_MEMORY), dr.exp(-reduced / QUADRATIC_MEMORY)
