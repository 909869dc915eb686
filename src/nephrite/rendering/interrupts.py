"""Ctrl-C between passes, not in the midst of one."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def postponed_interrupts() -> Iterator[threading.Event]:
    """Turn the first Ctrl-C into an event to look at between passes; the second one acts as usual.

    An exception in the midst of a pass could leave Dr.Jit's recording of the kernel half done. Where another
    handler is installed, or outside the main thread, nothing is changed.
    """
    event = threading.Event()
    usual = signal.getsignal(signal.SIGINT)
    here = threading.current_thread() is threading.main_thread() and usual is signal.default_int_handler

    def note(number: int, frame: Any) -> None:
        if event.is_set():
            signal.default_int_handler(number, frame)
        event.set()

    if here:
        signal.signal(signal.SIGINT, note)
    try:
        yield event
    finally:
        if here:
            signal.signal(signal.SIGINT, usual)
