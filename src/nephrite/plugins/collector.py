"""Python's garbage collector, kept off while kernels are recorded.

Dr.Jit dispatches a call over the instances that exist when it is recorded. If the collector removes old scenes on the
way, a kernel may get one function twice ("invalid redefinition"), and LLVM ends the process: seen with Dr.Jit 1.5.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def kept_off() -> Iterator[None]:
    """Collect nothing in a `with` block, or in a function of which this is the decorator."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
