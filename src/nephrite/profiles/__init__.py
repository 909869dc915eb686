"""Radial diffusion profiles: one model a file, one contract (`nephrite.profiles.base`)."""

from __future__ import annotations

from nephrite.profiles.base import RadialProfile
from nephrite.profiles.dipole import StandardDipole

__all__ = ["RadialProfile", "StandardDipole"]
