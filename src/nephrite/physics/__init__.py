"""Pure physics: functions of floats, NumPy or Dr.Jit arrays that never import Mitsuba.

Lengths are millimetres, coefficients 1/mm, `eta` is inside / outside. `fresnel` has reflection and its
moments, `phase` the phase function, `inversion` the maps from colours to media; `Medium` holds the
coefficients and what they imply.
"""

from __future__ import annotations

from nephrite.physics import fresnel, inversion, phase
from nephrite.physics.inversion import from_albedo_and_radius
from nephrite.physics.medium import Medium

__all__ = ["Medium", "fresnel", "from_albedo_and_radius", "inversion", "phase"]
