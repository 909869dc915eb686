"""From what an artist sees to what a medium is: the maps that are fast, known and approximate.

`color` has the exact one. Here are three others from a surface's diffuse colour to the (reduced) albedo:

- `dipole_albedo`: inverts the total diffuse reflectance of the standard dipole *with* its interface,
  numerically; its round trip through `Medium.diffuse_reflectance` is exact. As the dipole, it is off for dark media.
- `chiang_albedo`, `van_de_hulst_albedo`: the maps that production renderers ship. They hold for an
  index-matched surface only; under a dielectric of 1.3-1.5 they are 20 to 190 % off.

All three are elementwise on floats, NumPy arrays or Dr.Jit arrays, so that textures can go through them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace, plain
from nephrite.physics.fresnel import boundary_factor, check_eta

if TYPE_CHECKING:
    from nephrite.physics.medium import Medium

__all__ = [
    "MIN_RADIUS",
    "chiang_albedo",
    "chiang_color",
    "diffuse_reflectance",
    "diffuse_reflectance_from_falloff",
    "dipole_albedo",
    "dipole_falloff",
    "from_albedo_and_radius",
    "medium_from_falloff",
    "van_de_hulst_albedo",
    "van_de_hulst_color",
]

MIN_RADIUS = 1e-4
"""Shortest mean free path (mm) of a medium that is made from a colour: below light's wavelength all is diffuse."""

_STEPS = 8  # of Newton's method, which converges from the left; measured in tests/physics/test_inversion.py


def diffuse_reflectance_from_falloff(falloff: Any, boundary: Any) -> Any:
    """Total diffuse reflectance of the dipole by its `falloff` s = sigma_tr / sigma_t' in [0, sqrt 3].

    `(albedo'/2) (1 + e^(-4/3 A s)) e^(-s)` with `albedo' = 1 - s^2/3` and `boundary` the dipole's A: Jensen
    et al. (2001), section 2.4. s says it all: 0 is no absorption (result 1), sqrt 3 is no scattering (result
    0).
    """
    xp = namespace(falloff, boundary)
    albedo = xp.maximum(1.0 - falloff * falloff * (1.0 / 3.0), 0.0)
    return plain(0.5 * albedo * (1.0 + xp.exp((-4.0 / 3.0) * boundary * falloff)) * xp.exp(-falloff))


def diffuse_reflectance(albedo_prime: Any, eta: float) -> Any:
    """Total diffuse reflectance of the dipole with interface, in [0, 1], for a reduced albedo in [0, 1]."""
    xp = namespace(albedo_prime)
    falloff = xp.sqrt(3.0 * xp.maximum(1.0 - albedo_prime, 0.0))
    return diffuse_reflectance_from_falloff(falloff, boundary_factor(eta))


def dipole_falloff(reflectance: Any, eta: float) -> Any:
    """Invert `diffuse_reflectance_from_falloff`: s in [0, sqrt 3] for a reflectance in [0, 1].

    Values outside [0, 1] are clamped. Keeps its digits near white, where `1 - albedo' = s^2 / 3` is tiny.
    """
    xp = namespace(reflectance)
    boundary = boundary_factor(eta)
    target = xp.minimum(xp.maximum(reflectance, 0.0), 1.0)
    end = math.sqrt(3.0)
    falloff = target * 0.0
    for _ in range(_STEPS):
        # Rd = a b with a = (1 - s^2/3) e^-s / 2 and b = 1 + e^(-4/3 A s): convex and falling on [0, sqrt 3]
        decay = xp.exp(-falloff)
        mirrored = xp.exp((-4.0 / 3.0) * boundary * falloff)
        albedo = 1.0 - falloff * falloff * (1.0 / 3.0)
        value = 0.5 * albedo * decay * (1.0 + mirrored)
        slope = (
            -0.5
            * decay
            * (
                ((2.0 / 3.0) * falloff + albedo) * (1.0 + mirrored)
                + albedo * (4.0 / 3.0) * boundary * mirrored
            )
        )
        falloff = xp.minimum(xp.maximum(falloff - (value - target) / slope, 0.0), end)
    falloff = xp.select(target <= 0.0, end, falloff)
    return plain(falloff)


