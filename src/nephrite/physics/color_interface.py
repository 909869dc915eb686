"""What a surface does to diffuse light from inside, averaged over the azimuth: smooth (Fresnel) or rough (GGX).

The rough one is Mitsuba's `roughdielectric` with `distribution: ggx`: microfacets that light meets once (Walter et al.
2007), with separable shadowing. Light that would meet a second facet is lost, as it is in the render. Under an index of
1.5 and alpha .3 that is 18 % of the diffuse light that meets the surface from inside, again and again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nephrite.physics import fresnel
from nephrite.physics.color_halfspace import Streams, gauss

__all__ = ["Interface", "interface"]

_NODES = 48  # of each of the two random numbers that choose a microfacet


@dataclass(frozen=True)
class Interface:
    """Operators of a surface on light from inside, at the cosines of `Streams`.

    `reflects`: `downward = reflects @ upward`, radiances under the surface, (n, n). `transmits`: share of the light
    that comes from inside along each cosine that is let out, (n,); by reciprocity, uniform light outside makes radiance
    inside in proportion to it.
    """

    reflects: np.ndarray
    transmits: np.ndarray


def interface(at: Streams, eta: float, alpha: float) -> Interface:
    """Return the operators of a surface of relative index `eta` and GGX roughness `alpha`; 0 is smooth.

    A matched surface (`eta` 1) is none, however rough.
    """
    mu = at.cosines
    if alpha == 0.0 or eta == 1.0:
        reflected = np.asarray(fresnel.reflectance(-mu, eta))
        return Interface(np.diag(reflected), 1.0 - reflected)
    rows, transmits = [], []
    for cosine in mu:
        facets = _visible_facets(float(cosine), alpha)
        cosines, amounts = _reflected(facets, eta, alpha)
        rows.append(at.project(cosines, amounts))
        transmits.append(_transmitted(facets, eta, alpha))
    return Interface(np.array(rows), np.array(transmits))


@dataclass(frozen=True)
class _Facets:
    """Microfacets seen along the cosine `cos_i`; (k,) each.

    `tilt`, `cos_m`: cosines of their normals to the surface's and to the light; `share`: of the light that each
    receives, in all 1.
    """

    cos_i: float
    tilt: np.ndarray
    cos_m: np.ndarray
    share: np.ndarray


def _visible_facets(cos_i: float, alpha: float) -> _Facets:
    """Distribute the visible normals of GGX (Heitz 2018) by quadrature; by mirror symmetry, over half the azimuths.

    Normals are the half vectors of the stretched light and a uniform spherical cap (Dupuy and Benyoub 2023).
    """
    sin_i = math.sqrt(1.0 - cos_i * cos_i)
    length = math.hypot(alpha * sin_i, cos_i)
    x, z = alpha * sin_i / length, cos_i / length
    nodes, weights = gauss(_NODES)
    azimuth = math.pi * (np.arange(_NODES)[:, None] + 0.5) / _NODES
    height = nodes[None, :] * (1.0 + z) - z
    radius = np.sqrt(np.maximum(1.0 - height * height, 0.0))
    slope_x, slope_y = alpha * (radius * np.cos(azimuth) + x), alpha * radius * np.sin(azimuth)
    length = np.sqrt(slope_x**2 + slope_y**2 + (height + z) ** 2)
    cos_m = np.clip((sin_i * slope_x + cos_i * (height + z)) / length, 0.0, 1.0)
    share = np.broadcast_to(weights[None, :] / _NODES, cos_m.shape)
    return _Facets(cos_i, ((height + z) / length).ravel(), cos_m.ravel(), share.ravel())


def _reflected(facets: _Facets, eta: float, alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosines along which facets reflect light from inside, back inside, and how much; (k,) each."""
    cosine = 2.0 * facets.cos_m * facets.tilt - facets.cos_i
    back = cosine > 0.0
    amount = facets.share * fresnel.reflectance(-facets.cos_m, eta) * _unmasked(cosine, alpha)
    return cosine[back], amount[back]


def _transmitted(facets: _Facets, eta: float, alpha: float) -> float:
    """Return the share of the light from inside that leaves."""
    through = np.asarray(fresnel.refracted_cosine(facets.cos_m, 1.0 / eta))
    # the outward component of the refracted direction; light that a facet refracts back inside is lost
    cosine = through * facets.tilt - eta * (facets.cos_m * facets.tilt - facets.cos_i)
    amount = facets.share * (1.0 - fresnel.reflectance(-facets.cos_m, eta)) * _unmasked(cosine, alpha)
    return float(amount[cosine > 0.0].sum())


def _unmasked(cosine: np.ndarray, alpha: float) -> np.ndarray:
    """Smith's masking G1 of GGX: the share of the facets that is seen along a cosine above 0."""
    squared = np.maximum(cosine * cosine, 1e-30)
    return 2.0 / (1.0 + np.sqrt(1.0 + alpha * alpha * (1.0 - np.minimum(squared, 1.0)) / squared))
