"""Colours and media: the maps that production renderers ship, and the medium for what a map has found.

`chiang_albedo` and `van_de_hulst_albedo` hold for an index-matched surface only; `nephrite.physics.color` has the exact
map. Under an index of 1.3 to 1.5, colours of .1 to .9 come out 8 to 68 % too dark by them: `benchmarks/color.py`
prints by how much. Both are elementwise on floats, NumPy arrays or Dr.Jit arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nephrite.physics._arrays import namespace, plain

if TYPE_CHECKING:
    from nephrite.physics.medium import Medium

__all__ = [
    "MIN_RADIUS",
    "chiang_albedo",
    "medium_from_falloff",
    "van_de_hulst_albedo",
]

MIN_RADIUS = 1e-4
"""Shortest mean free path (mm) of a medium that is made from a colour: below light's wavelength all is diffuse."""


def chiang_albedo(color: Any) -> Any:
    """Albedo `1 - exp(-5.09406 A + 2.61188 A^2 - 4.31805 A^3)`, index-matched: Chiang et al. (2016)."""
    xp = namespace(color)
    return plain(1.0 - xp.exp(color * (-5.09406 + color * (2.61188 - color * 4.31805))))


def van_de_hulst_albedo(color: Any, g: Any = 0.0) -> Any:
    """Albedo of the medium (not reduced) for a diffuse colour in [0, 1], index-matched: van de Hulst (1980).

    `s = 4.09712 + 4.20863 C - sqrt(9.59217 + 41.6808 C + 17.7126 C^2)`, `albedo = (1 - s^2) / (1 - g s^2)`,
    as in Kulla and Conty (2017) and OpenPBR.
    """
    xp = namespace(color, g)
    s = 4.09712 + 4.20863 * color - xp.sqrt(9.59217 + color * (41.6808 + 17.7126 * color))
    squared = xp.minimum(s * s, 1.0)
    return plain((1.0 - squared) / (1.0 - g * squared))


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