def dipole_albedo(reflectance: Any, eta: float) -> Any:
    """Reduced albedo in [0, 1] whose dipole has this total diffuse reflectance under an interface `eta`."""
    falloff = dipole_falloff(reflectance, eta)
    return plain(namespace(falloff).maximum(1.0 - falloff * falloff * (1.0 / 3.0), 0.0))


def chiang_albedo(color: Any) -> Any:
    """Albedo `1 - exp(-5.09406 A + 2.61188 A^2 - 4.31805 A^3)`, index-matched: Chiang et al. (2016)."""
    xp = namespace(color)
    return plain(1.0 - xp.exp(color * (-5.09406 + color * (2.61188 - color * 4.31805))))


def chiang_color(albedo: Any) -> Any:
    """Invert `chiang_albedo` by bisection: the colour in [0, 1] for an albedo in [0, .9989]."""
    xp = namespace(albedo)
    low, high = albedo * 0.0, albedo * 0.0 + 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        below = chiang_albedo(middle) < albedo
        low, high = xp.select(below, middle, low), xp.select(below, high, middle)
    return plain(0.5 * (low + high))


def van_de_hulst_albedo(color: Any, g: Any = 0.0) -> Any:
    """Albedo of the medium (not reduced) for a diffuse colour in [0, 1], index-matched: van de Hulst (1980).

    `s = 4.09712 + 4.20863 C - sqrt(9.59217 + 41.6808 C + 17.7126 C^2)`, `albedo = (1 - s^2) / (1 - g s^2)`,
    as in Kulla and Conty (2017) and OpenPBR.
    """
    xp = namespace(color, g)
    s = 4.09712 + 4.20863 * color - xp.sqrt(9.59217 + color * (41.6808 + 17.7126 * color))
    squared = xp.minimum(s * s, 1.0)
    return plain((1.0 - squared) / (1.0 - g * squared))


def van_de_hulst_color(albedo: Any, g: Any = 0.0) -> Any:
    """Diffuse colour of an index-matched half-space: `(1 - s)(1 - .139 s) / (1 + 1.17 s)`.

    `s = sqrt((1 - albedo) / (1 - g albedo))`; van de Hulst (1980). The map that `van_de_hulst_albedo`
    inverts.
    """
    xp = namespace(albedo, g)
    s = xp.sqrt(xp.maximum((1.0 - albedo) / (1.0 - g * albedo), 0.0))
    return plain((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s))


def from_albedo_and_radius(albedo: Any, radius: Any, g: float = 0.0, eta: float = 1.3) -> Medium:
    """Build the medium that has this diffuse colour and this mean free path.

    `albedo`: total diffuse reflectance of the dipole with interface, one number or RGB in [0, 1]; 1 means no
    absorption, 0 no scattering. `radius`: reduced mean free path `1 / sigma_t'` in mm, one number or RGB, >=
    0; anything below `MIN_RADIUS`, 0 included, becomes `MIN_RADIUS`, which looks like a diffuse surface. `g`,
    `eta` as in `Medium`. Raises `ParameterError` for anything outside these ranges.
    """
    from nephrite.physics.medium import rgb

    eta = check_eta(eta)
    colors = rgb(albedo, "albedo")
    if max(colors) > 1.0:
        raise ParameterError(
            f"albedo is {albedo!r}: no surface reflects more than it receives; each channel lies in [0, 1] "
            "(divide 8 bit colours by 255 and decode sRGB)."
        )
    return medium_from_falloff([dipole_falloff(color, eta) for color in colors], radius, g, eta)


def medium_from_falloff(falloff: Sequence[float], radius: Any, g: float, eta: float) -> Medium:
    """Build the medium with these s = sigma_tr / sigma_t' in [0, sqrt 3], one for each channel.

    `radius`: reduced mean free path `1 / sigma_t'` in mm, one number or RGB, >= 0, at least `MIN_RADIUS` or made so.
    Raises `ParameterError` for an impossible radius, `g` or `eta`.
    """
    from nephrite.physics.medium import Medium, rgb

    absorption, reduced = [], []
    for s, length in zip(falloff, rgb(radius, "radius"), strict=True):
        extinct = 1.0 / max(length, MIN_RADIUS)
        absorbed = s**2 / 3.0 if s < math.sqrt(3.0) else 1.0
        absorption.append(extinct * absorbed)
        reduced.append(extinct * max(1.0 - absorbed, 0.0))
    return Medium.from_reduced(absorption, reduced, g, eta)
