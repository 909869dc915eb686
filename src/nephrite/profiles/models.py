"""The radial models by name: what the integrator's `model`, the command line and the tests go over.

Each module listed here describes itself in its `MODEL`. The directional dipole is no radial profile and has a contract
of its own (`nephrite.profiles.directional`); a measured one comes from a file (`nephrite.profiles.measured`).
"""

from __future__ import annotations

from nephrite.errors import unknown_name
from nephrite.profiles import better_dipole, dipole, gaussians, multipole, normalized, photon_beam, tabulated
from nephrite.profiles.base import Model

__all__ = ["MODELS", "Model", "find"]

MODELS: dict[str, Model] = {
    module.MODEL.name: module.MODEL
    for module in (
        dipole,
        better_dipole,
        photon_beam,
        normalized,
        multipole,
        gaussians,
        tabulated,
    )
}
"""Every radial model that is made from coefficients, in the order of the documentation."""


def find(name: str) -> Model:
    """Return the model of this name; `ParameterError` with the nearest one if there is none."""
    if name not in MODELS:
        raise unknown_name("model", name, MODELS)
    return MODELS[name]
