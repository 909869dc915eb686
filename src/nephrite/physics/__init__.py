"""Pure physics: functions of floats, NumPy or Dr.Jit arrays that never import Mitsuba.

Lengths are millimetres, coefficients 1/mm, `eta` is inside / outside. `fresnel` has reflection and its
moments, `phase` the phase function, `color` the exact map from colours to media and `inversion` those that other
renderers ship; `Medium` holds the coefficients and what they imply.
"""

from __future__ import annotations

from nephrite.physics import color, fresnel, inversion, phase
from nephrite.physics.color import from_color_and_radius
from nephrite.physics.medium import Medium

__all__ = [
    "Medium",
    "color",
    "fresnel",
    "from_color_and_radius",
    "inversion",
    "phase",
]
