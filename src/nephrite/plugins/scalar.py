"""Stand-ins for the plugins in Mitsuba's scalar variants: they say what to do instead of rendering."""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from nephrite.errors import VariantError


def refuse(_: Any) -> Any:
    """Raise `VariantError`."""
    raise VariantError(
        f"Nephrite's plugins do not run in {mi.variant()}: set a vectorised variant such as llvm_ad_rgb or "
        "cuda_ad_rgb before loading the scene."
    )


def register() -> None:
    """Register the stand-ins under the plugins' names."""
    mi.register_bsdf("translucent", refuse)
    mi.register_integrator("translucent_path", refuse)
