"""The colour that a surface shows, and the medium that gives it: exact for a thick flat piece, interface included.

*Surface colour* C: a thick flat piece lies in uniform diffuse light; C is the light that leaves after having been
inside, per light that has entered. 1 means no absorption (under a smooth surface), 0 no scattering. What is reflected
without entering, the highlight, is left out: a render of the piece under light of radiance 1 shows `entering * C` on
average, and the highlight.

A rough surface is Mitsuba's `roughdielectric` (GGX), which loses the light that would meet a second microfacet. Most is
lost from inside, where light meets the surface again and again: no medium under it shows more than `reach`.

A map is computed when first needed, by discrete ordinates for 20 albedos, and kept as
two polynomials. It has no noise. From a colour of .02 on, its error is below .001 of the colour for an index of .7 to 2
and g from -.5 to .99, below .002 at g = -.9, and below .003 up to an index of 2.5. Textures go through it for some
twenty multiplications.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev

from nephrite.errors import ParameterError
from nephrite.physics import color_halfspace, color_interface
from nephrite.physics._arrays import namespace, plain
from nephrite.physics._lift import checked, lift
from nephrite.physics.fresnel import check_eta
from nephrite.physics.inversion import medium_from_falloff
from nephrite.physics.phase import check_g

if TYPE_CHECKING:
    from nephrite.physics.medium import Medium

__all__ = [
    "ColorMap",
    "albedo_to_color",
    "color_map",
    "color_to_albedo",
    "from_color_and_radius",
]

_DARKEST = math.sqrt(3.0)  # falloff of a medium that does not scatter
_STREAMS = 24
_ALBEDOS = 20
_DEGREE = 16


@dataclass(frozen=True)
class ColorMap:
    """Surface colour <-> medium, for one index `eta` (inside / outside), mean cosine `g` and GGX roughness `alpha`.

    `reach`: the lightest colour, of a medium without absorption; 1 if smooth. `entering`: share of diffuse light on the
    outside that enters. All methods are elementwise on floats, NumPy or Dr.Jit arrays of any shape, monotone and
    differentiable; both ends are exact. The medium is described by its falloff s = sqrt(3 (1 - albedo')) in
    [0, sqrt 3], in which colours are smooth, or by its reduced albedo albedo' = 1 - s^2 / 3, which loses digits near
    white.
    """

    eta: float
    g: float
    alpha: float
    reach: float
    entering: float
    middle: float  # colour over reach at s = 1
    lightness: tuple[float, ...]  # Chebyshev series of log(color / (reach albedo')) / s over s
    darkness: tuple[float, ...]  # Chebyshev series of (s / (sqrt 3 (1 - x)) - 1) / x over x, the warped color

    def falloff(self, color: Any) -> Any:
        """Return s for a surface colour; 0 for one above `reach`, sqrt 3 for one below 0."""
        xp = namespace(color)
        share = xp.minimum(xp.maximum(color * (1.0 / self.reach), 0.0), 1.0)
        warped = share * (1.0 + self.middle) / (share + self.middle)
        return plain(_DARKEST * (1.0 - warped) * (1.0 + warped * _series(self.darkness, 2.0 * warped - 1.0)))

    def albedo(self, color: Any) -> Any:
        """Return the reduced albedo in [0, 1] for a surface colour; clamped as in `falloff`."""
        falloff = self.falloff(color)
        return plain(namespace(falloff).maximum(1.0 - falloff * falloff * (1.0 / 3.0), 0.0))

    def color_of_falloff(self, falloff: Any) -> Any:
        """Return the surface colour, in [0, `reach`], for s in [0, sqrt 3]."""
        return self._color(namespace(falloff).maximum(1.0 - falloff * falloff * (1.0 / 3.0), 0.0), falloff)

    def color(self, albedo_prime: Any) -> Any:
        """Return the surface colour, in [0, `reach`], for a reduced albedo in [0, 1]."""
        xp = namespace(albedo_prime)
        return self._color(albedo_prime, xp.sqrt(3.0 * xp.maximum(1.0 - albedo_prime, 0.0)))

    def of_coefficients(self, sigma_a: Any, sigma_s: Any) -> Any:
        """Return the surface colour for absorption and scattering (*not* reduced), in any common unit."""
        xp = namespace(sigma_a, sigma_s)
        extinction = xp.maximum(sigma_a + sigma_s * (1.0 - self.g), 1e-20)
        absorbed = xp.select(sigma_s > 0.0, xp.minimum(sigma_a / extinction, 1.0), 1.0)
        return self._color(1.0 - absorbed, xp.sqrt(3.0 * absorbed))

    def _color(self, albedo_prime: Any, falloff: Any) -> Any:
        """Return the surface colour for both at once, each with the digits that the other has lost."""
        series = _series(self.lightness, falloff * (2.0 / _DARKEST) - 1.0)
        return plain(self.reach * albedo_prime * namespace(falloff).exp(falloff * series))


def color_to_albedo(color: Any, eta: float, g: float = 0.0, alpha: float = 0.0) -> Any:
    """Return the *reduced* albedo in [0, 1] of the medium that shows this surface colour (see the module's text).

    Floats, NumPy or Dr.Jit arrays. Colours outside [0, reach] are clamped; `reach` is 1 unless the surface is rough.
    Raises `ParameterError` for an `eta`, `g` or `alpha` that cannot be.
    """
    return color_map(eta, g, alpha).albedo(color)


def albedo_to_color(albedo_prime: Any, eta: float, g: float = 0.0, alpha: float = 0.0) -> Any:
    """Return the surface colour for a *reduced* albedo in [0, 1]; the inverse of `color_to_albedo`."""
    return color_map(eta, g, alpha).color(albedo_prime)


def from_color_and_radius(
    color: Any, radius: Any, g: float = 0.0, eta: float = 1.3, alpha: float = 0.0, name: str = "color"
) -> Medium:
    """Build the medium whose thick flat piece shows this colour, with this mean free path.

    `color`: surface colour (see the module's text), one number or RGB in [0, 1]; 1 means no absorption, 0 no
    scattering. `radius`: reduced mean free path `1 / sigma_t'` in mm, one number or RGB, >= 0; anything below
    `MIN_RADIUS`, 0 included, becomes `MIN_RADIUS`, which looks like a diffuse surface. `g`, `eta` as in `Medium`;
    `alpha`: GGX roughness of the surface. `name`: what errors call the colour. Raises `ParameterError` for anything
    outside these ranges, and for a colour lighter than a surface so rough can show.
    """
    from nephrite.physics.medium import rgb

    colors = rgb(color, name)
    if max(colors) > 1.0:
        raise ParameterError(
            f"{name} is {color!r}: no surface reflects more than it receives; each channel lies in [0, 1] "
            "(divide 8 bit colours by 255 and decode sRGB)."
        )
    of = color_map(eta, g, alpha)
    if max(colors) > of.reach:
        raise ParameterError(
            f"{name} is {color!r}, but a surface of index {of.eta:g} and roughness {of.alpha:g} cannot be lighter "
            f"than {of.reach:.3f}: its microfacets lose the rest. Take a darker colour, or a smaller alpha."
        )
    return medium_from_falloff([of.falloff(channel) for channel in colors], radius, of.g, of.eta)


def color_map(eta: Any, g: Any = 0.0, alpha: float = 0.0) -> ColorMap:
    """Return the map for a surface; computed once for each. Raises `ParameterError` for what cannot be.

    Derivatives pass through `eta` and `g` where these are Dr.Jit arrays, of one entry.
    """
    alpha = _check_alpha(alpha)
    return lift(lambda *at: _color_map(*at, alpha), checked(check_eta, eta), checked(check_g, g))


@lru_cache(maxsize=512)
def _color_map(eta: float, g: float, alpha: float) -> ColorMap:
    at = color_halfspace.streams(eta, _STREAMS)
    surface = color_interface.interface(at, eta, alpha)
    nodes = chebyshev.chebpts1(_ALBEDOS)
    falloffs = 0.5 * _DARKEST * (1.0 + nodes)
    colors = np.array([_solve(at, surface, g, 1.0 - s * s / 3.0) for s in falloffs])
    reach = 1.0 if alpha == 0.0 or eta == 1.0 else _solve(at, surface, g, 1.0)
    logarithms = np.log(colors / (reach * (1.0 - falloffs**2 / 3.0))) / falloffs
    lightness = tuple(float(c) for c in chebyshev.chebfit(nodes, logarithms, _DEGREE))
    entering = 2.0 * eta**2 * float(at.weights @ (at.cosines * surface.transmits))
    half = ColorMap(eta, g, alpha, reach, entering, 1.0, lightness, ())
    middle = half.color_of_falloff(1.0) / reach
    return ColorMap(eta, g, alpha, reach, entering, middle, lightness, _inverted(half, middle))


def _solve(
    at: color_halfspace.Streams, surface: color_interface.Interface, g: float, albedo_prime: float
) -> float:
    """Return the surface colour of a medium: light goes down, comes up, and is sent back down by the surface."""
    albedo = albedo_prime / (1.0 - g + g * albedo_prime)
    medium = color_halfspace.reflection(at, g, albedo)
    below = np.eye(len(at.cosines)) - surface.reflects @ medium
    upward = medium @ np.linalg.solve(below, surface.transmits)
    flux = at.weights * at.cosines * surface.transmits
    return float(flux @ upward / (at.weights * at.cosines @ surface.transmits))


def _inverted(of: ColorMap, middle: float) -> tuple[float, ...]:
    """Return the series of `ColorMap.darkness`, by bisection at more nodes than it has terms."""
    nodes = chebyshev.chebpts1(3 * _DEGREE)
    warped = 0.5 * (1.0 + nodes)
    colors = of.reach * warped * middle / (1.0 + middle - warped)
    low, high = np.zeros_like(colors), np.full_like(colors, _DARKEST)
    for _ in range(50):
        between = 0.5 * (low + high)
        lighter = of.color_of_falloff(between) > colors
        low, high = np.where(lighter, between, low), np.where(lighter, high, between)
    values = (0.5 * (low + high) / (_DARKEST * (1.0 - warped)) - 1.0) / warped
    return tuple(float(c) for c in chebyshev.chebfit(nodes, values, _DEGREE))


def _series(coefficients: tuple[float, ...], x: Any) -> Any:
    """Sum a Chebyshev series at x in [-1, 1] (Clenshaw 1955); x of any kind of array."""
    ahead, after = x * 0.0, x * 0.0
    for coefficient in reversed(coefficients[1:]):
        ahead, after = 2.0 * x * ahead - after + coefficient, ahead
    return x * ahead - after + coefficients[0]


def _check_alpha(alpha: float) -> float:
    try:
        value = float(alpha)
    except (TypeError, ValueError):
        value = math.nan
    if not 0.0 <= value <= 1.0:
        raise ParameterError(
            f"alpha is {alpha!r}, but a surface's roughness lies in [0, 1]: 0 is smooth, .5 is matt."
        )
    return value
