"""The Mitsuba plugins: the only code of this package that is bound to a variant.

`install()` makes Mitsuba call `_on_variant` now, if a variant is set, and on every switch of variant from then on.
The plugins' modules hold classes that derive from the variant's own, so each switch builds them anew.
"""

from __future__ import annotations

import importlib
import sys

from nephrite import llvm

_PLUGINS = ("translucent", "translucent_path")
_installed = False


def install() -> None:
    """Register `translucent` and `translucent_path` in the present variant, and in each one set later."""
    global _installed
    import mitsuba as mi

    if _installed:
        return
    _installed = True
    mi.detail.add_variant_callback(_on_variant)
    if mi.variant() is not None:
        _on_variant(None, mi.variant())


def _on_variant(old: str | None, new: str | None) -> None:
    if new is None or old == new:
        return
    if new.startswith("scalar"):
        from nephrite.plugins import scalar

        scalar.register()
        return
    if new.startswith("llvm"):
        import drjit as dr

        llvm.check_loaded(dr.detail.llvm_version())
    for name in _PLUGINS:
        full = f"{__name__}.{name}"
        module = sys.modules.get(full)
        module = importlib.import_module(full) if module is None else importlib.reload(module)
        module.register()
