"""Points Dr.Jit at an LLVM that it can use, before Mitsuba first starts it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

ENVIRONMENT_VARIABLE = "DRJIT_LIBLLVM_PATH"


def packaged_library() -> Path | None:
    """Return the `libLLVM` that pip put into this environment (`karellen-llvm-core`), or None."""
    for name in ("libLLVM.so", "libLLVM.dylib"):
        path = Path(sys.prefix) / "lib" / name
        if path.exists():
            return path
    return None


def prefer_packaged() -> None:
    """Let the packaged LLVM win over the system's, unless the user has named one.

    The LLVM 14 and 15 of some distributions make Dr.Jit 1.5 abort the process.
    """
    library = packaged_library()
    if library is not None:
        os.environ.setdefault(ENVIRONMENT_VARIABLE, str(library))
