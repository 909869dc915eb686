"""Single scattering in a half-space or a slab: how much of the light that has entered leaves after one event."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from nephrite.physics import fresnel, phase

__all__ = ["deep_share", "single_scattering_share", "slab_shares"]

_NODES = 48
_THICKEST = 1e4  # mean free paths: stands for infinity


@lru_cache(maxsize=256)
def single_scattering_share(g: float, eta: float) -> float:
    """Share h of diffusely incident, refracted light that leaves a half-space after one event, per albedo.

    The light that leaves after exactly one event is `albedo * h`: the integral over depth of Chandrasekhar's (1960,
    section 14) single scattering, `mu / (mu + mu_i)`, weighted by the Henyey-Greenstein phase function and by what
    the interface lets out. Of the rest, `1 - h` per albedo, all scatters again. Gauss-Legendre quadrature; cached.
    """
    return slab_shares(g, eta, math.inf)[0]


def slab_shares(g: float, eta: float, thickness: float) -> tuple[float, float]:
    """Return what leaves a slab through the face of entry, and through the other one, after one event, per albedo.

    Shares of the diffusely incident, refracted light that scatters in the slab, of `thickness` > 0 in mean free paths.
    Paths on which a face reflects light back into the slab are left out.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    unit, unit_weights = 0.5 * (nodes + 1.0), 0.5 * weights
    outside = unit
    entering = unit_weights * outside * (1.0 - fresnel.reflectance(outside, eta))
    entering = entering / entering.sum()
    mu_i = np.asarray(fresnel.refracted_cosine(outside, eta))
    deep = min(thickness, _THICKEST)
    scatters = float(entering @ -np.expm1(-deep / mu_i))
    back, across = _leaving(mu_i, g, eta, deep)
    return float(entering @ back) / scatters, float(entering @ across) / scatters


def deep_share(cosine: NDArray, g: float, eta: float) -> NDArray:
    """Share of light that a half-space keeps after one event, `1 - h` per albedo, over its mean for diffuse light.

    `cosine`: of the angle outside, in (0, 1], between the light and the normal; an array. Steep light goes deeper.
    """
    mu_i = np.asarray(fresnel.refracted_cosine(np.asarray(cosine, dtype=float), eta))
    kept = 1.0 - _leaving(mu_i, g, eta, _THICKEST)[0]
    return kept / (1.0 - single_scattering_share(g, eta))


def _leaving(mu_i: NDArray, g: float, eta: float, deep: float) -> tuple[NDArray, NDArray]:
    """Return what leaves a slab through either face after one event, for light inside at the cosines `mu_i`."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    unit, unit_weights = 0.5 * (nodes + 1.0), 0.5 * weights
    critical = math.sqrt(max(1.0 - 1.0 / eta**2, 0.0))
    mu = (critical + (1.0 - critical) * unit)[None, :]
    mu_weights = (1.0 - critical) * unit_weights * (1.0 - fresnel.reflectance(-mu[0], eta))
    mu_i = mu_i[:, None]
    # over all depths of the event: e^(-depth / mu_i) / mu_i on the way in, and what is left of e^(-path) on the way out
    back = mu / (mu + mu_i) * -np.expm1(-deep * (1.0 / mu + 1.0 / mu_i))
    apart = np.maximum(deep * np.abs(1.0 / mu_i - 1.0 / mu), 1e-12)
    across = deep / mu_i * np.exp(-deep / np.maximum(mu, mu_i)) * -np.expm1(-apart) / apart
    azimuth = (math.pi * unit)[None, None, :]
    sideways = (np.sqrt(1.0 - mu_i**2) * np.sqrt(1.0 - mu**2))[..., None] * np.cos(azimuth)
    rows = []
    for forward, depths in ((-mu_i * mu, back), (mu_i * mu, across)):
        phases = 2.0 * math.pi * phase.eval(forward[..., None] + sideways, g) @ unit_weights
        rows.append((phases * depths) @ mu_weights)
    return rows[0], rows[1]
