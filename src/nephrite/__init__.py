"""Nephrite: subsurface scattering for Mitsuba 3, from the local approximation to the volumetric truth.

Importing the package makes the BSDF `translucent` and the integrator `translucent_path` known to Mitsuba, in the
variant that is set and in every one set later. It sets no variant itself.
"""

from __future__ import annotations

from nephrite import llvm as _llvm

_llvm.prefer_packaged()

from nephrite import plugins as _plugins  # noqa: E402
from nephrite.errors import (  # noqa: E402
    MeshError,
    MissingDependencyError,
    NephriteError,
    ParameterError,
    VariantError,
)
from nephrite.materials import Material  # noqa: E402
from nephrite.physics.medium import Medium  # noqa: E402

__version__ = "0.1.0"

__all__ = [
    "Material",
    "Medium",
    "MeshError",
    "MissingDependencyError",
    "NephriteError",
    "ParameterError",
    "VariantError",
    "__version__",
]

_plugins.install()
