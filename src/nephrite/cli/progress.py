"""The progress bar: how far a render is, the time left, and the noise reached so far."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nephrite.rendering.result import Progress

Listener = Callable[["Progress"], None]


@contextmanager
def shown(title: str, quiet: bool = False) -> Iterator[Listener | None]:
    """Show a bar on the standard error stream while the block runs; yield what to call after each pass.

    Nothing is shown if `quiet`, or if that stream is no terminal.
    """
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[state]}"),
    )
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=1.0, state="compiling ...")

        def listen(progress: Progress) -> None:
            bar.update(task, completed=progress.fraction, state=state(progress))

        yield listen


def state(progress: Progress) -> str:
    """Return how far a render is in words: samples, noise so far, time left."""
    parts = [f"{progress.spp} spp" if progress.target is None else f"{progress.spp}/{progress.target} spp"]
    if math.isfinite(progress.noise):
        parts.append(f"noise {progress.noise:.2%}")
    if progress.remaining_s is not None:
        parts.append(f"{clock(progress.remaining_s)} left")
    return ", ".join(parts)


def clock(seconds: float) -> str:
    """Return a time as people read it: `8s`, `2m05s`, `1h02m`."""
    whole = max(0, round(seconds))
    if whole < 60:
        return f"{whole}s"
    if whole < 3600:
        return f"{whole // 60}m{whole % 60:02d}s"
    return f"{whole // 3600}h{whole % 3600 // 60:02d}m"
