"""Nephrite: subsurface scattering for Mitsuba 3."""

from __future__ import annotations

from nephrite import llvm as _llvm

_llvm.prefer_packaged()

__version__ = "0.1.0"
