"""Radial diffusion profiles: one model a file, one contract (`nephrite.profiles.base`), by name in `models`."""

from __future__ import annotations

from nephrite.profiles.base import Model, RadialProfile
from nephrite.profiles.dipole import StandardDipole
from nephrite.profiles.models import MODELS, find

__all__ = ["MODELS", "Model", "RadialProfile", "StandardDipole", "find"]
