"""Points Dr.Jit at an LLVM that it can use, before Mitsuba first starts it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from nephrite.errors import MissingDependencyError

OLDEST = 16
"""First major version of LLVM whose code generator knows all that Dr.Jit 1.5 asks for."""

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


def check_loaded(version: tuple[int, ...] | None) -> None:
    """Raise `MissingDependencyError` if Dr.Jit has loaded an LLVM that would abort the process.

    `version`: as `drjit.detail.llvm_version()` has it, major first; None if no LLVM is loaded.
    """
    if version and 0 < version[0] < OLDEST:
        raise MissingDependencyError(
            f"Dr.Jit has loaded LLVM {version[0]}, which would abort the process. Import nephrite before mitsuba, to "
            f"use the LLVM of this environment; or set {ENVIRONMENT_VARIABLE} to a libLLVM of version {OLDEST} or "
            "later; `nephrite doctor` shows which there are."
        )
