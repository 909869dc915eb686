"""Which cases of a test the quick run leaves out."""

from __future__ import annotations

from typing import Any

import pytest


def slow(*values: Any) -> Any:
    """Return the values of a case that takes long, or that others stand for."""
    return pytest.param(*values, marks=pytest.mark.slow)
