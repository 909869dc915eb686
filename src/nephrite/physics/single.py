"""Single scattering in a half-space: how much of the light that has entered leaves after one event."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from nephrite.physics import fresnel, phase

__all__ = ["single_scattering_share"]

_NODES = 48


@lru_cache(maxsize=256)
def single_scattering_share(g: float, eta: float) -> float:
    """Share h of diffusely incident, refracted light that leaves a half-space after one event, per albedo.

    The light that leaves after exactly one event is `albedo * h`: the integral over depth of Chandrasekhar's (1960,
    section 14) single scattering, `mu / (mu + mu_i)`, weighted by the Henyey-Greenstein phase function and by what
    the interface lets out. Of the rest, `1 - h` per albedo, all scatters again. Gauss-Legendre quadrature; cached.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    unit, unit_weights = 0.5 * (nodes + 1.0), 0.5 * weights
    outside = unit
    entering = unit_weights * outside * (1.0 - fresnel.reflectance(outside, eta))
    entering = entering / entering.sum()
    mu_i = np.asarray(fresnel.refracted_cosine(outside, eta))[:, None, None]
    critical = math.sqrt(max(1.0 - 1.0 / eta**2, 0.0))
    mu = (critical + (1.0 - critical) * unit)[None, :, None]
    mu_weights = (1.0 - critical) * unit_weights
    azimuth = (math.pi * unit)[None, None, :]
    cosine = -mu_i * mu + np.sqrt(1.0 - mu_i**2) * np.sqrt(1.0 - mu**2) * np.cos(azimuth)
    scattered = 2.0 * math.pi * np.tensordot(phase.eval(cosine, g), unit_weights, axes=([2], [0]))
    leaving = (1.0 - fresnel.reflectance(-mu[..., 0], eta)) * mu[..., 0] / (mu[..., 0] + mu_i[..., 0])
    return float(entering @ (scattered * leaving) @ mu_weights)
