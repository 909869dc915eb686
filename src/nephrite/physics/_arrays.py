"""Let one formula serve floats, NumPy arrays and Dr.Jit arrays: find the module whose functions fit."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


class _NumPy:
    """NumPy under Dr.Jit's names, as far as this package needs them."""

    sqrt = staticmethod(np.sqrt)
    exp = staticmethod(np.exp)
    log = staticmethod(np.log)
    abs = staticmethod(np.abs)
    maximum = staticmethod(np.maximum)
    minimum = staticmethod(np.minimum)

    @staticmethod
    def select(mask: Any, yes: Any, no: Any) -> Any:
        return np.where(mask, yes, no)

    @staticmethod
    def sincos(angle: Any) -> tuple[Any, Any]:
        return np.sin(angle), np.cos(angle)


def namespace(*values: Any) -> Any:
    """Return `drjit` if any of the values is a Dr.Jit array, else NumPy under the same names.

    Dr.Jit is looked up among the modules that are loaded already: nobody can hold one of its arrays without
    it.
    """
    drjit = sys.modules.get("drjit")
    if drjit is not None and any(drjit.is_array_v(value) for value in values):
        return drjit
    return _NumPy


def root(value: Any) -> Any:
    """Square root of a value >= 0 whose derivative at 0 is 0, not infinite."""
    xp = namespace(value)
    return xp.select(value > 0.0, xp.sqrt(xp.maximum(value, 1e-30)), 0.0)


def plain(value: Any) -> Any:
    """Turn a NumPy result without axes into a Python float; leave everything else alone."""
    return float(value) if isinstance(value, (np.floating, np.ndarray)) and np.ndim(value) == 0 else value
